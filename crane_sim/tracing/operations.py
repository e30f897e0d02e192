"""What equations call and Python lacks, on floats; `builtin_functions` has it on symbols."""

import ctypes
import math
from typing import Any

_LIBRARY: Any = ctypes.CDLL("libm.so.6")
_LIBRARY.fma.restype, _LIBRARY.fma.argtypes = ctypes.c_double, [ctypes.c_double] * 3


def fma(a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once."""
    return _LIBRARY.fma(a, b, c)


def sqrt(x: Any) -> Any:
    """Return the square root of a number; of a negative one nan."""
    return math.nan if x < 0.0 else math.sqrt(x)


def to_integer(x: Any) -> Any:
    """Return a whole number as an integer, without meaning for nan and from 2^63 on."""
    return int(x) if abs(x) < 2.0**63 else 0


def select(condition: Any, a: Any, b: Any) -> Any:
    """Return the number a where the condition holds, else b; both have been computed."""
    return a if condition else b
