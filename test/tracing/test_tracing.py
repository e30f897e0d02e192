"""Sine and cosine, and what is traced where it may not exist."""

import math

import numpy as np
import pytest

from crane_sim.numerics.elementary import sincos
from crane_sim.tracing.arithmetic import combine
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.operations import sqrt
from crane_sim.tracing.trace_error import TraceError


def test_floats_that_are_none_raise_no_error() -> None:
    """What has no value is nan, as in compiled code: a run that diverges ends with a status."""
    assert all(math.isnan(x) for x in (*sincos(math.nan), *sincos(math.inf), sqrt(-1.0)))


def test_sine_and_cosine_are_within_a_digit_of_the_c_library() -> None:
    """Sine and cosine are within 2.3e-16, one digit of 1, of the C library's, up to 1e5 rad."""
    for angle in np.random.default_rng(1).uniform(-1e5, 1e5, 20000).tolist():
        s, c = sincos(angle)
        assert abs(s - math.sin(angle)) <= 2.3e-16 and abs(c - math.cos(angle)) <= 2.3e-16


def test_what_a_block_computes_stays_in_it() -> None:
    """A value from inside a branch or loop that is not its result is refused outside."""
    graph, found = Graph(), list[Value]()

    def compute(x: Value) -> tuple[Value, ...]:
        found.append(combine("multiply", x, x))
        return (found[-1],)

    graph.trace_block(compute, (Kind.REAL,))
    with pytest.raises(TraceError, match="used outside"):
        combine("add", found[0], 1.0)
