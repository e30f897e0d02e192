"""What an entry point returns: its structure, and the result made of the numbers and addresses of a call."""

import ctypes
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from crane_sim.tracing.array_symbols import ArraySymbol
from crane_sim.tracing.graph import Graph, Kind, TraceError, Value
from crane_sim.tracing.merging import base_address, rebuilt


class _Number:
    """The place of a number."""


class _Array(NamedTuple):
    """The place of an array."""

    dtype: np.dtype
    dimensions: int


def take_result(tree: Any, leaves: list[Value], graph: Graph) -> Any:
    """Return the structure of a result, and append its numbers, addresses and sizes to `leaves`.

    Raises:
        TraceError: an array of the result is a part of a larger one.
    """
    if isinstance(tree, tuple):
        return rebuilt(tree, [take_result(part, leaves, graph) for part in tree])
    if isinstance(tree, list):
        return [take_result(part, leaves, graph) for part in tree]
    if isinstance(tree, ArraySymbol):
        if tree.strides and not isinstance(tree.strides[-1], Value) and tree.strides[-1] != tree.dtype.itemsize:
            raise TraceError("a column of an array is returned: return a copy")
        leaves.append(base_address(graph, tree))
        leaves += [size if isinstance(size, Value) else graph.constant(size, Kind.INTEGER) for size in tree.shape]
        return _Array(tree.dtype, len(tree.shape))
    if isinstance(tree, Value):
        leaves.append(tree)
        return _Number
    return tree


def rebuild_result(structure: Any, leaves: Iterator[Any]) -> Any:
    """Return the result of a call; arrays are copied from the memory of the call."""
    if structure is _Number:
        return next(leaves)
    if isinstance(structure, _Array):
        address, shape = next(leaves), tuple([next(leaves) for _ in range(structure.dimensions)])
        array = np.empty(shape, structure.dtype)
        ctypes.memmove(array.__array_interface__["data"][0], address, array.nbytes)
        return array
    if isinstance(structure, tuple):
        return rebuilt(structure, [rebuild_result(part, leaves) for part in structure])
    if isinstance(structure, list):
        return [rebuild_result(part, leaves) for part in structure]
    return structure
