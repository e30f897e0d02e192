"""Traced functions: what tracing notes, folds and refuses."""

import math

import numpy as np
import pytest

from crane_sim.tracing.elementary import sincos
from crane_sim.tracing.function import trace
from crane_sim.tracing.graph import Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.operations import (
    UNROLLED,
    branch,
    exp,
    fma,
    power,
    repeat,
    repeat_while,
    select,
    sqrt,
    to_integer,
    to_real,
)
from crane_sim.tracing.trace_error import TraceError

REAL, INTEGER, ARRAY = Kind.REAL, Kind.INTEGER, Kind.ARRAY


def operations_of(function, kinds=(REAL,)):
    """Return the names of the instructions that a function is traced into, constants left out."""
    block = trace(function, kinds, "f").block
    return [i.operation for i in block.instructions if i.operation != "constant"]


def test_literal_zeros_and_ones_leave_no_instruction() -> None:
    """What a model lacks, given as the literal 0, is not in the code."""
    assert operations_of(lambda x: (0.0 * x + x * 1.0 - 0.0) / 1.0 + fma(0.0, x, 0.0)) == []


def test_operations_on_constants_are_computed_while_tracing() -> None:
    """Arithmetic on literals is none in the code; a division by the literal 0 is left to it."""
    assert operations_of(lambda x: x + sqrt(4.0) * (3.0 - 1.0)) == ["add"]
    assert operations_of(lambda x: x + (x * 0.0 + 1.0) / 0.0) == ["divide", "add"]


def test_equal_expressions_are_computed_once() -> None:
    """An expression that stands twice is one instruction, in an inner block, too; products commute."""
    assert operations_of(lambda x, y: (x * y) * (y * x), (REAL, REAL)) == ["multiply", "multiply"]
    names = operations_of(lambda x: x * x + branch(x > 1.0, lambda: x * x, lambda: 1.0))
    assert names == ["multiply", "less", "branch", "add"]


def test_masses_are_arguments_and_structure_is_not() -> None:
    """A condition on what is known while tracing leaves one side; a loop of known length is unrolled."""
    assert operations_of(lambda x: select(True, x + 2.0, sqrt(x))) == ["add", "sqrt"]
    assert operations_of(lambda x: branch(False, lambda: sqrt(x), lambda: -x)) == ["negate"]
    assert operations_of(lambda x: repeat(3, lambda i, y: y * x, x)) == ["multiply"] * 3


def test_a_long_loop_of_known_length_is_one_where_its_graph_is_given() -> None:
    """Above the limit it stays a loop, up to it the turns are written out."""
    assert operations_of(lambda x: repeat(UNROLLED + 1, lambda i, y: y * x, x, x.graph)) == ["loop"]
    assert operations_of(lambda x: repeat(UNROLLED, lambda i, y: y * x, x, x.graph)) == ["multiply"] * UNROLLED


@pytest.mark.parametrize(
    "function",
    [
        lambda x: 1.0 if x > 0.0 else 2.0,
        lambda x: math.sqrt(x),
        lambda x: np.sin(x),
        lambda x: x**3,
        lambda x: max(x, 1.0),
        lambda x: x + "1",
        lambda x: branch(x > 0.0, lambda: (x, x), lambda: x),
        lambda x: repeat_while(lambda y: y[0] > 0.0, lambda y: (y[0], y[0]), (x,)),
        lambda x: repeat_while(lambda y: y[0] > 0.0, lambda y: ((y[0], y[1][0]), y[1][1]), (x, (x, x))),
        lambda x: repeat_while(lambda y: y, lambda y: y - 1.0, x),
        lambda x: x + select(x > 0.0, x > 1.0, x > 2.0),
        lambda x: select(x > 0.0, (x, (x, 1.0)), ((x, x), 1.0)),
        lambda x: select(x, 1.0, 2.0),
        lambda x: branch(x, lambda: 1.0, lambda: 2.0),
        lambda x: branch(x > 0.0, lambda: 0, lambda: x),
        lambda x: (x > 0.0) + (x > 1.0),
        lambda x: (x < 0.0) < (x > 1.0),
        lambda x: x & x,
        lambda x: to_integer(x) / 2,
        lambda x: sqrt(to_integer(x)),
        lambda x: abs(to_integer(x)),
        lambda x: fma(to_integer(x), x, 1.0),
        lambda x: trace(lambda y: y, (REAL,), "g")(to_integer(x)),
        lambda x: trace(lambda y: y * x, (REAL,), "g")(x),
    ],
)
def test_what_only_a_number_can_do_is_refused(function) -> None:
    """A condition, a library's function and a change of structure end in an error while tracing, not in wrong code."""
    with pytest.raises(TypeError):
        trace(function, (REAL,), "f")


@pytest.mark.parametrize(
    "function",
    [
        lambda a, i: a.__setitem__(0, i),
        lambda a, i: a[-1],
        lambda a, i: a[to_real(i)],
        lambda a, i: a[0.0],
        lambda a, i: tuple(zip(a, range(3), strict=False)),
    ],
)
def test_what_is_no_element_is_refused(function) -> None:
    """An integer's bits as a real, places before an array, indices that are no integers: errors, as is iteration."""
    with pytest.raises(TypeError):
        trace(function, (ARRAY, INTEGER), "f")


def test_what_a_branch_computes_stays_in_it() -> None:
    """A value that has left a branch or loop without being its result is refused: the code may not have computed it."""
    found = []

    def keep(x):
        found.append(x * x)
        return found[-1]

    for function in (
        lambda x: (branch(x > 0.0, lambda: keep(x), lambda: 0.0), found[-1])[1],
        lambda x: branch(x > 0.0, lambda: keep(x), lambda: 0.0) + found[-1],
        lambda x: (repeat_while(lambda y: y < 9.0, keep, x), -found[-1])[1],
    ):
        with pytest.raises(TraceError, match="used outside"):
            trace(function, (REAL,), "f")


def test_integers_and_reals_do_not_mix() -> None:
    """A real in arithmetic on integers is an error: nothing is rounded silently."""
    with pytest.raises(TraceError, match="neither a integer|neither"):
        trace(lambda i: i * 0.5, (INTEGER,), "f")
    with pytest.raises(TraceError, match="of kind REAL where one of kind INTEGER is needed"):
        trace(lambda i, x: i + x, (INTEGER, REAL), "f")


def test_numpy_floats_are_literals() -> None:
    """A float of NumPy on either side becomes a constant, and no array of symbols."""
    f = trace(lambda x: np.float64(2.0) * x + np.float64(1.0), (REAL,), "f")
    assert isinstance(f.result, Value)


def test_called_with_floats_it_computes() -> None:
    """The same function is its own interpreter."""
    f = trace(lambda x, y: (fma(x, y, 1.0), sincos(x)[0]), (REAL, REAL), "f")
    assert f(2.0, 3.0) == (7.0, sincos(2.0)[0])


def test_floats_that_are_none_raise_no_error() -> None:
    """As in the code, an infinity or nan comes out of what has no value: a run that diverges ends with a status."""
    assert all(math.isnan(x) for x in (*sincos(math.nan), *sincos(math.inf), sqrt(-1.0), power(-1.0, 0.5)))
    assert (exp(1e3), power(0.0, -1.0), power(1e200, 2.0)) == (math.inf,) * 3


def test_sine_and_cosine_are_within_a_digit_of_the_c_library() -> None:
    """Sine and cosine are within 2.3e-16, one digit of 1, of the C library's, up to 1e5 rad."""
    for angle in np.random.default_rng(1).uniform(-1e5, 1e5, 20000).tolist():
        s, c = sincos(angle)
        assert abs(s - math.sin(angle)) <= 2.3e-16 and abs(c - math.cos(angle)) <= 2.3e-16
