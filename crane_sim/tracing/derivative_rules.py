"""Rules of forward mode: partial derivatives of each operation by each of its operands.

A slope that is infinite counts as 0: it is that of a length, or of an angle, where a length
vanishes, and what is made of it, such as |v| v, has a derivative there. So has |x| at 0, the mean
of both sides.
"""

from collections.abc import Callable
from typing import Any

from crane_sim.tracing.arithmetic import call_function, choose

Slope = Callable[..., Any]
"""Of the result and the operands."""


def _inverse(x: Any) -> Any:
    """Return 1 / x, 0 of 0."""
    return choose(x == 0.0, 0.0, 1.0 / choose(x == 0.0, 1.0, x))


def _one(*_: Any) -> float:
    return 1.0


def _of_absolute(_: Any, x: Any) -> Any:
    return choose(x == 0.0, 0.0, call_function("copy_sign", 1.0, x))


def _of_power(_: Any, x: Any, exponent: Any) -> Any:
    slope = exponent * call_function("power", choose(x == 0.0, 1.0, x), exponent - 1.0)
    at_zero = choose(exponent == 1.0, 1.0, 0.0)  # an infinite slope counts as 0
    return choose(x == 0.0, at_zero, slope)


def _of_exponent(r: Any, x: Any, _: Any) -> Any:
    return choose(x > 0.0, r * call_function("log", choose(x > 0.0, x, 1.0)), 0.0)


def _whole_quotient(r: Any, x: Any, y: Any) -> Any:
    return call_function("round", (r - x) / y)


def _of_first_sign(_: Any, x: Any, y: Any) -> Any:
    return call_function("copy_sign", 1.0, x) * call_function("copy_sign", 1.0, y)


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
    "sin": (lambda r, x: call_function("cos", x),),
    "cos": (lambda r, x: -call_function("sin", x),),
    "tan": (lambda r, x: 1.0 + r * r,),
    "asin": (lambda r, x: _inverse(call_function("sqrt", (1.0 - x) * (1.0 + x))),),
    "acos": (lambda r, x: -_inverse(call_function("sqrt", (1.0 - x) * (1.0 + x))),),
    "atan": (lambda r, x: 1.0 / (1.0 + x * x),),
    "sinh": (lambda r, x: call_function("cosh", x),),
    "cosh": (lambda r, x: call_function("sinh", x),),
    "tanh": (lambda r, x: (1.0 - r) * (1.0 + r),),
    "hypot": (lambda r, x, y: x * _inverse(r), lambda r, x, y: y * _inverse(r)),
    "atan2": (
        lambda r, y, x: x * _inverse(x * x + y * y),
        lambda r, y, x: -y * _inverse(x * x + y * y),
    ),
    "power": (_of_power, _of_exponent),
    "fmod": (_one, _whole_quotient),
}
FLAT = {"floor", "ceil", "round", "to_real"}
"""Operations whose results are constant between jumps."""
