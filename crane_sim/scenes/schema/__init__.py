"""The forms of scene files: what each kind of crane's file may hold, and the model that it describes.

A form is a pydantic model, the schema of one kind of file; its nested groups are pydantic models, too.
"""
