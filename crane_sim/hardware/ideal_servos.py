"""Ideal servo drives, of infinite gain: efforts with which joints follow references exactly.

Accelerations are affine in the efforts: a = a_0 + B u. The efforts u of these joints solve B u =
a_r - a_0, with a_r the references' accelerations, B from one evaluation of the equations for each
joint. A second pass with the remainder removes the rounding of B, whose entries are differences.
The references begin with the joints' motion.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.hardware.servos import reference_at
from crane_sim.numerics.jit import routine
from crane_sim.numerics.linear_systems import factor_dense, solve_dense


class IdealServos(NamedTuple):
    """The joints with ideal servo drives."""

    drives: Any  # (m,), indices of their drives
    joints: Any  # (m,), their indices among all joints


@routine
def solve_efforts(ideal, loops, drives, p, t, x):
    """Add to the efforts in `drives` those that give joints their references' accelerations.

    A brake that holds goes before.
    """
    m, own = len(ideal.drives), ideal.drives
    mobility, remainder = np.empty((m, m)), np.empty(m)
    missing_accelerations(ideal, loops, drives, p, t, x, remainder)
    for j in range(m):
        drive, column = drives[own[j]], np.empty(m)
        drive.effort += 1.0
        missing_accelerations(ideal, loops, drives, p, t, x, column)
        drive.effort -= 1.0
        for i in range(m):
            mobility[i, j] = remainder[i] - column[i]
    for j in range(m):
        if drives[own[j]].engaged:
            mobility[j, :], mobility[:, j], mobility[j, j] = 0.0, 0.0, 1.0
    order = factor_dense(mobility)
    for _ in range(2):
        for j in range(m):
            remainder[j] = 0.0 if drives[own[j]].engaged else remainder[j]
        solve_dense(mobility, order, remainder)
        for j in range(m):
            drives[own[j]].effort += remainder[j]
        missing_accelerations(ideal, loops, drives, p, t, x, remainder)


@routine
def missing_accelerations(ideal, loops, drives, p, t, x, out):
    """Write the references' accelerations less the present ones into `out` (m,).

    The present ones are those under the efforts in `drives`.
    """
    accelerations = system.acceleration(p, t, x, system.efforts_from_row(p, drives.effort))
    for j in range(len(ideal.joints)):
        out[j] = reference_at(loops[ideal.drives[j]], t)[2] - accelerations[ideal.joints[j]]
