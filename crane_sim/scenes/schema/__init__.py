"""The forms of scene files: what each kind of crane's file may hold, and the model that it describes."""
