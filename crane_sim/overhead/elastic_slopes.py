"""What the force of an elastic link does when its ends move: exact derivatives."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.jit import kernel, routine
from crane_sim.overhead.elastic import layout, link, tautness, vector


class Slopes(NamedTuple):
    """A link's direction, and derivatives by its lower end less its upper end.

    Rows are the components of the force on the upper end [N] and, last, the tension. What the first link's rest length
    and its rate do is minus `spring` and minus `damping` times the direction, and times 1.
    """

    unit: Any  # (d,)
    positions: Any  # (d + 1, d) N/m
    velocities: Any  # (d + 1, d) N s/m


class Link(NamedTuple):
    """The rest of what a link's state fixes."""

    spring: float  # N/m, 0 of a slack link
    damping: float  # N s/m, 0 of a slack link
    tension: float  # N
    rate: float  # m/s, of its elongation


@kernel
def slopes_for(d):
    """Return slopes to fill, in d dimensions."""
    return Slopes(np.empty(d), np.empty((d + 1, d)), np.empty((d + 1, d)))


@routine
def fill_slopes(p, x, k, slopes):
    """Fill the slopes of link k, from 0; return its `Link`."""
    _, _, d, modes = layout(p)
    (nx, ny, nz), length, stretch, rate = link(p, x, k)
    (ux, uy, uz), (vx, vy, vz) = vector(p, x, k, 1), vector(p, x, k + 1, 1)
    wx, wy, wz = vx - ux, vy - uy, vz - uz
    along = nx * wx + ny * wy + nz * wz
    taut = tautness(p.switches, x, modes + d - 1 + k)
    spring, damping = taut * p.cable.stiffness[k], taut * p.cable.damping[k]
    tension, bend = spring * stretch + damping * rate, damping / length
    unit, positions, velocities = slopes
    put(unit, d, nx, ny, nz)
    put(velocities[d], d, damping * nx, damping * ny, damping * nz)
    put(
        positions[d],
        d,
        spring * nx + bend * (wx - along * nx),
        spring * ny + bend * (wy - along * ny),
        spring * nz + bend * (wz - along * nz),
    )
    turning = tension / length
    for a in range(d):
        for b in range(d):
            across = (1.0 if a == b else 0.0) - unit[a] * unit[b]
            positions[a, b] = unit[a] * positions[d, b] + turning * across
            velocities[a, b] = unit[a] * velocities[d, b]
    return Link(spring, damping, tension, rate)


@kernel
def put(out, d, x, y, z):
    """Write a vector into out (d,); in the plane its last component takes the place of the one that is not there."""
    out[0], out[1] = x, y
    out[d - 1] = z
