"""Decorators of compiled functions; numba is imported here and in the arithmetic modules of this folder, nowhere else.

- `entry_point`: a function that Python calls; the packages' own are cached on disk as machine code.
- `kernel`: a function that only compiled code calls, inlined into every caller; `routine`: one that is not inlined.
- `generic`: a function with single dispatch: a kernel with one implementation for each type of its first argument, like
  functools.singledispatch, chosen at compile time.
- `lean_` before these: compiled without reference counting (LEAN), for functions that allocate and return no array.
- `routine_returning`: a routine that is lean where what it returns holds numbers only.
- `routine_generic`: `generic` with implementations that are not inlined; `stage_generic`: with implementations that are
  optimised before they are inlined, for what a step of an integrator holds many copies of (its stages).

A scene's physics is a tree of NamedTuples, and dispatch on their types is at compile time. Numba therefore
compiles exactly what a scene is made of, an absent part (None) costs nothing, and functions are never arguments, so
compiled code can be cached on disk.

Compiled code is cached in a folder named after a digest of every source file that it may come from (and of the versions
that produced it). It is read and written only while the files still have the digest of the time before the first kernel
was imported, so stale machine code is never executed. Code of other files, which the digest does not cover, is compiled
anew in each process: their entry points, and functions that are given types of theirs. Nothing is cached once such a
file implements a function of the packages for a type that is not its own.
"""

import functools
import gc
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Protocol

import numba
import numpy as np
from numba.core import config as numba_config
from numba.core import event, types
from numba.core.typing.templates import infer, infer_global, make_intrinsic_template
from numba.extending import intrinsic as _intrinsic
from numba.extending import overload

from crane_sim.numerics.cache import cache_folder
from crane_sim.numerics.checked_cache import CheckedCache, is_digested, note_implementation
from crane_sim.numerics.compile_time import COMPILE_TIMER
from crane_sim.numerics.linked_library import LinkedCompiler, OptimizedCompiler

Function = Callable[..., Any]
intrinsic: Any = _intrinsic
"""Marks a function that returns (signature, generator of LLVM instructions)."""


def lower_to(define: Function) -> Callable[[Function], Any]:
    """Return a decorator of a Python function that compiled code lowers to the instructions of `define`.

    An overload that numba inlines would do the same at a risk: numba then eliminates dead code, and takes a store for
    dead if the array has come out of a tuple, since it does not see that a caller holds the array, too.

    Args:
        define: as for `intrinsic`, with the parameters of the function after the typing context.
    """

    def decorate(f: Function) -> Function:
        template = make_intrinsic_template(f, define, f.__name__)
        infer(template)
        infer_global(f, types.Function(template))
        return f

    return decorate


OPTIONS: Any = {
    "error_model": "numpy",
    "forceinline": True,
    "no_cfunc_wrapper": True,
    "no_cpython_wrapper": True,
    "pipeline_class": LinkedCompiler,
    "_nrt": True,  # explicit: functions would inherit it from their first caller
}
"""Compile options of kernels: IEEE division, no reassociation, inlining into the caller."""
LEAN: Any = OPTIONS | {"_nrt": False}
"""Compile options without reference counting, for functions that allocate nothing and return numbers only: saves about
six nanoseconds for each array argument. An array that such a function returned, or received from a counted function,
would be freed twice, or never."""


def kernel(f: Function) -> Function:
    """Compile `f` as a function that is inlined into every caller."""
    return numba.njit(f, **OPTIONS)


def routine(f: Function) -> Function:
    """Compile `f` as a function that is not inlined: for long ones, whose copies would cost minutes to compile."""
    return numba.njit(f, **(OPTIONS | {"forceinline": False}))


def lean_kernel(f: Function) -> Function:
    """Compile `f` as an inlined function without reference counting, see LEAN."""
    return numba.njit(f, **LEAN)


def lean_routine(f: Function) -> Function:
    """Compile `f` as a function that is not inlined, without reference counting, see LEAN."""
    return numba.njit(f, **(LEAN | {"forceinline": False}))


def routine_returning(name: str) -> Callable[[Function], Function]:
    """Return a decorator of routines that return what their argument `name` is changed to: lean if it is all numbers.

    Whatever else the routine is given it must not return. Where that state is numbers, no function that it calls may
    return an array either: it would never be freed.
    """

    def decorate(f: Function) -> Function:
        at = f.__code__.co_varnames.index(name)
        for options, counts in ((OPTIONS, True), (LEAN, False)):

            def choose(*args: Any, counts: bool = counts) -> Function | None:
                return f if _is_all_numbers(args[at]) != counts else None

            overload(f, strict=False, jit_options=options | {"forceinline": False})(choose)
        return f

    return decorate


def _is_all_numbers(kind: Any) -> bool:
    """Return whether a value of this numba type is a number, None, or a tuple of these: nothing is counted in it."""
    if isinstance(kind, types.BaseTuple):
        return all(map(_is_all_numbers, getattr(kind, "types")))  # noqa: B009  (of each of its classes, not of its base)
    return isinstance(kind, types.Number | types.Boolean | types.NoneType)


def entry_point(f: Function) -> Function:
    """Compile `f` as a function that Python calls; machine code of the packages is cached on disk."""
    if os.environ.get("CRANE_TRACED"):
        from crane_sim.tracing.entry_point import EntryPoint

        return EntryPoint(f, cache_folder())
    dispatcher: Any = numba.njit(f, error_model="numpy", nogil=True)
    settings: Any = numba_config
    if not settings.DISABLE_JIT and is_digested(f):
        settings.CACHE_DIR, previous = str(cache_folder()), settings.CACHE_DIR
        with suppress(RuntimeError):  # a folder that cannot be written: each process compiles anew
            dispatcher._cache = CheckedCache(f)
        settings.CACHE_DIR = previous
    return dispatcher


class _CompilationListener(event.Listener):
    """Counts the time of compilations, and raises the threshold of garbage collection meanwhile.

    The compiler makes many objects, few of them in cycles: collections would take a sixth of its time, and free little.
    """

    def __init__(self) -> None:
        self._depth, self._usual = 0, gc.get_threshold()

    def on_start(self, event: Any) -> None:
        COMPILE_TIMER.__enter__()
        if not self._depth:
            self._usual = gc.get_threshold()
            gc.set_threshold(max(self._usual[0], 20_000) if self._usual[0] else 0, *self._usual[1:])
        self._depth += 1

    def on_end(self, event: Any) -> None:
        COMPILE_TIMER.__exit__()
        self._depth -= 1
        if not self._depth:
            gc.set_threshold(*self._usual)


event.register("numba:compile", _CompilationListener())


class _OnStart(event.Listener):
    """Event listener that calls a function at the start of an event."""

    def __init__(self, callback: Callable[[], object]) -> None:
        self._callback = callback

    def on_start(self, event: Any) -> None:
        self._callback()

    def on_end(self, event: Any) -> None:
        pass


@contextmanager
def watch_compiling(callback: Callable[[], object]) -> Iterator[None]:
    """Call `callback` whenever a function is compiled within the block, but not when one is loaded from the cache."""
    with event.install_listener("numba:compile", _OnStart(callback)):
        yield


class TypeDispatched(Protocol):
    """A function with single dispatch: its implementation depends on the type of its first argument."""

    def __call__(self, *args: Any) -> Any:
        """Call the implementation for these arguments."""
        ...

    def register(self, cls: type) -> Callable[[Function], Function]:
        """Return a decorator that adds the implementation for first arguments of class `cls`."""
        ...

    def has_implementation(self, cls: type) -> bool:
        """Return whether an implementation is registered for `cls`."""
        ...


def lean_generic(f: Function) -> TypeDispatched:
    """Return a `generic` function whose implementations are inlined, without reference counting."""
    return generic(f, LEAN)


def routine_generic(f: Function) -> TypeDispatched:
    """Return a `generic` function whose implementations are not inlined."""
    return generic(f, OPTIONS | {"forceinline": False})


def lean_routine_generic(f: Function) -> TypeDispatched:
    """Return a `generic` function whose implementations are not inlined, without reference counting."""
    return generic(f, LEAN | {"forceinline": False})


def stage_generic(f: Function) -> TypeDispatched:
    """Return a `generic` function whose implementations are optimised before they are inlined, once for all copies."""
    return generic(f, OPTIONS | {"pipeline_class": OptimizedCompiler})


def generic(f: Function, options: Any = OPTIONS) -> TypeDispatched:
    """Return a function with single dispatch on the type of its first argument, in Python and in compiled code alike.

    `f.register(Type)` adds the implementation for a NamedTuple class, for `tuple` (any other tuple), for `float`,
    `np.ndarray` or `type(None)` (the part is absent), as functools.singledispatch does. `f` is the default.
    """
    table = functools.singledispatch(f)
    implementations = _Implementations(table.dispatch)

    @functools.wraps(f)
    def call(*args: Any) -> Any:
        return implementations[type(args[0])](*args)

    def register(cls: type) -> Callable[[Function], Function]:
        def add(implementation: Function) -> Function:
            note_implementation(f, cls, implementation)
            implementations.clear()
            return table.register(cls)(implementation)

        return add

    def choose(*args: Any) -> Function:
        return table.dispatch(_python_type(args[0]))

    overload(call, strict=False, jit_options=options)(choose)
    generic_call: Any = call
    generic_call.register = register
    generic_call.dispatch, generic_call.inlined = table.dispatch, options.get("forceinline", False)
    generic_call.has_implementation = lambda cls: table.dispatch(cls) is not f
    return generic_call


class _Implementations(dict[type, Function]):
    """Implementations by class that were looked up: singledispatch's own cache takes as long as a small kernel."""

    def __init__(self, dispatch: Callable[[type], Function]) -> None:
        super().__init__()
        self._dispatch = dispatch

    def __missing__(self, cls: type) -> Function:
        implementation = self[cls] = self._dispatch(cls)
        return implementation


def _python_type(t: types.Type) -> type:
    """Return the Python class that the numba type `t` stands for."""
    if isinstance(t, types.NamedTuple | types.NamedUniTuple):
        return t.instance_class
    kinds = {types.BaseTuple: tuple, types.NoneType: type(None), types.Float: float, types.Integer: int}
    kinds |= {types.Array: np.ndarray}
    return next((python for kind, python in kinds.items() if isinstance(t, kind)), object)
