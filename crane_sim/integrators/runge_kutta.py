"""Explicit Runge-Kutta stages from a tableau that is data.

A tableau has rows a (one per stage after the first), nodes c and weights b. Structural zeros are
None and cost nothing. The stages of tuple states are written out, one call each, so that they stay
in registers; those of array states are the rows of one array, filled in a loop.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.arrays import accumulate
from crane_sim.numerics.jit import routine, use_wide_vectors
from crane_sim.numerics.states import add, add_weighted, weighted_sum
from crane_sim.system import rhs, rhs_into


def to_dense_tableau(rows):
    """Return the rows of a tableau as a matrix (stages, stages).

    The first stage, which has no row, is a row of 0.
    """
    matrix = np.zeros((len(rows) + 1, len(rows) + 1))
    for i, row in enumerate(rows):
        matrix[i + 1, : len(row)] = [entry or 0.0 for entry in row]
    return matrix


class Tableau(NamedTuple):
    """Coefficients of an explicit method, an attribute `tableau` of its class."""

    a: tuple[tuple[float | None, ...], ...]
    b: tuple[float | None, ...]
    c: tuple[float, ...]
    dense: Any  # (stages, stages), a
    nodes: Any  # (stages,), c


def make_tableau(a, b, c):
    """Return the tableau with these rows, weights and nodes."""
    return Tableau(a, b, c, to_dense_tableau(a), np.array((0.0, *c)))


def evaluate_first_stage(scratch, p, t, x, u):
    """Return the derivative at (t, x), the first stage; of arrays the first row of the scratch."""
    if scratch is None:
        return rhs(p, t, x, u)
    rhs_into(p, t, x, u, scratch.rows[0], scratch.work)
    return scratch.rows[0]


def evaluate_stage(p, t, x, u, h, row, node, ks):
    """Return the derivative at the stage with this row and node; `ks`: of the stages before."""
    return rhs(p, t + node * h, add(x, weighted_sum(h, row, ks)), u)


def evaluate_stages(method, scratch, k1, p, t, x, u, h):
    """Return the derivatives at all stages, for an array its scratch.

    The first one is that of `evaluate_first_stage`.
    """
    tableau = method.tableau
    if scratch is not None:
        fill_stages(scratch, p, t, x, u, h, tableau.dense, tableau.nodes)
        return scratch
    ks = (k1,)
    for row, node in zip(tableau.a, tableau.c, strict=True):
        ks = (*ks, evaluate_stage(p, t, x, u, h, row, node, ks))
    return ks


def take_explicit_step(method, p, t, x, u, h, scratch, out):
    """Return the result of `take_step` of a method with a tableau."""
    ks = evaluate_stages(method, scratch, evaluate_first_stage(scratch, p, t, x, u), p, t, x, u, h)
    return add_weighted(x, h, method.tableau.b, ks, out), method.stages


@routine
def fill_stages(scratch, p, t, x, u, h, a, c):
    """Fill the stages after the first one, of a dense tableau a, c."""
    use_wide_vectors()
    rows, count = scratch.rows, len(a)
    y = rows[count]
    for s in range(1, count):
        accumulate(h, a[s], s, rows, x, y)
        rhs_into(p, t + c[s] * h, y, u, rows[s], scratch.work)
