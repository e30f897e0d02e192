"""Nested tuples of numbers, and the flat lists that blocks and calls pass."""

from typing import Any


def flatten(tree: Any) -> list[Any]:
    """Return the leaves of nested tuples, from left to right; None is no leaf."""
    if tree is None:
        return []
    if isinstance(tree, tuple):
        return [leaf for part in tree for leaf in flatten(part)]
    return [tree]


def rebuilt(like: tuple[Any, ...], parts: Any) -> tuple[Any, ...]:
    """Return a tuple of the class of another one."""
    return type(like)(*parts) if hasattr(like, "_fields") else tuple(parts)


def unflatten(tree: Any, leaves: Any) -> Any:
    """Return the tree with its leaves replaced by those of an iterator, as many as there are."""
    if tree is None:
        return None
    if isinstance(tree, tuple):
        return rebuilt(tree, [unflatten(part, leaves) for part in tree])
    return next(leaves)


def structure_of(tree: Any) -> Any:
    """Return a tree's shape, equal for two trees exactly when their leaves stand at the same places."""
    if isinstance(tree, tuple):
        return (type(tree), *map(structure_of, tree))
    return tree is None
