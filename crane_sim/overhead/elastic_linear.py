"""The elastic cable's Jacobian, exact and banded, and linear systems with it.

A link couples two neighbouring nodes (the first one node 1 with axes and hoist), so that in the order of the state the
derivatives of accelerations with respect to positions and velocities are bands of width 2 d - 1. With accelerations
a(q, v) the system (β I - J) y = b is, for the velocities' part, (β I - ∂a/∂v - ∂a/∂q / β) y_v = b_v + ∂a/∂q b_q / β,
and y_q = (b_q + y_v) / β: one elimination in a band, whose cost grows like N. Without springs that push it is as good
as positive definite, and needs no pivoting.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.jit import generic, kernel, routine
from crane_sim.linear_systems import band_row, factor_band, solve_band
from crane_sim.overhead.axes import axis_power, demands, rail
from crane_sim.overhead.elastic import ElasticCrane, layout, link
from crane_sim.overhead.elastic_slopes import fill_slopes, slopes_for
from crane_sim.overhead.forces import NodeForces
from crane_sim.overhead.hoists import drum, drum_power
from crane_sim.overhead.switches import mode_of
from crane_sim.sources import value_at


class Bands(NamedTuple):
    """Derivatives of accelerations, and of the power supplied."""

    positions: Any  # (nq, 4 d - 1), as `factor_band` takes it
    velocities: Any
    power: Any  # (2 nq,) with respect to positions and velocities


class Factors(NamedTuple):
    """What solves systems with one shift."""

    shift: float  # 1/s
    lu: Any  # (nq, 4 d - 1)
    bands: Bands


@system.linearised.register(ElasticCrane)
def _(p, t, x, u):
    return bands(p, t, x, system.effort(u, p, t, x))


@routine
def bands(p, t, x, tau):
    """Return the bands at a state; efforts tau are taken as functions of time alone."""
    nq, _, d, _ = layout(p)
    found = Bands(np.zeros((nq, 4 * d - 1)), np.zeros((nq, 4 * d - 1)), np.zeros(2 * nq))
    slopes = slopes_for(d)
    for k in range(len(p.cable.masses)):
        tension, rate = fill_slopes(p, x, k, slopes)
        if k == 0:
            carry(p, t, x, tau, tension, slopes, found)
        add_link(slopes, rate, nq, found)
    add_push_power(p.forces, p, t, found.power)
    return found


@routine
def add_link(slopes, rate, nq, found):
    """Add a link's slopes to the bands, and what its damper takes to the power."""
    size = len(slopes.columns)
    d, width = size // 2, size - 2
    for i in range(size):
        row = slopes.columns[i]
        for j in range(size):
            column = slopes.columns[j]
            if row >= 0 and column >= 0:
                force = d if i == 2 * d else i % d
                found.positions[row, width + column - row] += slopes.weights[i] * slopes.positions[force, j]
                found.velocities[row, width + column - row] += slopes.weights[i] * slopes.velocities[force, j]
        if row >= 0:
            found.power[row] -= 2.0 * rate * slopes.bending[i]
            found.power[nq + row] -= 2.0 * rate * slopes.velocities[d, i]


@routine
def carry(p, t, x, tau, tension, slopes, found):
    """Fill the weights of axes and hoist, and add what their own velocities and the first link do to their power."""
    nq, first, d, modes = layout(p)
    (nx, ny, _), _, _, _ = link(p, x, 0)
    slopes.weights[0] = lean(p, p.trolley, t, x, tau, (0, 0), tension * nx, slopes, found)
    if d == 3:
        slopes.weights[1] = lean(p, p.bridge, t, x, tau, (1, demands(p.trolley)), tension * ny, slopes, found)
    if first == d:
        rate, give = x[nq + first - 1], drum(p.hoist, t, tau)[0]
        slopes.weights[2 * d] = give
        idle = drum_power(p.hoist, tau, rate, 0.0)
        found.power[nq + first - 1] += drum_power(p.hoist, tau, 1.0, tension)
        share(slopes, d, drum_power(p.hoist, tau, rate, 1.0) - idle, nq, found)


@kernel
def lean(p, axis, t, x, tau, which, pull, slopes, found):
    """Return an axis' compliance; add what its velocity and the cable's pull do to its motion and its power."""
    nq, _, d, modes = layout(p)
    i, own = which
    v, mode = x[nq + i], mode_of(p.switches, x, modes, i)
    give, free = rail(axis, t, tau, own, v, mode)
    found.velocities[i, 2 * d - 1] += rail(axis, t, tau, own, v + 1.0, mode)[1] - free  # linear in v
    step = 1e-3 * abs(v) + 1e-9  # the power is quadratic in v, and has a kink at 0
    ahead, behind = axis_power(axis, tau, own, v + step, pull), axis_power(axis, tau, own, v - step, pull)
    found.power[nq + i] += (ahead - behind) / (2.0 * step)
    share(slopes, i, axis_power(axis, tau, own, v, 1.0) - axis_power(axis, tau, own, v, 0.0), nq, found)
    return give


@kernel
def share(slopes, force, factor, nq, found):
    """Add the power that changes by `factor` [m/s] with the first link's force number `force` or tension (last)."""
    for j in range(len(slopes.columns)):
        if slopes.columns[j] >= 0:
            found.power[slopes.columns[j]] += factor * slopes.positions[force, j]
            found.power[nq + slopes.columns[j]] += factor * slopes.velocities[force, j]


@generic
def add_push_power(forces, p, t, power):
    """Add what velocities do to the power of given forces."""


@add_push_power.register(NodeForces)
def _(forces, p, t, power):
    nq, first, d, _ = layout(p)
    a = forces.axis if d == 3 else forces.axis // 2
    power[nq + first + d * (forces.node - 1) + a] += value_at(forces.channel, t)
    add_push_power(forces.rest, p, t, power)


@system.factored.register(ElasticCrane)
def _(p, jacobian, shift):
    return shifted(jacobian, shift)


@routine
def shifted(found, shift):
    """Return the factors of β I - ∂a/∂v - ∂a/∂q / β."""
    lu = np.empty_like(found.positions)
    for i in range(len(lu)):
        for j in range(lu.shape[1]):
            lu[i, j] = -found.velocities[i, j] - found.positions[i, j] / shift
        lu[i, lu.shape[1] // 2] += shift
    factor_band(lu)
    return Factors(shift, lu, found)


@system.solve_shifted.register(ElasticCrane)
def _(p, factors, b):
    solve(factors, b)


@routine
def solve(factors, b):
    """Overwrite b with the solution; the energy supplied follows from the rest, modes stay."""
    shift, lu, found = factors
    nq = len(lu)
    for i in range(nq):
        b[nq + i] += band_row(found.positions, i, b) / shift
    solve_band(lu, b[nq : 2 * nq])
    for i in range(nq):
        b[i] = (b[i] + b[nq + i]) / shift
    if len(b) > 2 * nq:
        for i in range(2 * nq):
            b[2 * nq] += found.power[i] * b[i]
        b[2 * nq] /= shift
