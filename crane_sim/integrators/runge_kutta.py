"""Explicit Runge-Kutta stages from a tableau that is data.

A tableau has rows a (one per stage after the first), nodes c and weights b. Structural zeros are None and cost nothing.
The stages of tuple states are written out, one call each, so that they stay in registers; those of array states are
the rows of one array, filled in a loop.
"""

import numpy as np

from crane_sim.integrators.integration import Scratch
from crane_sim.numerics.arrays import accumulate
from crane_sim.numerics.jit import generic, routine, use_wide_vectors
from crane_sim.numerics.states import add, weighted_sum
from crane_sim.system import rhs, rhs_into


def to_dense_tableau(rows):
    """Return the rows of a tableau as a matrix (stages, stages); the first stage, which has no row, is a row of 0."""
    matrix = np.zeros((len(rows) + 1, len(rows) + 1))
    for i, row in enumerate(rows):
        matrix[i + 1, : len(row)] = [entry or 0.0 for entry in row]
    return matrix


@generic
def evaluate_first_stage(scratch, p, t, x, u):
    """Return the derivative at (t, x), the first of the stages; written into the first row of a workspace."""
    return rhs(p, t, x, u)


@evaluate_first_stage.register(Scratch)
def _(scratch, p, t, x, u):
    rhs_into(p, t, x, u, scratch.rows[0], scratch.work)


def evaluate_stage(p, t, x, u, h, row, node, ks):
    """Return the derivative at the stage with this row and node, given those of the stages before, `ks`."""
    return rhs(p, t + node * h, add(x, weighted_sum(h, row, ks)), u)


@routine
def fill_stages(scratch, p, t, x, u, h, a, c):
    """Fill the stages after the first one, of a dense tableau a, c."""
    use_wide_vectors()
    rows, count = scratch.rows, len(a)
    y = rows[count]
    for s in range(1, count):
        accumulate(h, a[s], s, rows, x, y)
        rhs_into(p, t + c[s] * h, y, u, rows[s], scratch.work)
