"""Functions that Python calls and that run as machine code, traced once for each structure of their arguments."""

import ctypes
import struct
import types
from pathlib import Path
from typing import Any

import numpy as np

from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol, contiguous_strides
from crane_sim.tracing.calls import Calls
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, Kind, TraceError, Value
from crane_sim.tracing.llvm import module_text
from crane_sim.tracing.machine_code import Library
from crane_sim.tracing.merging import rebuilt

_FORMATS = {Kind.REAL: "d", Kind.INTEGER: "q", Kind.WORD: "Q", Kind.BOOLEAN: "?7x", Kind.ARRAY: "Q"}
_CODES = {Kind.REAL: "f8", Kind.INTEGER: "i8", Kind.WORD: "u8", Kind.BOOLEAN: "b1", Kind.ARRAY: "p8"}


def describe(tree: Any, leaves: list[Any]) -> Any:
    """Return a tree's structure, hashable, and append its numbers, addresses and sizes to `leaves`."""
    if isinstance(tree, float):
        leaves.append(tree)
        return Kind.REAL
    if isinstance(tree, tuple):
        return type(tree), *[describe(part, leaves) for part in tree]
    if tree is None:
        return None
    if isinstance(tree, bool | np.bool_):
        leaves.append(tree)
        return Kind.BOOLEAN
    if isinstance(tree, np.uint64):
        leaves.append(int(tree))
        return Kind.WORD
    if isinstance(tree, int | np.integer):
        leaves.append(int(tree))
        return Kind.INTEGER
    if isinstance(tree, np.record):
        leaves.append(tree.__array_interface__["data"][0])
        return np.record, tree.dtype
    if isinstance(tree, np.ndarray):
        leaves.append(tree.__array_interface__["data"][0])
        leaves += tree.shape
        if not tree.flags.c_contiguous:
            leaves += tree.strides
        return np.ndarray, tree.dtype, tree.ndim, tree.flags.c_contiguous
    return type(tree), tree


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
        shape = tuple(next(leaves) for _ in range(ndim))
        strides = contiguous_strides(shape, dtype.itemsize) if contiguous else tuple(next(leaves) for _ in range(ndim))
        return ArraySymbol(address, 0, dtype, shape, strides)
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
        return [Kind.ARRAY] + [Kind.INTEGER] * (parts[1] if parts[2] else 2 * parts[1])
    if kind is np.record:
        return [Kind.ARRAY]
    if issubclass(kind, tuple):
        return [leaf for part in parts for leaf in kinds_of(part)]
    return []


class Compiled:
    """Machine code of an entry point for one structure of arguments."""

    def __init__(self, function: types.FunctionType, key: Any, folder: Path | None) -> None:
        """Trace and compile."""
        self.kinds = kinds_of(key)
        self.calls = Calls()
        self.results: list[Kind] = []
        self.traced = self._trace(function, key)
        self.library = Library(self.traced, folder=folder)
        self._pack = struct.Struct("=" + "".join(_FORMATS[kind] for kind in self.kinds))
        self._unpack = struct.Struct("=" + "".join(_FORMATS[kind] for kind in self.results))
        self._input = ctypes.create_string_buffer(max(self._pack.size, 8))
        self._output = ctypes.create_string_buffer(max(self._unpack.size, 8))
        self._memory = ctypes.c_void_p(None)
        self._run = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(
            self.library.address(self.traced)
        )
        self._addresses = (
            ctypes.addressof(self._input), ctypes.addressof(self._output), ctypes.addressof(self._memory),
        )  # fmt: skip
        release = self.library._engine.get_function_address("release")
        self._release = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(release)

    def _trace(self, function: types.FunctionType, key: Any) -> Function:
        graph = Graph()

        def values(source: Value, target: Value) -> tuple[Value, ...]:
            leaves = [
                graph.append("read", (source.number,), (kind,), (8 * i, _CODES[kind]))[0]
                for i, kind in enumerate(self.kinds)
            ]
            arguments = rebuild_symbols(key, iter(leaves))
            result = self.calls.call_traced(graph, function, list(arguments), {}, True)
            stored: list[Value] = []
            self.structure = _describe_result(result, stored, graph)
            for i, leaf in enumerate(stored):
                self.results.append(leaf.kind)
                graph.append("write", (leaf.number, target.number), (), (8 * i, _CODES[leaf.kind]))
            return ()

        block = graph.trace_block(values, (Kind.ARRAY, Kind.ARRAY))
        graph.has_allocations = True
        return Function("entry", function, graph, block, None, False, False)

    def __call__(self, leaves: list[Any]) -> Any:
        """Return the result of a call."""
        self._pack.pack_into(self._input, 0, *leaves)
        self._run(*self._addresses)
        result = _rebuild_result(self.structure, iter(self._unpack.unpack_from(self._output)))
        if self._memory.value:
            self._release(self._addresses[2])
        return result


def _describe_result(tree: Any, leaves: list[Value], graph: Graph) -> Any:
    from crane_sim.tracing.merging import base_address

    if isinstance(tree, tuple):
        return rebuilt(tree, [_describe_result(part, leaves, graph) for part in tree])
    if isinstance(tree, ArraySymbol):
        leaves.append(base_address(graph, tree))
        for size in tree.shape:
            leaves.append(size if isinstance(size, Value) else graph.constant(size, Kind.INTEGER))
        return _ArrayResult(tree.dtype, len(tree.shape))
    if isinstance(tree, Value):
        leaves.append(tree)
        return _NUMBER
    return tree


class _ArrayResult:
    def __init__(self, dtype: np.dtype, ndim: int) -> None:
        self.dtype, self.ndim = dtype, ndim


_NUMBER = object()


def _rebuild_result(tree: Any, leaves: Any) -> Any:
    if tree is _NUMBER:
        return next(leaves)
    if isinstance(tree, tuple):
        parts = [_rebuild_result(part, leaves) for part in tree]
        return type(tree)(*parts) if hasattr(tree, "_fields") else tuple(parts)
    if isinstance(tree, _ArrayResult):
        address, shape = next(leaves), tuple(next(leaves) for _ in range(tree.ndim))
        array = np.empty(shape, tree.dtype)
        ctypes.memmove(array.ctypes.data, address, array.nbytes)
        return array
    return tree


class EntryPoint:
    """A function of Python that runs as machine code."""

    def __init__(self, function: types.FunctionType, folder: Path | None = None) -> None:
        """Compile nothing yet."""
        self.py_func, self.__name__, self.__doc__ = function, function.__name__, function.__doc__
        self.targetoptions: dict[str, Any] = {}
        self._folder = folder
        self._compiled: dict[Any, Compiled] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Run."""
        leaves: list[Any] = []
        key = describe(arguments, leaves)
        if key not in self._compiled:
            self._compiled[key] = Compiled(self.py_func, key, self._folder)
        return self._compiled[key](leaves)

    def text(self, *arguments: Any) -> str:
        """Return the code in LLVM's language."""
        key = describe(arguments, [])
        return module_text(Compiled(self.py_func, key, None).traced)
