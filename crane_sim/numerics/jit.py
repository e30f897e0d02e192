"""Functions that run as machine code.

A function of plain Python that an entry point calls is compiled with it: there is nothing to mark.
Called from Python it computes with floats. What may be said of a function:

- `entry_point`: Python calls it, and it runs as machine code, cached on disk.
- `optimisation`: an entry point that runs for some instants of a run only is compiled quickly, to
  slower code.
- `seldom_called`: an entry point whose first calls run as plain Python, as compiling takes longer
  than these.
- `routine`: it is not inlined into its callers: a long one, of which copies would cost time to
  compile.
- `generic`: it has single dispatch, one implementation for each type of its first argument, like
  functools.singledispatch; the type is known when a call is traced.
- `simd_range`: the turns of a loop are independent, and become lanes of vectors;
  `use_wide_vectors`: of the widest.

A scene's physics is a tree of NamedTuples, so code is exactly what a scene is made of, and an
absent part (None) leaves nothing in it.
"""

import functools
from collections.abc import Callable
from typing import Any, Protocol

from crane_sim.tracing.calls import forget_functions
from crane_sim.tracing.code_cache import note_implementation
from crane_sim.tracing.entry_point import EntryPoint
from crane_sim.tracing.machine_code import LIGHT as LIGHT
from crane_sim.tracing.machine_code import NONE as NONE
from crane_sim.tracing.machine_code import Optimisation
from crane_sim.tracing.vectors import local_array as local_array
from crane_sim.tracing.vectors import simd_range as simd_range
from crane_sim.tracing.vectors import use_wide_vectors as use_wide_vectors

Function = Callable[..., Any]


def entry_point(f: Any) -> EntryPoint:
    """Return `f` as a function that runs as machine code."""
    return EntryPoint(f)


def optimisation(level: Optimisation) -> Callable[[Function], Function]:
    """Return a decorator of an entry point's function, which is compiled with this optimisation."""

    def note(f: Function) -> Function:
        f.optimisation = level  # type: ignore[attr-defined]
        return f

    return note


def seldom_called(f: Function) -> Function:
    """Mark an entry point called for a few instants of a run: it is compiled at the ninth call."""
    f.plain_calls = 8  # type: ignore[attr-defined]
    return optimisation(NONE)(f)


def routine(f: Function) -> Function:
    """Mark a function that is not inlined."""
    f.inlined = False  # type: ignore[attr-defined]
    return f


class TypeDispatched(Protocol):
    """A function with single dispatch: the type of its first argument chooses the code."""

    def __call__(self, *args: Any) -> Any:
        """Call the implementation for these arguments."""
        ...

    def register(self, *classes: type) -> Callable[[Function], Function]:
        """Return a decorator that adds the implementation for first arguments of these classes."""
        ...

    def has_implementation(self, cls: type) -> bool:
        """Return whether an implementation is registered for `cls`."""
        ...


def generic(f: Function) -> TypeDispatched:
    """Return a function with dispatch on the type of its first argument, in Python and compiled.

    `f.register(Type, …)` adds the implementation for NamedTuple classes, for `tuple` (any other
    tuple), for `float`, `np.ndarray` or `type(None)` (the part is absent), as
    functools.singledispatch does. `f` is the default.
    """
    table = functools.singledispatch(f)
    implementations = _Implementations(table.dispatch)

    @functools.wraps(f)
    def call(*args: Any) -> Any:
        return implementations[type(args[0])](*args)

    def register(*classes: type) -> Callable[[Function], Function]:
        def add(implementation: Function) -> Function:
            implementations.clear()
            forget_functions()
            for cls in classes:
                note_implementation(f, cls, implementation)
                table.register(cls)(implementation)
            return implementation

        return add

    generic_call: Any = call
    generic_call.register, generic_call.dispatch = register, table.dispatch
    generic_call.has_implementation = lambda cls: table.dispatch(cls) is not f
    return generic_call


class _Implementations(dict[type, Function]):
    """Implementations by class that were looked up, faster than in singledispatch's own cache."""

    def __init__(self, dispatch: Callable[[type], Function]) -> None:
        super().__init__()
        self._dispatch = dispatch

    def __missing__(self, cls: type) -> Function:
        implementation = self[cls] = self._dispatch(cls)
        return implementation
