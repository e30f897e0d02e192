"""What the force of an elastic link does when its ends and its rest length move: exact derivatives."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.jit import kernel, routine
from crane_sim.overhead.elastic import layout, link, mass_of, tautness, vector


class Slopes(NamedTuple):
    """Derivatives of one link's force, by coordinates of its upper node, its lower node, and the length of the first.

    Rows are the components of the force [N] on the upper node and, last, the tension.
    """

    columns: Any  # (2 d + 1,) which coordinates of the crane these are, -1 where there is none
    positions: Any  # (d + 1, 2 d + 1)
    velocities: Any
    bending: Any  # (2 d + 1,) what positions do to the damper's share of the tension
    weights: Any  # (2 d + 1,) 1/kg, acceleration of each coordinate for a unit force


@kernel
def slopes_for(d):
    """Return slopes to fill, in d dimensions."""
    n = 2 * d + 1
    return Slopes(np.empty(n, np.int64), np.empty((d + 1, n)), np.empty((d + 1, n)), np.empty(n), np.empty(n))


@routine
def fill_slopes(p, x, k, slopes):
    """Fill the slopes of link k, from 0, but for the weights of axes and hoist; return (tension, rate)."""
    nq, first, d, modes = layout(p)
    (nx, ny, nz), length, stretch, rate = link(p, x, k)
    (ux, uy, uz), (vx, vy, vz) = vector(p, x, k, 1), vector(p, x, k + 1, 1)
    along = nx * (vx - ux) + ny * (vy - uy) + nz * (vz - uz)
    taut = tautness(p.switches, x, modes + d - 1 + k)
    spring, damping = taut * p.cable.stiffness[k], taut * p.cable.damping[k]
    tension = spring * stretch + damping * rate
    unit, turn = np.array((nx, ny, nz)), np.array((vx - ux - along * nx, vy - uy - along * ny, vz - uz - along * nz))
    above = 1.0 / p.cable.masses[k - 1] if k > 0 else 0.0
    for j in range(2 * d):
        a, side = j % d, 1.0 if j >= d else -1.0
        c = a if d == 3 else 2 * a
        slopes.columns[j] = first + d * (k - 1) + j if k > 0 or j >= d else a if a < d - 1 else -1
        slopes.weights[j] = -1.0 / mass_of(p, x, k + 1) if j >= d else above
        slopes.bending[j] = side * damping * turn[c] / length
        slopes.positions[d, j], slopes.velocities[d, j] = side * spring * unit[c], side * damping * unit[c]
    slopes.columns[2 * d] = first - 1 if k == 0 and first == d else -1
    slopes.bending[2 * d], slopes.weights[2 * d] = 0.0, 0.0
    slopes.positions[d, 2 * d], slopes.velocities[d, 2 * d] = -spring, -damping
    for j in range(2 * d + 1):
        slopes.positions[d, j] += slopes.bending[j]
        for a in range(d):
            c, b, side = a if d == 3 else 2 * a, j % d if d == 3 else 2 * (j % d), 1.0 if j >= d else -1.0
            across = ((1.0 if c == b else 0.0) - unit[c] * unit[b]) * side if j < 2 * d else 0.0
            slopes.positions[a, j] = unit[c] * slopes.positions[d, j] + tension / length * across
            slopes.velocities[a, j] = unit[c] * slopes.velocities[d, j]
    return tension, rate
