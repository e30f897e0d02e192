"""Arithmetic on states that are arrays, and rows of results."""

from typing import Any

import numpy as np

from crane_sim.numerics.elementary import fma
from crane_sim.numerics.jit import routine, simd_range


@routine
def scale_array(a, x):
    """Return a x."""
    out = np.empty_like(x)
    for i in simd_range(len(x)):
        out[i] = a * x[i]
    return out


@routine
def add_scaled_arrays(x, a, y):
    """Return x + a y."""
    out = np.empty_like(x)
    for i in simd_range(len(x)):
        out[i] = x[i] + a * y[i]
    return out


def accumulate(h, weights, count, ks, x, out):
    """Write x plus the sum of h weights[j] ks[j] over the first `count` >= 1 rows into `out`.

    The rows are added from left to right, x last; x may be None. The loop over the row is the outer
    one, so that sums stay in registers.
    """
    factors = [h * weights[j] for j in range(count)]
    for i in simd_range(len(out)):
        total = factors[0] * ks[0, i]
        for j in range(1, count):
            total = fma(factors[j], ks[j, i], total)
        out[i] = total if x is None else x[i] + total


@routine
def move_rows(x, h, weights, ks, out):
    """Write x plus the sum of h weights[j] ks[j] into `out`."""
    accumulate(h, weights, len(weights), ks, x, out)


@routine
def array_square(e, x, y, rtol, atol):
    """Return the sum of squares of e / (atol + rtol max(|x|, |y|)), component by component."""
    total = 0.0
    for i in range(len(e)):
        ratio = e[i] / (atol + rtol * max(abs(x[i]), abs(y[i])))
        total += ratio * ratio
    return total


@routine
def rows_square(h, weights, ks, x, y, rtol, atol):
    """Return the `array_square` of the sum of h weights[j] ks[j]; the next row is its scratch.

    Squares first, then their sum: the divisions become vectors, and only the additions wait for
    each other.
    """
    count, total = len(weights), 0.0
    squares = ks[count]
    accumulate(h, weights, count, ks, None, squares)
    for i in simd_range(len(x)):
        ratio = squares[i] / (atol + rtol * max(abs(x[i]), abs(y[i])))
        squares[i] = ratio * ratio
    for i in range(len(x)):
        total += squares[i]
    return total


def dense(row: tuple[float | None, ...]) -> tuple[float, ...]:
    """Return the row with 0 in place of None."""
    return tuple([0.0 if entry is None else entry for entry in row])


def store(rows: Any, i: int, first: int, values: tuple[float, ...]) -> None:
    """Copy the values, any number of them, into row i from column `first` on."""
    rows[i, first : first + len(values)] = values
