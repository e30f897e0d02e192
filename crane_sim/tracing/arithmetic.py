"""Arithmetic on symbols and numbers with Python's rules: integers become reals where they meet one.

No operation is left out or reordered: code that is traced has the bits of its run on floats, signs of zeros included.
"""

import math
import operator
from collections.abc import Callable
from typing import Any

from crane_sim.tracing.graph import Graph, Kind, TraceError, Value, kind_of
from crane_sim.tracing.operations import graph_of

_RANK = {Kind.BOOLEAN: 0, Kind.INTEGER: 1, Kind.WORD: 2, Kind.REAL: 3}
_NATIVE: dict[str, Callable[[Any, Any], Any]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "floor_divide": operator.floordiv,
    "modulo": operator.mod,
    "power": operator.pow,
    "both": operator.and_,
    "either": operator.or_,
    "differ": operator.xor,
    "shift_right": operator.rshift,
    "shift_left": operator.lshift,
    "less": operator.lt,
    "less_equal": operator.le,
    "greater": operator.gt,
    "greater_equal": operator.ge,
    "equal": operator.eq,
    "unequal": operator.ne,
}
"""What each operation is on numbers that are known while tracing."""
_MIRRORED = {"greater": "less", "greater_equal": "less_equal"}
_COMPARISONS = {"less", "less_equal", "equal", "unequal"}
_OF_BITS = {"both", "either", "differ", "shift_right", "shift_left"}


def is_symbol(x: Any) -> bool:
    """Return whether x is a number that is known only when the code runs."""
    return isinstance(x, Value)


def is_number(x: Any) -> bool:
    """Return whether x is a number, known or not."""
    return isinstance(x, Value | float | int) or hasattr(x, "__index__")


def convert(graph: Graph, x: Any, kind: Kind) -> Value:
    """Return a number as a value of a kind, rounded towards zero from a real to an integer.

    Raises:
        TraceError: there is no such conversion.
    """
    if not isinstance(x, Value):
        return graph.constant(_to_python(x, kind), kind)
    if x.kind is kind:
        return graph.lift(x, kind)
    path = (x.kind, kind)
    if path == (Kind.BOOLEAN, Kind.REAL):
        return convert(graph, convert(graph, x, Kind.INTEGER), Kind.REAL)
    if kind is Kind.BOOLEAN:
        return combine("unequal", x, 0)
    operation = {
        (Kind.INTEGER, Kind.REAL): "to_real",
        (Kind.WORD, Kind.REAL): "to_real",
        (Kind.REAL, Kind.INTEGER): "to_integer",
        (Kind.BOOLEAN, Kind.INTEGER): "flag_to_integer",
        (Kind.INTEGER, Kind.WORD): "to_word",
        (Kind.WORD, Kind.INTEGER): "word_to_integer",
    }.get(path)
    if operation is None:
        raise TraceError(f"a value of kind {x.kind.name} where one of kind {kind.name} is needed")
    return graph.append(operation, (x.number,), (kind,))[0]


def _to_python(x: Any, kind: Kind) -> Any:
    return {Kind.REAL: float, Kind.BOOLEAN: bool}.get(kind, int)(x)


def common_kind(*numbers: Any) -> Kind:
    """Return the kind that numbers have in common after conversion."""
    return max((number_kind(x) for x in numbers), key=_RANK.__getitem__)


def number_kind(x: Any) -> Kind:
    """Return the kind of a number, NumPy's words included."""
    return Kind.WORD if type(x).__name__ == "uint64" else kind_of(x)


def combine(operation: str, a: Any, b: Any) -> Any:
    """Return the result of a binary operation on two numbers, of which any may be symbols."""
    graph = graph_of(a, b)
    if graph is None:
        return _NATIVE[operation](a, b)
    if operation in _MIRRORED:
        return combine(_MIRRORED[operation], b, a)
    if operation == "power":
        return raise_to_power(graph, a, b)
    if operation == "floor_divide" or operation == "modulo":
        return divide_with_remainder(graph, operation, a, b)
    kind = Kind.REAL if operation == "divide" else common_kind(a, b)
    if kind is Kind.BOOLEAN and operation not in _OF_BITS and operation not in ("equal", "unequal"):
        kind = Kind.INTEGER
    x, y = convert(graph, a, kind), convert(graph, b, kind)
    result = Kind.BOOLEAN if operation in _COMPARISONS else kind
    return graph.append(operation, (x.number, y.number), (result,))[0]


def raise_to_power(graph: Graph, a: Any, b: Any) -> Any:
    """Return a to the power of b: of a whole number that is known, products by repeated squaring."""
    if isinstance(b, int) and 0 <= b < 64:
        return _whole_power(a, b)
    x, y = convert(graph, a, Kind.REAL), convert(graph, b, Kind.REAL)
    return graph.append("power", (x.number, y.number), (Kind.REAL,))[0]


def _whole_power(a: Any, exponent: int) -> Any:
    result = None
    while exponent:
        if exponent & 1:
            result = a if result is None else combine("multiply", result, a)
        exponent >>= 1
        if exponent:
            a = combine("multiply", a, a)
    return 1.0 if result is None else result


def divide_with_remainder(graph: Graph, operation: str, a: Any, b: Any) -> Any:
    """Return the quotient rounded down, or the remainder, which has the sign of b."""
    if common_kind(a, b) is Kind.REAL:
        return _real_division(graph, operation, a, b)
    x, y = convert(graph, a, Kind.INTEGER), convert(graph, b, Kind.INTEGER)
    quotient = graph.append("quotient", (x.number, y.number), (Kind.INTEGER,))[0]
    remainder = graph.append("remainder", (x.number, y.number), (Kind.INTEGER,))[0]
    below = combine("both", combine("unequal", remainder, 0), combine("less", combine("differ", remainder, y), 0))
    if operation == "modulo":
        return choose(below, combine("add", remainder, y), remainder)
    return choose(below, combine("subtract", quotient, 1), quotient)


def _real_division(graph: Graph, operation: str, a: Any, b: Any) -> Any:
    x, y = convert(graph, a, Kind.REAL), convert(graph, b, Kind.REAL)
    remainder = graph.append("fmod", (x.number, y.number), (Kind.REAL,))[0]
    below = combine("both", combine("unequal", remainder, 0.0),
                    combine("differ", combine("less", remainder, 0.0), combine("less", y, 0.0)))  # fmt: skip
    modulo = choose(below, combine("add", remainder, y), remainder)
    if operation == "modulo":
        return modulo
    quotient = combine("divide", combine("subtract", x, modulo), y)
    return graph.append("round", (quotient.number,), (Kind.REAL,))[0]


def choose(condition: Any, a: Any, b: Any) -> Any:
    """Return a where a condition holds, else b; both are numbers that have been computed."""
    if not isinstance(condition, Value):
        return a if condition else b
    graph, kind = condition.graph, common_kind(a, b)
    x, y, flag = convert(graph, a, kind), convert(graph, b, kind), convert(graph, condition, Kind.BOOLEAN)
    return graph.append("select", (flag.number, x.number, y.number), (kind,))[0]


def negate(x: Any) -> Any:
    """Return -x."""
    if not isinstance(x, Value):
        return -x
    x = convert(x.graph, x, Kind.INTEGER) if x.kind is Kind.BOOLEAN else x
    return x.graph.append("negate", (x.number,), (x.kind,))[0]


def invert(x: Any) -> Any:
    """Return whether a number, as a condition, does not hold."""
    if not isinstance(x, Value):
        return not x
    return combine("equal", x, False) if x.kind is Kind.BOOLEAN else combine("equal", x, 0)


def holds(x: Any) -> Any:
    """Return a number as a condition."""
    return convert(x.graph, x, Kind.BOOLEAN) if isinstance(x, Value) else bool(x)


def absolute(x: Any) -> Any:
    """Return |x|."""
    if not isinstance(x, Value):
        return abs(x)
    if x.kind is Kind.REAL:
        return x.graph.append("absolute", (x.number,), (Kind.REAL,))[0]
    return choose(combine("less", x, 0), negate(x), x)


def smallest(*numbers: Any) -> Any:
    """Return what Python's min does of numbers."""
    return _extreme(lambda x, least: combine("less", x, least), numbers)


def largest(*numbers: Any) -> Any:
    """Return what Python's max does of numbers."""
    return _extreme(lambda x, most: combine("greater", x, most), numbers)


def _extreme(better: Callable[[Any, Any], Any], numbers: tuple[Any, ...]) -> Any:
    graph, kind = graph_of(*numbers), common_kind(*numbers)
    if graph is None:
        return min(numbers) if better(0, 1) else max(numbers)
    result = convert(graph, numbers[0], kind)
    for x in numbers[1:]:
        result = choose(better(x, result), x, result)
    return result


def call_function(name: str, *numbers: Any) -> Any:
    """Return a function of reals, of the processor or the C library, by its name in `llvm`; of a float by `math`."""
    graph = graph_of(*numbers)
    if graph is None:
        return getattr(math, name)(*numbers)
    return graph.append(name, tuple(convert(graph, x, Kind.REAL).number for x in numbers), (Kind.REAL,))[0]
