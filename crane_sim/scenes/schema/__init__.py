"""The schemas of scene files: what each kind of crane's file may hold, and the model that it describes.

A schema is a pydantic model of one kind of file; its nested groups are pydantic models, too.
"""
