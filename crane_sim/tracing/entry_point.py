"""Functions that Python calls and that run as machine code, traced once for each structure of their arguments.

The code of a structure is kept in a folder of the user's (`code_cache`). It is the source's own, so Python can run a
function as it stands instead: with CRANE_SIM_INTERPRETED=1 it does.
"""

import ctypes
import os
import struct
import types
from typing import Any, NamedTuple

from crane_sim.files.errors import SceneError
from crane_sim.tracing.arguments import describe, kinds_of, rebuild_symbols
from crane_sim.tracing.calls import Calls
from crane_sim.tracing.code_cache import read_entry, write_entry
from crane_sim.tracing.compile_time import COMPILE_TIMER
from crane_sim.tracing.frame import CODES
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, Kind, TraceError, Value
from crane_sim.tracing.llvm import module_text
from crane_sim.tracing.machine_code import LoadedCode, compile_text
from crane_sim.tracing.results import rebuild_result, take_result

_FORMATS = {Kind.REAL: "d", Kind.INTEGER: "q", Kind.WORD: "Q", Kind.BOOLEAN: "?7x", Kind.ARRAY: "Q"}


class Code(NamedTuple):
    """Machine code of an entry point for one structure of arguments."""

    object_file: bytes
    results: tuple[Kind, ...]  # of the numbers and addresses that it returns
    structure: Any  # of what it returns
    files: tuple[str, ...]  # that its functions are in


def compile_entry(function: types.FunctionType, key: Any) -> Code:
    """Trace and compile a function for arguments of a structure.

    Raises:
        TraceError: it does what is not traced.
    """
    graph, calls, kinds, results = Graph(), Calls(), kinds_of(key), list[Kind]()
    structure: list[Any] = []

    def run(source: Value, target: Value) -> tuple[Value, ...]:
        reads = [(source.number,), *kinds]
        leaves = [
            graph.append("read", reads[0], (kind,), (8 * i, CODES[kind]))[0] for i, kind in enumerate(kinds)
        ]  # fmt: skip
        result = calls.call_traced(graph, function, list(rebuild_symbols(key, iter(leaves))), {}, True)
        stored: list[Value] = []
        structure.append(take_result(result, stored, graph))
        for i, leaf in enumerate(stored):
            results.append(leaf.kind)
            graph.append("write", (leaf.number, target.number), (), (8 * i, CODES[leaf.kind]))
        return ()

    block = graph.trace_block(run, (Kind.ARRAY, Kind.ARRAY))
    graph.has_allocations = True
    entry = Function("entry", function, graph, block, None, False, False)
    return Code(compile_text(module_text(entry)), tuple(results), structure[0], tuple(sorted(calls.files)))


class _Runner:
    """Calls machine code."""

    def __init__(self, code: Code, kinds: list[Kind]) -> None:
        self._structure = code.structure
        self._input = struct.Struct("=" + "".join(_FORMATS[kind] for kind in kinds))
        self._output = struct.Struct("=" + "".join(_FORMATS[kind] for kind in code.results))
        self._library = LoadedCode(code.object_file)
        prototype = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_void_p)
        self._run: Any = prototype(self._library.address("entry"))
        self._release: Any = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(self._library.address("release"))
        self._buffers: list[Any] = []  # for results; several threads may call

    def __call__(self, leaves: list[Any]) -> Any:
        buffer = self._buffers.pop() if self._buffers else ctypes.create_string_buffer(self._output.size + 8)
        target = ctypes.addressof(buffer)
        memory = target + self._output.size
        self._run(self._input.pack(*leaves), target, memory)
        result = rebuild_result(self._structure, iter(self._output.unpack_from(buffer)))
        self._release(memory)
        self._buffers.append(buffer)
        return result


class EntryPoint:
    """A function that runs as machine code."""

    def __init__(self, function: types.FunctionType) -> None:
        """Compile nothing yet."""
        self.py_func, self.__wrapped__ = function, function
        self.__name__, self.__doc__, self.__module__ = function.__name__, function.__doc__, function.__module__
        self.__qualname__ = function.__qualname__
        self._interpreted = os.environ.get("CRANE_SIM_INTERPRETED") == "1"
        self._runners: dict[Any, _Runner] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Run.

        Raises:
            SceneError: it does what is not compiled.
        """
        if self._interpreted:
            return self.py_func(*arguments)
        leaves: list[Any] = []
        key = describe(arguments, leaves)
        runner = self._runners.get(key)
        if runner is None:
            runner = self._runners[key] = _Runner(self._find_code(key), kinds_of(key))
        return runner(leaves)

    def _find_code(self, key: Any) -> Code:
        code = read_entry(self.py_func, key)
        if isinstance(code, Code):
            return code
        try:
            with COMPILE_TIMER:
                code = compile_entry(self.py_func, key)
        except (TraceError, RecursionError) as error:  # of a law of the user's
            raise SceneError(f"cannot be compiled: {error}") from error
        write_entry(self.py_func, key, code)
        return code

    @property
    def signatures(self) -> list[Any]:
        """The structures of arguments that code has been made or loaded for."""
        return list(self._runners)
