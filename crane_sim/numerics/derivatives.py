"""Jacobians of functions of states, by forward mode: exact to rounding, several columns at once."""

from typing import Any

import numpy as np

from crane_sim.numerics.states import dimension
from crane_sim.tracing.derivatives import DIRECTIONS as DIRECTIONS
from crane_sim.tracing.derivatives import directional_derivatives as directional_derivatives


def state_and_time_jacobian(f, p, t, x, u):
    """Return the derivatives by x (n, n) and by t (n,) of f(p, t, x, u), x being n floats.

    f returns a state like x.
    """
    n = dimension(x)
    seeds, out = np.empty((n + 1, DIRECTIONS)), np.empty((n, n + 1))
    for first in range(0, n + 1, DIRECTIONS):
        fill_seeds(seeds, first)
        directions = (None, seeds[n], directions_like(x, seeds, 0), None)
        slopes = directional_derivatives(f, (p, t, x, u), directions)[1]
        write_columns(slopes, out, first, min(n + 1 - first, DIRECTIONS))
    return out[:, :n], out[:, n]


def fill_seeds(seeds, first):
    """Fill directions (n, DIRECTIONS) with those of the coordinates from `first` on."""
    for i in range(len(seeds)):
        for k in range(DIRECTIONS):
            seeds[i, k] = 1.0 if i == first + k else 0.0


def directions_like(x: Any, seeds: Any, first: int) -> Any:
    """Return the directions of a state, from row `first` of seeds (n, DIRECTIONS) on."""
    if isinstance(x, np.ndarray):
        return seeds[first : first + len(x)]
    if not isinstance(x, tuple):
        return seeds[first]
    return tuple(
        [directions_like(part, seeds, first + dimension(x[:i])) for i, part in enumerate(x)]
    )


def write_columns(derivative, out, first, count):
    """Write `count` directions of a state's derivative into columns of `out` from `first` on."""
    rows = rows_of(derivative)
    for i in range(len(rows)):
        for k in range(count):
            out[i, first + k] = rows[i][k]


def rows_of(derivative: Any) -> Any:
    """Return the derivatives of each float of a state: an array, or a flat tuple of arrays."""
    if not isinstance(derivative, tuple):
        return derivative
    return tuple(
        [
            row
            for part in derivative
            for row in (rows_of(part) if isinstance(part, tuple) else (part,))
        ]
    )
