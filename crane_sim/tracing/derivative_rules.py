"""Rules of forward mode: by operation, the partial derivatives of its result by each of its operands.

A slope that is infinite counts as 0: it is that of a length, or of an angle, where a length vanishes, and what is made
of it, such as |v| v, has a derivative there. So has |x| at 0, the mean of both sides.
"""

from collections.abc import Callable
from typing import Any

from crane_sim.tracing.graph import Value, unary
from crane_sim.tracing.operations import power, select, sqrt

Slope = Callable[..., Any]
"""Of the result and the operands."""


def _function(name: str, x: Value) -> Value:
    return unary(name, x)


def _copy_sign(size: Any, x: Value) -> Value:
    graph = x.graph
    return graph.append("copy_sign", (graph.lift(size).number, x.number), (x.kind,))[0]


def _inverse(x: Value) -> Value:
    """Return 1 / x, 0 of 0."""
    return select(x == 0.0, 0.0, 1.0 / select(x == 0.0, 1.0, x))


def _one(*_: Any) -> float:
    return 1.0


def _of_absolute(_: Value, x: Value) -> Value:
    return select(x == 0.0, 0.0, _copy_sign(1.0, x))


def _of_power(_: Value, x: Value, exponent: Value) -> Value:
    slope = exponent * power(select(x == 0.0, 1.0, x), exponent - 1.0)
    at_zero = select(exponent == 1.0, 1.0, 0.0)  # an infinite slope counts as 0
    return select(x == 0.0, at_zero, slope)


def _of_exponent(r: Value, x: Value, _: Value) -> Value:
    return select(x > 0.0, r * _function("log", select(x > 0.0, x, 1.0)), 0.0)


def _whole_quotient(r: Value, x: Value, y: Value) -> Value:
    return _function("round", (r - x) / y)


def _of_first_sign(_: Value, x: Value, y: Value) -> Value:
    return _copy_sign(1.0, x) * _copy_sign(1.0, y)


RULES: dict[str, tuple[Slope, ...]] = {
    "add": (_one, _one),
    "subtract": (_one, lambda *_: -1.0),
    "multiply": (lambda r, a, b: b, lambda r, a, b: a),
    "divide": (lambda r, a, b: 1.0 / b, lambda r, a, b: -r / b),
    "negate": (lambda *_: -1.0,),
    "fma": (lambda r, a, b, c: b, lambda r, a, b, c: a, _one),
    "absolute": (_of_absolute,),
    "copy_sign": (_of_first_sign, lambda *_: 0.0),
    "sqrt": (lambda r, x: 0.5 * _inverse(r),),
    "exp": (lambda r, x: r,),
    "log": (lambda r, x: 1.0 / x,),
    "sin": (lambda r, x: _function("cos", x),),
    "cos": (lambda r, x: -_function("sin", x),),
    "tan": (lambda r, x: 1.0 + r * r,),
    "asin": (lambda r, x: _inverse(sqrt((1.0 - x) * (1.0 + x))),),
    "acos": (lambda r, x: -_inverse(sqrt((1.0 - x) * (1.0 + x))),),
    "atan": (lambda r, x: 1.0 / (1.0 + x * x),),
    "sinh": (lambda r, x: _function("cosh", x),),
    "cosh": (lambda r, x: _function("sinh", x),),
    "tanh": (lambda r, x: (1.0 - r) * (1.0 + r),),
    "hypot": (lambda r, x, y: x * _inverse(r), lambda r, x, y: y * _inverse(r)),
    "atan2": (lambda r, y, x: x * _inverse(x * x + y * y), lambda r, y, x: -y * _inverse(x * x + y * y)),
    "power": (_of_power, _of_exponent),
    "fmod": (_one, _whole_quotient),
}
FLAT = {"floor", "ceil", "round", "to_real"}
"""Operations whose results are constant between jumps."""
