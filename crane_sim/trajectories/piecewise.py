"""Evaluation of piecewise polynomials of time: the piece at a time, and its derivatives."""

from collections.abc import Sequence

from crane_sim.files.errors import shorten

STEP = 1e-6  # s, between the times of a table at which it has the values before and behind a step


def find_piece(starts, count, t):
    """Return the last of `count` pieces begun at time t [s]; the first one holds before as well."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if starts[middle] <= t:
            low = middle
        else:
            high = middle
    return low


def polynomial_at(coefficients, piece, s):
    """Return (value, its first four derivatives) at s of the polynomial in row `piece`.

    Coefficients begin with the constant.
    """
    value, first, second, third, fourth = 0.0, 0.0, 0.0, 0.0, 0.0  # all but the first over k!
    for k in range(coefficients.shape[1] - 1, -1, -1):
        fourth = fourth * s + third
        third = third * s + second
        second = second * s + first
        first = first * s + value
        value = value * s + coefficients[piece, k]
    return value, first, 2.0 * second, 6.0 * third, 24.0 * fourth


def find_table_error(times: Sequence[float], values: Sequence[float], spacing: float = 0.0) -> str:
    """Return what is wrong with a table of values over times, empty text if nothing.

    Times must be at least `spacing` [s] apart.
    """
    steps = [t1 - t0 for t0, t1 in zip(times, times[1:], strict=False)]
    if len(times) != len(values):
        return f"a table needs as many values as times, here are {len(values)} and {len(times)}"
    if any(step <= 0.0 for step in steps):
        step = f"; a step is two times {STEP:g} s apart" if 0.0 in steps else ""
        return f"the times of a table must increase, here are {shorten(list(times))}{step}"
    if any(step < spacing for step in steps):
        return (
            f"the times of a table must be at least {spacing:g} s apart, here are "
            f"{shorten(list(times))}"
        )
    return ""
