"""Arithmetic on states in registers: floats, arrays of floats, and nested tuples of states.

A structural zero of a tableau is None and costs no arithmetic. Sums run left to right over the
stages and meet the state last.
"""

from typing import Any

import numpy as np

from crane_sim.numerics.arrays import (
    add_scaled_arrays,
    array_square,
    dense,
    move_rows,
    rows_square,
    scale_array,
)
from crane_sim.numerics.elementary import fma

State = Any
"""A float, an array of floats, or a tuple of states; arrays are never changed in place."""


def add(x: State, y: State) -> State:
    """Return x + y."""
    if isinstance(x, np.ndarray):
        return add_scaled_arrays(x, 1.0, y)
    return tuple([add(a, b) for a, b in zip(x, y, strict=True)]) if isinstance(x, tuple) else x + y


def scale(a: float, x: State) -> State:
    """Return a x."""
    if isinstance(x, np.ndarray):
        return scale_array(a, x)
    return tuple([scale(a, b) for b in x]) if isinstance(x, tuple) else a * x


def add_scaled(x: State, a: float, y: State) -> State:
    """Return x + a y, each float of a tuple rounded once."""
    if isinstance(x, np.ndarray):
        return add_scaled_arrays(x, a, y)
    return (
        tuple([add_scaled(b, a, c) for b, c in zip(x, y, strict=True)])
        if isinstance(x, tuple)
        else fma(a, y, x)
    )


def weighted_sum(h: float, row: tuple[float | None, ...], ks: tuple[State, ...]) -> State:
    """Return the sum of h row[j] ks[j] over the entries of `row` that are not None.

    At least one is not None.
    """
    terms = [(h * a, k) for a, k in zip(row, ks, strict=True) if a is not None]
    total = scale(*terms[0])
    for a, k in terms[1:]:
        total = add_scaled(total, a, k)
    return total


def add_weighted(x: State, h: float, row: tuple[float | None, ...], ks: Any, out: State) -> State:
    """Return x + the sum of `weighted_sum`; of an array in `out`, from ks in rows of a scratch."""
    if isinstance(x, np.ndarray):
        move_rows(x, h, dense(row), ks.rows, out)
        return out
    return add(x, weighted_sum(h, row, ks))


def squared_error_norm(e: State, x: State, y: State, rtol: float, atol: float) -> float:
    """Return the sum of squares of e / (atol + rtol max(|x|, |y|)), component by component."""
    if isinstance(e, np.ndarray):
        return array_square(e, x, y, rtol, atol)
    total = 0.0
    for a, b, c in zip(leaves(e), leaves(x), leaves(y), strict=True):
        ratio = a / (atol + rtol * max(abs(b), abs(c)))
        total += ratio * ratio
    return total


def error_square(
    h: float, row: tuple[float | None, ...], ks: Any, x: State, y: State, rtol: float, atol: float
) -> float:
    """Return the `squared_error_norm` of the sum of `weighted_sum`; ks as of `add_weighted`."""
    if isinstance(x, np.ndarray):
        return rows_square(h, dense(row), ks.rows, x, y, rtol, atol)
    return squared_error_norm(weighted_sum(h, row, ks), x, y, rtol, atol)


def leaves(x: State) -> Any:
    """Return the floats of x as a flat tuple; an array as it is."""
    if isinstance(x, np.ndarray):
        return x
    return tuple([leaf for part in x for leaf in leaves(part)]) if isinstance(x, tuple) else (x,)


def replace_entry(x: tuple[Any, ...], i: int, value: Any) -> tuple[Any, ...]:
    """Return the flat tuple x with `value` at index i."""
    return tuple([value if k == i else entry for k, entry in enumerate(x)])


def dimension(x: State) -> int:
    """Return the number of floats in x."""
    return len(leaves(x))
