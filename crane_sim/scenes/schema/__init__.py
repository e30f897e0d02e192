"""The schemas of scene files: what a file of each kind of crane may hold, and its model.

A schema is a pydantic model of one kind of file; its nested groups are pydantic models, too.
"""
