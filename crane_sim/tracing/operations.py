"""What equations call beside arithmetic: on floats it computes, on values it notes instructions."""

import ctypes
from collections.abc import Callable
from math import pow as _pow
from math import sqrt as _sqrt
from typing import Any

from crane_sim.tracing.graph import Graph, Kind, TraceError, Value, kind_of, numbers_of, unary
from crane_sim.tracing.trees import flatten, structure_of, unflatten

_LIBRARY: Any = ctypes.CDLL("libm.so.6")
for _name, _count in (("fma", 3), ("pow", 2), ("sqrt", 1)):
    _function = getattr(_LIBRARY, _name)
    _function.restype, _function.argtypes = ctypes.c_double, [ctypes.c_double] * _count


def graph_of(*numbers: Any) -> Graph | None:
    """Return the graph that the first value among numbers belongs to, None where all are floats."""
    for x in numbers:  # no generator: plain Python calls this for each operation on floats
        if isinstance(x, Value):
            return x.graph
    return None


def fma(a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once."""
    graph = graph_of(a, b, c)
    if graph is None:
        return _LIBRARY.fma(a, b, c)
    x, y, z = graph.lift(a), graph.lift(b), graph.lift(c)
    if z.literal == 0.0 or 0.0 in (x.literal, y.literal) or 1.0 in (x.literal, y.literal):
        return x * y + z  # exact products: rounded once as well
    return graph.append("fma", numbers_of((x, y, z)), (Kind.REAL,))[0]


def sqrt(x: Any) -> Any:
    """Return the square root of a number; of a negative one nan."""
    return unary("sqrt", x) if isinstance(x, Value) else _compute(_sqrt, "sqrt", x)


def power(x: Any, exponent: Any) -> Any:
    """Return x, positive, to the power of a number, as the C library computes it."""
    graph = graph_of(x, exponent)
    if graph is None:
        return _compute(_pow, "pow", x, exponent)
    return graph.append("power", numbers_of((graph.lift(x), graph.lift(exponent))), (Kind.REAL,))[0]


def _compute(function: Callable[..., float], name: str, *arguments: Any) -> float:
    """Return what a function returns, or the C library's infinity or nan where Python raises an error."""
    try:
        return function(*arguments)
    except (OverflowError, ValueError):
        return getattr(_LIBRARY, name)(*arguments)


def to_integer(x: Any) -> Any:
    """Return a whole number as an integer; of nan, and of 2^63 and above, what comes out means nothing."""
    if isinstance(x, Value):
        return x.graph.append("to_integer", (x.number,), (Kind.INTEGER,))[0]
    return int(x) if abs(x) < 2.0**63 else 0


def select(condition: Any, a: Any, b: Any) -> Any:
    """Return a where the condition holds, else b; numbers, or tuples of them.

    Both are computed: where one divides by 0, Python raises its error, so select the divisor, or `branch`.
    """
    if not isinstance(condition, Value):
        return a if condition else b
    if condition.literal is not None:
        return a if condition.literal else b
    condition = condition.graph.lift(condition, Kind.BOOLEAN)
    if isinstance(a, tuple):
        _check_structure("select", a, b)
        return unflatten(a, iter([select(condition, x, y) for x, y in zip(flatten(a), flatten(b), strict=True)]))
    x, y = _of_one_kind(condition.graph, a, b)
    if x.number == y.number:
        return x
    return condition.graph.append("select", numbers_of((condition, x, y)), (x.kind,))[0]


def branch(condition: Any, then: Callable[[], Any], otherwise: Callable[[], Any]) -> Any:
    """Return what one of two functions without arguments returns; only that one is evaluated.

    Raises:
        TraceError: their results differ in structure or in a kind.
    """
    literal = condition.literal if isinstance(condition, Value) else condition
    if literal is not None:
        return then() if literal else otherwise()
    graph, trees = condition.graph, []
    condition = graph.lift(condition, Kind.BOOLEAN)

    def record(function: Callable[[], Any]) -> Any:
        def values() -> tuple[Value, ...]:
            trees.append(function())
            return tuple(graph.lift(leaf, kind_of(leaf)) for leaf in flatten(trees[-1]))

        return graph.trace_block(values)

    blocks = record(then), record(otherwise)
    _check_structure("branch", *trees)
    kinds, others = (tuple(graph.kinds[number] for number in block.results) for block in blocks)
    if kinds != others:
        raise TraceError("branch: one side returns a number of another kind than the other; an integer is no real")
    return unflatten(trees[0], iter(graph.append("branch", (condition.number,), kinds, blocks)))


def _check_structure(operation: str, a: Any, b: Any) -> None:
    if structure_of(a) != structure_of(b):
        raise TraceError(f"{operation}: two results differ in structure")


def _of_one_kind(graph: Graph, a: Any, b: Any) -> tuple[Value, Value]:
    kind = next((x.kind for x in (a, b) if isinstance(x, Value)), kind_of(a))
    return graph.lift(a, kind), graph.lift(b, kind)
