"""Arithmetic on symbols and numbers with Python's rules: integers become reals where they meet one.

No operation is left out or reordered: code that is traced has the bits of its run on floats, signs
of zeros included. In the packages' own functions, not in those of users, the integers 0 and 1 are
structure where they meet a real: 0 x is the integer 0, and 0 + x and 1 x are x, which may differ
from the run on floats by the sign of a zero.
"""

import ctypes
import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from crane_sim.tracing.graph import Graph, Kind, TraceError, Value, kind_of

_LIBRARY: Any = ctypes.CDLL("libm.so.6")
RANK = {Kind.ARRAY: -1, Kind.BOOLEAN: 0, Kind.INTEGER: 1, Kind.WORD: 2, Kind.REAL: 3}
"""Which kind numbers of two kinds are converted to: the higher one."""
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
_NUMBERS: Any = (Value, float, int, np.number, np.bool_)
_SCALARS: Any = np.generic
_WORDS: Any = np.uint64
_MIRRORED = {"greater": "less", "greater_equal": "less_equal"}
_COMPARISONS = {"less", "less_equal", "equal", "unequal"}
_CONVERSIONS = {
    (Kind.INTEGER, Kind.REAL): "to_real",
    (Kind.WORD, Kind.REAL): "to_real",
    (Kind.REAL, Kind.INTEGER): "to_integer",
    (Kind.BOOLEAN, Kind.INTEGER): "flag_to_integer",
    (Kind.INTEGER, Kind.WORD): "to_word",
    (Kind.WORD, Kind.INTEGER): "word_to_integer",
}
_STRUCTURAL = {"add", "subtract", "multiply", "divide"}
_OF_FLAGS = {"both", "either", "differ", "equal", "unequal"}
_KEEP_NATURAL = {"multiply", "both", "either", "differ", "shift_right"}
_OPERATORS = {
    **dict(
        add="a sum",
        subtract="a difference",
        multiply="a product",
        divide="a quotient",
        power="a power",
    ),
    **dict(floor_divide="a quotient", modulo="a remainder", both="&", either="|", differ="^"),
    **dict(shift_right=">>", shift_left="<<", equal="a comparison", unequal="a comparison"),
    **dict(
        less="a comparison",
        less_equal="a comparison",
        greater="a comparison",
        greater_equal="a comparison",
    ),
}


def graph_of(*numbers: Any) -> Graph | None:
    """Return the graph that the first value among numbers belongs to, None where all are known."""
    for x in numbers:  # no generator: this is called for each operation
        if isinstance(x, Value):
            return x.graph
    return None


def is_number(x: Any) -> bool:
    """Return whether x is a number, known or not."""
    return isinstance(x, _NUMBERS)


def is_flag(x: Any) -> bool:
    """Return whether x is a condition, known or not."""
    return isinstance(x, (bool, np.bool_)) or (isinstance(x, Value) and x.kind is Kind.BOOLEAN)


def is_natural(x: Any) -> bool:
    """Return whether x is an integer that is known not to be negative."""
    least = least_of(x)
    return least is not None and least >= 0


def least_of(x: Any) -> int | None:
    """Return what an integer is known not to be less than, None where nothing is known."""
    return x.graph.least.get(x.number) if isinstance(x, Value) else int(x)


def convert(graph: Graph, x: Any, kind: Kind) -> Value:
    """Return a number as a value of a kind, rounded towards zero from a real to an integer.

    Raises:
        TraceError: there is no such conversion.
    """
    if not isinstance(x, Value):
        return graph.constant(_to_python(x, kind), kind)
    if x.graph is not graph:
        return graph.lift(x, kind)  # an error
    if x.kind is kind:
        return x
    path = (x.kind, kind)
    if path == (Kind.BOOLEAN, Kind.REAL):
        return convert(graph, convert(graph, x, Kind.INTEGER), Kind.REAL)
    if path in ((Kind.BOOLEAN, Kind.WORD), (Kind.REAL, Kind.WORD)):
        return convert(graph, convert(graph, x, Kind.INTEGER), kind)
    if kind is Kind.BOOLEAN:
        return combine("unequal", x, 0)
    operation = _CONVERSIONS.get(path)
    if operation is None:
        raise TraceError(f"a value of kind {x.kind.name} where one of kind {kind.name} is needed")
    result = graph.append(operation, (x.number,), (kind,))[0]
    if path == (Kind.BOOLEAN, Kind.INTEGER):
        graph.least[result.number] = 0
    return result


def _to_python(x: Any, kind: Kind) -> Any:
    return {Kind.REAL: float, Kind.BOOLEAN: bool}.get(kind, int)(x)


def common_kind(*numbers: Any) -> Kind:
    """Return the kind that numbers have in common after conversion."""
    common = number_kind(numbers[0])
    for x in numbers[1:]:
        kind = number_kind(x)
        if RANK[kind] > RANK[common]:
            common = kind
    return common


def number_kind(x: Any) -> Kind:
    """Return the kind of a number, NumPy's words included."""
    if isinstance(x, Value):
        return x.kind
    if isinstance(x, _WORDS):
        return Kind.WORD
    return kind_of(x.item()) if isinstance(x, _SCALARS) else kind_of(x)


def combine(operation: str, a: Any, b: Any) -> Any:
    """Return the result of a binary operation on two numbers, of which any may be symbols."""
    graph = graph_of(a, b)
    if graph is None:
        return _compute(operation, a, b)
    if operation in _MIRRORED:
        return combine(_MIRRORED[operation], b, a)
    if not (is_number(a) and is_number(b)):
        raise TraceError(
            f"{_OPERATORS[operation]} of a number and {_name_of(b if is_number(a) else a)} is not "
            "traced"
        )
    known = _structural(operation, a, b) if graph.structural else None
    if known is not None:
        return known
    if operation == "power":
        return raise_to_power(graph, a, b)
    if operation == "floor_divide" or operation == "modulo":
        return divide_with_remainder(graph, operation, a, b)
    kind = _kind_of_operands(operation, a, b)
    x, y = convert(graph, a, kind), convert(graph, b, kind)
    kind_of_result = Kind.BOOLEAN if operation in _COMPARISONS else kind
    result = graph.append(operation, (x.number, y.number), (kind_of_result,))[0]
    if kind is Kind.INTEGER:
        _note_least(operation, a, b, result)
    return result


def _kind_of_operands(operation: str, a: Any, b: Any) -> Kind:
    """Return the kind to which an operation's numbers are converted."""
    kind = Kind.REAL if operation == "divide" else common_kind(a, b)
    if kind is Kind.BOOLEAN and operation not in _OF_FLAGS:
        return Kind.INTEGER
    return kind


def _structural(operation: str, a: Any, b: Any) -> Any:
    """Return the result, for free, where an operand is the integer 0 or 1 of structure, or None."""
    first, second = (x if type(x) is int else None for x in (a, b))
    if (
        (first is None and second is None)
        or operation not in _STRUCTURAL
        or common_kind(a, b) is not Kind.REAL
    ):
        return None
    if operation == "multiply":
        if first == 0 or second == 0:
            return 0
        return b if first == 1 else a if second == 1 else None
    if operation == "divide":
        return 0 if first == 0 else a if second == 1 else None
    if second == 0:
        return a
    if first == 0:
        return b if operation == "add" else negate(b)
    return None


def _note_least(operation: str, a: Any, b: Any, result: Value) -> None:
    least, other = least_of(a), least_of(b)
    if operation == "add" and least is not None and other is not None:
        result.graph.least[result.number] = least + other
    elif operation == "subtract" and least is not None and not isinstance(b, Value):
        result.graph.least[result.number] = least - int(b)
    elif operation in _KEEP_NATURAL and is_natural(a) and is_natural(b):
        result.graph.least[result.number] = 0


def _compute(operation: str, a: Any, b: Any) -> Any:
    try:
        result = _NATIVE[operation](a, b)
        return call_library("pow", (a, b)) if isinstance(result, complex) else result
    except OverflowError:
        return call_library("pow", (a, b))
    except ZeroDivisionError:  # as the code has it, which raises no errors
        if common_kind(a, b) is not Kind.REAL and operation != "divide":
            return 0
        with np.errstate(all="ignore"):
            return float(_NATIVE[operation](np.float64(a), np.float64(b)))


def _name_of(x: Any) -> str:
    return "an array" if hasattr(x, "dtype") else type(x).__name__


def raise_to_power(graph: Graph, a: Any, b: Any) -> Any:
    """Return a to the power of b; of a known whole number by repeated squaring."""
    if isinstance(b, int) and 0 <= b < 64:
        return _whole_power(combine("add", a, 0) if is_flag(a) else a, b)
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
    return (1.0 if a.kind is Kind.REAL else 1) if result is None else result


def divide_with_remainder(graph: Graph, operation: str, a: Any, b: Any) -> Any:
    """Return the quotient rounded down, or the remainder with the sign of b; integers by 0: 0."""
    kind = common_kind(a, b)
    if kind is Kind.REAL:
        return _divide_reals(graph, operation, a, b)
    kind = kind if kind is Kind.WORD else Kind.INTEGER
    x, y, divisor = convert(graph, a, kind), convert(graph, b, kind), b
    if isinstance(
        b, Value
    ):  # a division by 0, and of the least integer by -1, would end the process
        divisor = choose(combine("equal", y, 0), 1, y)
        divisor = divisor if kind is Kind.WORD else choose(combine("equal", y, -1), 1, divisor)
    elif b in (0, -1):
        divisor = 1
    numbers = x.number, convert(graph, divisor, kind).number
    if operation == "modulo":
        result = _shifted_remainder(graph, kind, numbers, y)
    else:
        result = _rounded_quotient(graph, kind, numbers, y)
        result = result if kind is Kind.WORD else choose(combine("equal", y, -1), negate(x), result)
    result = choose(combine("equal", y, 0), 0, result)
    if kind is Kind.INTEGER and is_natural(b) and (operation == "modulo" or is_natural(a)):
        graph.least[result.number] = 0
    return result


def _shifted_remainder(graph: Graph, kind: Kind, numbers: tuple[int, int], y: Value) -> Value:
    remainder = graph.append("remainder", numbers, (kind,))[0]
    return (
        remainder
        if kind is Kind.WORD
        else choose(_needs_shift(remainder, y), combine("add", remainder, y), remainder)
    )


def _rounded_quotient(graph: Graph, kind: Kind, numbers: tuple[int, int], y: Value) -> Value:
    quotient = graph.append("quotient", numbers, (kind,))[0]
    if kind is Kind.WORD:
        return quotient
    remainder = graph.append("remainder", numbers, (kind,))[0]
    return choose(_needs_shift(remainder, y), combine("subtract", quotient, 1), quotient)


def _needs_shift(remainder: Value, y: Value) -> Any:
    """Return whether a remainder, rounded towards zero, has another sign than the divisor."""
    return combine(
        "both",
        combine("unequal", remainder, 0),
        combine("less", combine("differ", remainder, y), 0),
    )


def _divide_reals(graph: Graph, operation: str, a: Any, b: Any) -> Any:
    """Return what Python's floats have as quotient, rounded down, or as remainder."""
    x, y = convert(graph, a, Kind.REAL), convert(graph, b, Kind.REAL)
    remainder = call_function("fmod", x, y)
    whole = combine("equal", remainder, 0.0)
    shifted = combine(
        "both",
        combine("differ", combine("less", remainder, 0.0), combine("less", y, 0.0)),
        combine("unequal", remainder, 0.0),
    )
    modulo = choose(shifted, combine("add", remainder, y), remainder)
    if operation == "modulo":
        return choose(whole, call_function("copy_sign", 0.0, y), modulo)
    quotient = combine("divide", combine("subtract", x, remainder), y)
    quotient = choose(shifted, combine("subtract", quotient, 1.0), quotient)
    rounded = call_function("floor", quotient)
    rounded = choose(
        combine("greater", combine("subtract", quotient, rounded), 0.5),
        combine("add", rounded, 1.0),
        rounded,
    )
    ratio = combine("divide", x, y)
    result = choose(
        combine("equal", quotient, 0.0), call_function("copy_sign", 0.0, ratio), rounded
    )
    # as NumPy has it; Python raises an error
    return choose(combine("equal", y, 0.0), ratio, result)


def choose(condition: Any, a: Any, b: Any) -> Any:
    """Return a where a condition holds, else b; both are numbers that have been computed."""
    if not isinstance(condition, Value):
        return a if condition else b
    graph, kind = condition.graph, common_kind(a, b)
    x, y, flag = (
        convert(graph, a, kind),
        convert(graph, b, kind),
        convert(graph, condition, Kind.BOOLEAN),
    )
    result = graph.append("select", (flag.number, x.number, y.number), (kind,))[0]
    if kind is Kind.INTEGER and is_natural(a) and is_natural(b):
        graph.least[result.number] = 0
    return result


def negate(x: Any) -> Any:
    """Return -x."""
    if not isinstance(x, Value):
        return -x
    x = convert(x.graph, x, Kind.INTEGER) if x.kind is Kind.BOOLEAN else x
    return x.graph.append("negate", (x.number,), (x.kind,))[0]


def invert(x: Any) -> Any:
    """Return whether a condition does not hold."""
    x = holds(x)
    return combine("equal", x, False) if isinstance(x, Value) else not x


def holds(x: Any) -> Any:
    """Return a number as a condition."""
    return convert(x.graph, x, Kind.BOOLEAN) if isinstance(x, Value) else bool(x)


def absolute(x: Any) -> Any:
    """Return |x|."""
    if not isinstance(x, Value):
        return abs(x)
    if x.kind in (Kind.WORD, Kind.BOOLEAN):
        return combine("add", x, 0)
    if x.kind is Kind.REAL:
        return x.graph.append("absolute", (x.number,), (Kind.REAL,))[0]
    return choose(combine("less", x, 0), negate(x), x)


def smallest(*numbers: Any) -> Any:
    """Return what Python's min does of numbers."""
    return _extreme(lambda x, least: combine("less", x, least), numbers)


def largest(*numbers: Any) -> Any:
    """Return what Python's max does of numbers."""
    result = _extreme(lambda x, most: combine("greater", x, most), numbers)
    if isinstance(result, Value) and result.kind is Kind.INTEGER and any(map(is_natural, numbers)):
        result.graph.least[result.number] = 0
    return result


def _extreme(better: Callable[[Any, Any], Any], numbers: tuple[Any, ...]) -> Any:
    if not all(map(is_number, numbers)):
        raise TraceError("min or max of more than numbers is not traced")
    graph, kind = graph_of(*numbers), common_kind(*numbers)
    if graph is None:
        return min(numbers) if better(0, 1) else max(numbers)
    result = convert(graph, numbers[0], kind)
    for x in numbers[1:]:
        result = choose(better(x, result), x, result)
    return result


def _call_native(name: str, numbers: tuple[Any, ...]) -> float:
    """Return a function of known reals as the code does: by the C library where Python fails."""
    if name == "copy_sign":
        return math.copysign(*numbers)
    try:
        return getattr(math, name)(*numbers)
    except (ArithmeticError, AttributeError, ValueError):
        return call_library({"power": "pow"}.get(name, name), numbers)


def call_library(name: str, numbers: tuple[Any, ...]) -> float:
    """Return a function of the C library."""
    function = getattr(_LIBRARY, name)
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * len(numbers)
    return function(*numbers)


def call_function(name: str, *numbers: Any) -> Any:
    """Return a function of reals by its name in `llvm`, of the processor or the C library.

    Of a float it is computed by `math`.
    """
    graph = graph_of(*numbers)
    if graph is None:
        return _call_native(name, numbers)
    return graph.append(
        name, tuple(convert(graph, x, Kind.REAL).number for x in numbers), (Kind.REAL,)
    )[0]


def _operator(operation: str) -> Callable[[Any, Any], Any]:
    return lambda a, b: combine(operation, a, b)


for _name, _operation in {
    "add": "add",
    "sub": "subtract",
    "mul": "multiply",
    "truediv": "divide",
}.items():
    setattr(Value, f"__{_name}__", _operator(_operation))
    setattr(Value, f"__r{_name}__", lambda b, a, _operation=_operation: combine(_operation, a, b))
for _name, _operation in {"lt": "less", "gt": "greater"}.items():
    setattr(Value, f"__{_name}__", _operator(_operation))
Value.__eq__ = lambda a, b: combine("equal", a, b) if is_number(b) else NotImplemented
Value.__neg__ = negate  # type: ignore[attr-defined]
"""What the rules of derivatives are written with; the interpreter calls the functions
themselves."""
