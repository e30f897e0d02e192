"""Numbers of many cranes in place of one: the bits of floats, and marks where cranes answer otherwise."""

import math
from typing import Any

import numpy as np
import pytest

from crane_sim.numerics.column import Column, NotVectorisable, arrays_of, as_float, entry_of

A, B = np.array([0.1, 0.7, -3.3]), np.array([0.3, 0.0, 1e-9])


def columns() -> tuple[Column, Column]:
    """Return two numbers of three cranes."""
    covered = np.ones(3, bool)
    return Column(A, covered), Column(B, covered)


def test_arithmetic_is_that_of_floats() -> None:
    """Sums, products and differences of columns, floats and arrays of them have the bits of each crane's floats."""
    a, b = columns()
    found = (2.0 - a) * b + np.cumsum(np.array([a, b]))[1] / 3.0 - abs(-b) + 1
    expected = [(2.0 - x) * y + (x + y) / 3.0 - abs(-y) + 1 for x, y in zip(A.tolist(), B.tolist(), strict=True)]
    assert found.values.tolist() == expected
    assert a.covered.all()


def test_a_comparison_answers_for_the_first_crane_and_marks_the_others() -> None:
    """Cranes that answer otherwise are marked, and never decide; a division by zero marks, as floats would raise."""
    a, b = columns()
    assert a > 0.0
    assert a.covered.tolist() == [True, True, False]
    assert max(a, 0.5) == 0.5
    assert a.covered.tolist() == [True, False, False]
    a, b = columns()
    assert (a / b).values[0] == A[0] / B[0]
    assert a.covered.tolist() == [True, False, True]


def test_what_takes_one_number_takes_no_column() -> None:
    """What would take a column for one float, or print it, raises: nothing is made from one crane's value for all."""
    a, _ = columns()
    takes: tuple[Any, ...] = (
        float, int, hash, str, "{:g}".format, "{}".format, math.cos, math.sqrt, np.cos, np.exp, round,
        lambda x: x**2.0, lambda x: 2.0**x, lambda x: x % 2.0, lambda x: np.array([x], dtype=float),
        lambda x: np.array(0.0).fill(x), lambda x: [1.0, 2.0][x], lambda x: x < "2", lambda x: x == A,
        np.degrees, np.arctan, np.floor, lambda x: np.arctan2(x, 1.0), lambda x: np.arctan2(1.0, x), np.isnan,
        lambda x: np.hypot(x, A), lambda x: np.hypot(A, x), lambda x: np.degrees(np.array([x])), lambda x: divmod(x, 2),
        len, list, tuple, sum, lambda x: 1.0 in x, lambda x: A @ x, lambda x: x @ A, lambda x: [*x],
        np.logaddexp.reduce,
    )  # fmt: skip
    for take in takes:
        with pytest.raises(NotVectorisable):
            take(a)
    assert as_float(a) is a
    assert as_float(2) == 2.0


def test_an_array_takes_a_column_entry_by_entry() -> None:
    """A column beside an array of as many entries as there are cranes is no sum by cranes: each entry has its own."""
    a, _ = columns()
    for found in (a * B, B * a):
        assert [entry.values.tolist() for entry in found] == [(y * A).tolist() for y in B]
    for found in (np.multiply(a, B), np.multiply(B, a), np.float64(0.3) * np.array([a, a, a])):
        assert len(found) == 3 and all(isinstance(entry, Column) for entry in found)
    assert np.sqrt(abs(a)).values.tolist() == np.sqrt(np.abs(A)).tolist() and (+a).values is a.values
    assert (np.float64(2.0) * a).values.tolist() == (2.0 * A).tolist()
    with pytest.raises(TypeError):
        a * "text"
    found = np.ones(3) / a
    assert [entry.values.tolist() for entry in found] == [(1.0 / A).tolist()] * 3 and a.covered.all()


def test_trees_have_arrays_or_entries_in_place_of_columns() -> None:
    """A tree becomes one of arrays, with a column's values in its place, or that of one crane."""
    a, b = columns()
    tree = (a, None, 2.0, np.array([[a, 1.0]]), np.array([4.0, 5.0]), b)
    first, nothing, two, square, row, last = arrays_of(tree, 3)
    assert (first.tolist(), nothing, two.tolist(), last.tolist()) == (A.tolist(), None, [2.0] * 3, B.tolist())
    assert square.tolist() == [[[x, 1.0]] for x in A]
    assert row.tolist() == [[4.0, 5.0]] * 3
    one = entry_of(tree, 1)
    assert (one[0], one[2], one[3].tolist(), one[5]) == (0.7, 2.0, [[0.7, 1.0]], 0.0)
