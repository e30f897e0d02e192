"""Arguments of an entry point: their structure, for which code is made, numbers and addresses."""

import struct
import sys
from functools import cache
from types import FunctionType
from typing import Any

import numpy as np

from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol, contiguous_strides
from crane_sim.tracing.instructions import Kind

_FORMATS = {Kind.REAL: "d", Kind.INTEGER: "q", Kind.WORD: "Q", Kind.BOOLEAN: "?7x", Kind.ARRAY: "Q"}


@cache
def struct_of(kinds: tuple[Kind, ...]) -> struct.Struct:
    """Return the format of leaves of these kinds, as a call passes them."""
    return struct.Struct("=" + "".join(_FORMATS[kind] for kind in kinds))


def describe(tree: Any, leaves: list[Any], arrays: dict[int, Any]) -> Any:
    """Return a tree's structure, hashable.

    Args:
        tree: nested tuples of numbers, arrays and other objects.
        leaves: to which its numbers, addresses and sizes are appended.
        arrays: to which its arrays are added by their addresses.
    """
    if isinstance(tree, float):
        leaves.append(tree)
        return Kind.REAL
    if isinstance(tree, tuple):
        return type(tree), *[describe(part, leaves, arrays) for part in tree]
    if tree is None:
        return None
    if isinstance(tree, np.ndarray | np.record):
        return _describe_array(tree, leaves, arrays)
    for classes, kind in _NUMBERS:
        if isinstance(tree, classes):
            leaves.append(int(tree))
            return kind
    return type(tree), tree


_NUMBERS: Any = (
    ((bool, np.bool_), Kind.BOOLEAN),
    (np.uint64, Kind.WORD),
    ((int, np.integer), Kind.INTEGER),
)


def _describe_array(array: Any, leaves: list[Any], arrays: dict[int, Any]) -> Any:
    address = array.__array_interface__["data"][0]
    leaves.append(address)
    if isinstance(array, np.record):
        return np.record, array.dtype
    arrays[address] = array
    leaves += array.shape
    leaves += array.strides
    return np.ndarray, array.dtype, array.ndim, array.flags.c_contiguous


def rebuild_symbols(key: Any, leaves: Any) -> Any:
    """Return the tree of symbols of a structure."""
    if isinstance(key, Kind):
        return next(leaves)
    if key is None:
        return None
    kind, *parts = key
    if kind is np.ndarray:
        dtype, ndim, contiguous = parts
        address = next(leaves)
        shape, strides = (tuple([next(leaves) for _ in range(ndim)]) for _ in range(2))
        address.graph.least.update((size.number, 0) for size in shape)
        known = contiguous_strides(shape, dtype.itemsize) if contiguous else strides
        return ArraySymbol(address, 0, dtype, shape, known)
    if kind is np.record:
        return RecordSymbol(next(leaves), 0, parts[0])
    if issubclass(kind, tuple):
        values = [rebuild_symbols(part, leaves) for part in parts]
        return kind(*values) if hasattr(kind, "_fields") else tuple(values)
    return parts[0]


def kinds_of(key: Any) -> list[Kind]:
    """Return the kinds of the leaves of a structure."""
    if isinstance(key, Kind):
        return [key]
    if key is None:
        return []
    kind, *parts = key
    if kind is np.ndarray:
        return [Kind.ARRAY] + [Kind.INTEGER] * 2 * parts[1]
    if kind is np.record:
        return [Kind.ARRAY]
    if issubclass(kind, tuple):
        return [leaf for part in parts for leaf in kinds_of(part)]
    return []


def text_of(key: Any) -> str:
    """Return a structure as a text that is the same in every process."""
    if isinstance(key, Kind):
        return key.value
    if isinstance(key, tuple):
        return f"({', '.join(map(text_of, key))})"
    if isinstance(key, type):
        return f"{key.__module__}.{key.__qualname__}{getattr(key, '_fields', '')}"
    if (
        isinstance(key, FunctionType)
        and getattr(sys.modules.get(key.__module__), key.__qualname__, None) is key
    ):
        return f"{key.__module__}.{key.__qualname__}"  # any other one has an address in its text
    return str(key.descr) if isinstance(key, np.dtype) else repr(key)
