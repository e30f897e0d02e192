"""Functions that Python calls as machine code, traced once per structure of their arguments.

The code of a structure is kept in a folder of the user's (`code_cache`). It is the source's own, so
Python can run a function as it stands instead: with CRANE_SIM_INTERPRETED=1 it does.
"""

import gc
import os
import types
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from math import inf
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.tracing.arguments import describe, kinds_of, rebuild_symbols
from crane_sim.tracing.calls import Calls
from crane_sim.tracing.code_cache import read_entry, write_entry
from crane_sim.tracing.compile_time import COMPILE_TIMER
from crane_sim.tracing.foreign_call import FIRST, Call, Code, LoadedEntry
from crane_sim.tracing.frame import read_leaves, write_leaves
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.llvm import module_text, module_texts
from crane_sim.tracing.machine_code import Optimisation, compile_text
from crane_sim.tracing.memory import RELEASE, allocates
from crane_sim.tracing.results import take_result
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import rebuilt

INTERPRETED = os.environ.get("CRANE_SIM_INTERPRETED") == "1"
"""Whether entry points run as plain Python."""
# bytes of arrays of one argument, or of a result, that are kept for the next call of anyone
_KEPT = 1_000_000

_MOST_LOADED = 24
"""Structures whose code an entry point keeps in memory, half a megabyte each."""


def compile_entry(function: types.FunctionType, key: Any) -> tuple[Code, set[types.FunctionType]]:
    """Return (the code of a function for arguments of a structure, the functions that are in it).

    Raises:
        TraceError: it does what is not traced.
    """
    graph, calls, kinds, results = Graph(), Calls(), kinds_of(key), list[Kind]()
    structure: list[Any] = []

    def run(memory: Value) -> tuple[Value, ...]:
        arguments = rebuild_symbols(key, iter(read_leaves(memory, kinds, FIRST)))
        result = calls.call_traced(graph, function, list(arguments), {}, True)
        stored: list[Value] = []
        structure.append(take_result(result, stored, graph))
        results.extend(leaf.kind for leaf in stored)
        write_leaves(memory, stored, FIRST + 8 * len(kinds))
        return ()

    block = graph.trace_block(run, (Kind.ARRAY,))
    graph.has_allocations = True
    entry = Function("entry", function, graph, block, False)
    optimisation = getattr(function, "optimisation", Optimisation.FULL)
    text, loops = (
        module_texts(entry) if optimisation is Optimisation.FULL else (module_text(entry), "")
    )
    machine_code = compile_text(text + _RUN, optimisation, loops)
    return Code(machine_code, tuple(results), structure[0], allocates(block)), calls.functions


_RUN = f"""{RELEASE}
define void @run(ptr %memory) nounwind {{
 call void @entry(ptr %memory, ptr %memory)
 ret void
}}
"""


@contextmanager
def _without_collection() -> Iterator[None]:
    """Collect no garbage within the block: a trace's objects live on, and searching takes long."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _without_numpy(result: Any) -> Any:
    """Return a result with numbers of Python in place of NumPy's, as compiled code returns them."""
    if isinstance(result, tuple):
        return rebuilt(result, [_without_numpy(part) for part in result])
    return (
        result.item()
        if isinstance(result, np.generic) and not isinstance(result, np.record)
        else result
    )


class EntryPoint:
    """A function that runs as machine code."""

    def __init__(self, function: types.FunctionType) -> None:
        """Compile nothing yet."""
        self.py_func, self.__wrapped__ = function, function
        self.__name__, self.__doc__, self.__module__ = (
            function.__name__,
            function.__doc__,
            function.__module__,
        )
        self.__qualname__ = function.__qualname__
        self._loaded: dict[Any, LoadedEntry] = {}
        self._plain_calls: dict[Any, int] = {}  # that ran as plain Python
        self._shared: EntryPoint | None = None  # the one that this is of with calls of its own
        self._count, self._defaults = function.__code__.co_argcount, function.__defaults__ or ()
        self._calls: list[Call] = []  # that are not under way; several threads may call

    def __call__(self, *arguments: Any) -> Any:
        """Run.

        Raises:
            SceneError: it does what is not compiled.
        """
        return self.py_func(*arguments) if INTERPRETED else self.run(*arguments)

    def run(self, *arguments: Any) -> Any:
        """Run compiled, where entry points are interpreted, too.

        Raises:
            SceneError: it does what is not compiled.
        """
        missing = self._count - len(arguments)
        if missing < 0 or missing > len(self._defaults):
            return self.py_func(*arguments)  # which says what is wrong with their number
        if missing:
            arguments += self._defaults[-missing:]
        try:
            call = self._calls.pop()
        except IndexError:
            call = None
        if call is None or not call.take(arguments):
            return self._call_anew(arguments)
        result = call.run()
        self._calls.append(call)
        return result

    def with_own_calls(self) -> "EntryPoint":
        """Return the function for one caller whose arguments hardly change."""
        own = EntryPoint(self.py_func)
        own._loaded, own._shared = self._loaded, self._shared or self
        return own

    def __reduce__(self) -> Any:
        """Return the name that another process finds it by."""
        return (
            self.__qualname__
            if self._shared is None
            else (EntryPoint.with_own_calls, (self._shared,))
        )

    def _call_anew(self, arguments: tuple[Any, ...]) -> Any:
        """Return the result of a call with another structure of arguments than before."""
        key = describe(arguments, [], {})
        loaded = self._loaded.pop(key, None) or self._load(key)
        if loaded is None:
            with (
                suppress(Exception),
                np.errstate(all="ignore"),
            ):  # where Python raises an error, code computes
                return _without_numpy(self.py_func(*arguments))
            loaded = self._load(key, True)
            assert loaded is not None
        self._loaded[key] = loaded
        if len(self._loaded) > _MOST_LOADED:
            self._loaded.pop(list(self._loaded)[0], None)  # whose last new call is longest ago
        call = Call(loaded, _KEPT if self._shared is None else inf)
        call.take(arguments)
        result = call.run()
        self._calls.append(call)
        return result

    def _load(self, key: Any, at_once: bool = False) -> LoadedEntry | None:
        """Return loaded code, None where a function that is seldom called is not compiled yet."""
        calls, most = self._plain_calls.get(key, 0), getattr(self.py_func, "plain_calls", 0)
        code = read_entry(self.py_func, key) if calls in (0, most) else None
        if not isinstance(code, Code):
            if not at_once and calls < most:
                self._plain_calls[key] = calls + 1
                return None
            code = self._compile(key)
        return LoadedEntry(code, key[1:])

    def _compile(self, key: Any) -> Code:
        try:
            with COMPILE_TIMER, _without_collection():
                code, functions = compile_entry(self.py_func, key)
        except (TraceError, RecursionError) as error:  # of a law of the user's
            raise SceneError(f"cannot be compiled: {error}") from error
        write_entry(self.py_func, key, code, functions)
        return code

    @property
    def signatures(self) -> list[Any]:
        """The structures of arguments that code has been made or loaded for."""
        return list(self._loaded)
