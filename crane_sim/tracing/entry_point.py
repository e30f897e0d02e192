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
from crane_sim.tracing.arguments import FORMATS, describe, kinds_of, pack, rebuild_symbols
from crane_sim.tracing.calls import Calls
from crane_sim.tracing.code_cache import read_entry, write_entry
from crane_sim.tracing.compile_time import COMPILE_TIMER
from crane_sim.tracing.frame import read_leaves, write_leaves
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.llvm import module_text
from crane_sim.tracing.machine_code import LoadedCode, Optimisation, compile_text
from crane_sim.tracing.results import make_builder, take_result
from crane_sim.tracing.trace_error import TraceError

INTERPRETED = os.environ.get("CRANE_SIM_INTERPRETED") == "1"
"""Whether entry points run as plain Python."""


class Code(NamedTuple):
    """Machine code of an entry point for one structure of arguments."""

    object_file: bytes
    results: tuple[Kind, ...]  # of the numbers and addresses that it returns
    structure: Any  # of what it returns


def compile_entry(function: types.FunctionType, key: Any) -> tuple[Code, set[types.FunctionType]]:
    """Return (the code of a function for arguments of a structure, the functions that are in it).

    Raises:
        TraceError: it does what is not traced.
    """
    graph, calls, kinds, results = Graph(), Calls(), kinds_of(key), list[Kind]()
    structure: list[Any] = []

    def run(source: Value, target: Value) -> tuple[Value, ...]:
        arguments = rebuild_symbols(key, iter(read_leaves(source, kinds)))
        result = calls.call_traced(graph, function, list(arguments), {}, True)
        stored: list[Value] = []
        structure.append(take_result(result, stored, graph))
        results.extend(leaf.kind for leaf in stored)
        write_leaves(target, stored)
        return ()

    block = graph.trace_block(run, (Kind.ARRAY, Kind.ARRAY))
    graph.has_allocations = True
    entry = Function("entry", function, graph, block, None, False, False)
    machine_code = compile_text(module_text(entry), getattr(function, "optimisation", Optimisation.FULL))
    return Code(machine_code, tuple(results), structure[0]), calls.functions


class Call:
    """Memory of one call at a time: of arguments, as far as they are those of the call before, and of results.

    Attributes:
        keys: structure of each argument.
    """

    def __init__(self, count: int) -> None:
        """Begin without arguments."""
        self.keys: list[Any] = [UNKNOWN] * count
        self.arguments: list[Any] = [UNKNOWN] * count
        self.shapes: list[Any] = [None] * count  # of arrays, which may be set
        self.parts: list[bytes] = [b""] * count
        self.arrays: list[dict[int, Any]] = [{}] * count  # of each argument, by address
        self.large: list[int] = []  # arguments whose arrays would take much memory until the next call

    def take(self, arguments: tuple[Any, ...], results: dict[int, Any]) -> bool:
        """Take the arguments of a call; return whether they have the structure of those before.

        Args:
            arguments: an object that is the one before has its structure and its numbers: tuples do not change, and
                arrays stay where they are.
            results: of the last call, by their identity: (object, structure, bytes, arrays by their addresses).
        """
        same = True
        for i, argument in enumerate(arguments):
            if argument is self.arguments[i] and getattr(argument, "shape", None) == self.shapes[i]:
                continue
            found = results.get(id(argument))
            if found is not None and found[0] is argument:
                _, key, part, arrays = found
            else:
                leaves, arrays = list[Any](), dict[int, Any]()
                key = describe(argument, leaves, arrays)
                part = pack(key, leaves)
            self.arrays[i], self.parts[i] = arrays, part
            if _is_large(arrays):
                self.large.append(i)
            self.arguments[i], self.shapes[i] = argument, getattr(argument, "shape", None)
            if key != self.keys[i]:
                self.keys[i] = key
                same = False
        return same

    def forget_large_arrays(self) -> None:
        """Forget arguments with arrays that would take much memory until the next call."""
        for i in self.large:
            self.arguments[i], self.arrays[i] = UNKNOWN, {}
        self.large.clear()


UNKNOWN = object()
_KEPT = 1_000_000  # bytes of arrays of one argument, or of a result, that are kept for the next call


def _is_large(arrays: dict[int, Any]) -> bool:
    return sum([array.nbytes for array in arrays.values()]) > _KEPT


class _Runner:
    """Calls machine code."""

    def __init__(self, code: Code) -> None:
        self._build, self._parts = make_builder(code.structure, code.results)
        self._output = struct.Struct("=" + "".join(FORMATS[kind] for kind in code.results))
        self._library = LoadedCode(code.object_file)
        prototype = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_void_p)
        self._run: Any = prototype(self._library.address("entry"))
        self._release: Any = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(self._library.address("release"))
        self._size = self._output.size
        self._buffers: list[Any] = []  # for results; several threads may call

    def __call__(self, call: Call) -> tuple[Any, dict[int, Any]]:
        """Return the result of a call, and its parts as `Call.take` takes them."""
        size = self._size
        buffer, target = self._buffers.pop() if self._buffers else self._new_buffer()
        memory = target + size
        self._run(b"".join(call.parts), target, memory)
        raw = buffer.raw
        taken: list[Any] = []
        result = self._build(self._output.unpack_from(raw), call.arrays, taken)
        if raw[size:] != _NOTHING:
            self._release(memory)
        self._buffers.append((buffer, target))
        arrays: dict[int, Any] = {}
        if taken:
            data = bytearray(raw)
            for index, address, array in taken:
                arrays[address] = array
                _ADDRESS.pack_into(data, 8 * index, address)
            raw = bytes(data)
            if _is_large(arrays):
                return result, {}
        return result, {id(result[i]): (result[i], key, raw[a:b], arrays) for i, key, a, b in self._parts}

    def _new_buffer(self) -> tuple[Any, int]:
        buffer = ctypes.create_string_buffer(self._size + 8)
        return buffer, ctypes.addressof(buffer)


_ADDRESS = struct.Struct("=Q")
_NOTHING = bytes(8)  # the address of no memory


class EntryPoint:
    """A function that runs as machine code."""

    def __init__(self, function: types.FunctionType) -> None:
        """Compile nothing yet."""
        self.py_func, self.__wrapped__ = function, function
        self.__name__, self.__doc__, self.__module__ = function.__name__, function.__doc__, function.__module__
        self.__qualname__ = function.__qualname__
        self._runners: dict[Any, _Runner] = {}
        self._count, self._defaults = function.__code__.co_argcount, function.__defaults__ or ()
        self._calls: list[tuple[Call, Any]] = []  # that are not under way, each with the code of its structure
        self._results: dict[int, Any] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Run.

        Raises:
            SceneError: it does what is not compiled.
        """
        missing = self._count - len(arguments)
        if INTERPRETED or missing < 0 or missing > len(self._defaults):
            return self.py_func(*arguments)  # which says what is wrong with their number
        if missing:
            arguments += self._defaults[-missing:]
        call, runner = self._calls.pop() if self._calls else (Call(self._count), None)
        if not call.take(arguments, self._results) or runner is None:
            runner = self._find_runner((tuple, *call.keys))
        result, self._results = runner(call)
        call.forget_large_arrays()
        self._calls.append((call, runner))
        return result

    def __reduce__(self) -> str:
        """Return the name that another process finds it by."""
        return self.__qualname__

    def _find_runner(self, key: Any) -> _Runner:
        runner = self._runners.get(key)
        if runner is None:
            runner = self._runners[key] = _Runner(self._find_code(key))
        return runner

    def _find_code(self, key: Any) -> Code:
        code = read_entry(self.py_func, key)
        if isinstance(code, Code):
            return code
        try:
            with COMPILE_TIMER:
                code, functions = compile_entry(self.py_func, key)
        except (TraceError, RecursionError) as error:  # of a law of the user's
            raise SceneError(f"cannot be compiled: {error}") from error
        write_entry(self.py_func, key, code, functions)
        return code

    @property
    def signatures(self) -> list[Any]:
        """The structures of arguments that code has been made or loaded for."""
        return list(self._runners)
