"""Nested tuples of numbers."""

from typing import Any


def rebuilt(like: tuple[Any, ...], parts: Any) -> tuple[Any, ...]:
    """Return a tuple of the class of another one."""
    return type(like)(*parts) if hasattr(like, "_fields") else tuple(parts)
