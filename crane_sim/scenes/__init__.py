"""Scenes: files checked by schema, and the models, methods and laws that they come to."""
