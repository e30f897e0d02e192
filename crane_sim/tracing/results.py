"""What an entry point returns: its structure, made of the numbers and addresses of a call."""

import ctypes
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from crane_sim.tracing.arithmetic import convert, number_kind
from crane_sim.tracing.array_symbols import ArraySymbol
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.merging import base_address
from crane_sim.tracing.trees import rebuilt


class _Number:
    """The place of a number."""


class _Array(NamedTuple):
    """The place of an array."""

    dtype: np.dtype
    dimensions: int


def take_result(tree: Any, leaves: list[Value], graph: Graph) -> Any:
    """Return the structure of a result, and append its numbers, addresses and sizes to `leaves`."""
    if isinstance(tree, tuple):
        return rebuilt(tree, [take_result(part, leaves, graph) for part in tree])
    if isinstance(tree, list):
        return tuple([take_result(part, leaves, graph) for part in tree])
    if isinstance(tree, ArraySymbol):
        leaves.append(base_address(graph, tree))
        sizes = (*tree.shape, *tree.strides)
        leaves += [
            size if isinstance(size, Value) else graph.constant(size, Kind.INTEGER)
            for size in sizes
        ]
        return _Array(tree.dtype, len(tree.shape))
    if isinstance(tree, Value | float | int):
        kind = number_kind(tree)
        leaves.append(convert(graph, tree, kind))
        return _Number
    return tree


def make_builder(structure: Any) -> Callable[..., Any]:
    """Return a function that makes the result of a call.

    Its arguments are the numbers of the result and, for each argument of the call, the arrays by
    their addresses. It is one expression of Python: a call for each tuple would take longer than
    the code that is called.
    """
    builder = _Builder()
    text = builder.expression(structure)
    return eval(f"lambda v, arrays: {text}", builder.names)


class _Builder:
    """Writes the expression of a result."""

    def __init__(self) -> None:
        self.place = 0  # of the next number
        self.names: dict[str, Any] = {"new": tuple.__new__, "take": _take_array}

    def expression(self, structure: Any) -> str:
        """Return the expression of a part."""
        if structure is _Number:
            self.place += 1
            return f"v[{self.place - 1}]"
        if isinstance(structure, _Array):
            first, n = self.place, structure.dimensions
            sizes = [f"v[{first + 1 + i}], " for i in range(2 * n)]
            self.place += 1 + len(sizes)
            shape, strides = "".join(sizes[:n]), "".join(sizes[n:])
            return (
                f"take(arrays, {self._name(structure.dtype)}, v[{first}], ({shape}), ({strides}))"
            )
        if isinstance(structure, tuple):
            inner = "".join(f"{self.expression(part)}, " for part in structure)
            plain = f"({inner})"
            return (
                plain
                if type(structure) is tuple
                else f"new({self._name(type(structure))}, {plain})"
            )
        return self._name(structure)

    def _name(self, value: Any) -> str:
        name = f"n{len(self.names)}"
        self.names[name] = value
        return name


def _take_array(
    arguments: dict[int, dict[int, Any]],
    dtype: np.dtype,
    address: int,
    shape: tuple[int, ...],
    strides: tuple[int, ...],
) -> Any:
    """Return the array at an address: one of the arguments', or a new one with a copy."""
    for arrays in arguments.values():
        found = arrays.get(address)
        if (
            found is not None
            and found.shape == shape
            and found.strides == strides
            and found.dtype == dtype
        ):
            return found
    array = np.empty(shape, dtype)
    if array.strides == strides:
        ctypes.memmove(_address(array), address, array.nbytes)
    else:
        array[...] = _view(dtype, address, shape, strides)
    return array


def _address(array: Any) -> int:
    """Return where the elements of a new array are, faster than NumPy does."""
    return ctypes.addressof(ctypes.c_char.from_buffer(array)) if array.size else array.ctypes.data


def _view(
    dtype: np.dtype, address: int, shape: tuple[int, ...], strides: tuple[int, ...]
) -> np.ndarray:
    if 0 in shape:
        return np.empty(shape, dtype)
    reach = [(n - 1) * stride for n, stride in zip(shape, strides, strict=True)]
    before = -sum([min(x, 0) for x in reach])  # bytes of elements before the first one
    size = before + sum([max(x, 0) for x in reach]) + dtype.itemsize
    memory: Any = (ctypes.c_char * size).from_address(address - before)
    return np.ndarray(shape, dtype, memory, before, strides)
