"""Sine and cosine, and functions of floats that have no value."""

import math

import numpy as np

from crane_sim.tracing.elementary import sincos
from crane_sim.tracing.function import trace
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.operations import fma, power, sqrt


def test_called_with_floats_it_computes() -> None:
    """The same function is its own interpreter."""
    f = trace(lambda x, y: (fma(x, y, 1.0), sincos(x)[0]), (Kind.REAL, Kind.REAL), "f")
    assert f(2.0, 3.0) == (7.0, sincos(2.0)[0])


def test_floats_that_are_none_raise_no_error() -> None:
    """As in the code, an infinity or nan comes out of what has no value: a run that diverges ends with a status."""
    assert all(math.isnan(x) for x in (*sincos(math.nan), *sincos(math.inf), sqrt(-1.0), power(-1.0, 0.5)))
    assert (power(0.0, -1.0), power(1e200, 2.0)) == (math.inf,) * 2


def test_sine_and_cosine_are_within_a_digit_of_the_c_library() -> None:
    """Sine and cosine are within 2.3e-16, one digit of 1, of the C library's, up to 1e5 rad."""
    for angle in np.random.default_rng(1).uniform(-1e5, 1e5, 20000).tolist():
        s, c = sincos(angle)
        assert abs(s - math.sin(angle)) <= 2.3e-16 and abs(c - math.cos(angle)) <= 2.3e-16
