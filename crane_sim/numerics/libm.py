"""Elementary functions of arrays, by the C library, one element after the other.

NumPy's own take other instructions, with other last bits, on processors with AVX-512. What a seed
draws, and what a path is, are to be the same on every machine.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

Array = Any
"""An array of floats of any shape, or a float."""


def exp(x: Array) -> Array:
    """Return e to the power of x."""
    return _each(math.exp, x)


def power(x: Array, exponent: float) -> Array:
    """Return x, not negative, to the power of a number."""
    return _each(lambda value: math.pow(value, exponent), x)


def exponential(base: float, x: Array) -> Array:
    """Return a number, not negative, to the power of x."""
    return _each(lambda value: math.pow(base, value), x)


def sin(x: Array) -> Array:
    """Return the sine of x [rad]."""
    return _each(math.sin, x)


def cos(x: Array) -> Array:
    """Return the cosine of x [rad]."""
    return _each(math.cos, x)


def arctan(x: Array) -> Array:
    """Return the arctangent of x [rad]."""
    return _each(math.atan, x)


def geometric_sequence(first: float, last: float, count: int) -> Array:
    """Return `count` numbers (count,) in a geometric series from the first to the last one."""
    sequence = exponential(10.0, np.linspace(math.log10(first), math.log10(last), count))
    sequence[0], sequence[-1] = first, last
    return sequence


def _each(function: Callable[[float], float], x: Array) -> Array:
    flat = np.asarray(x, dtype=float)
    return np.array([function(value) for value in flat.ravel().tolist()]).reshape(flat.shape)
