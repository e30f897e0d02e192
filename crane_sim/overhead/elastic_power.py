"""Derivatives of the power that a metered crane with an elastic cable is supplied with."""

import numpy as np

from crane_sim.base import carried
from crane_sim.jit import generic, kernel, routine
from crane_sim.overhead.axes import axis_power, demands
from crane_sim.overhead.elastic import layout
from crane_sim.overhead.elastic_carried import lean_power
from crane_sim.overhead.elastic_slopes import fill_slopes, slopes_for
from crane_sim.overhead.forces import NodeForces
from crane_sim.overhead.hoists import drum_power
from crane_sim.sources import value_at


@generic
def power_slopes(meter, p, t, x, tau):
    """Return the derivatives (2 nq,) of the power [W] by positions and velocities; nothing without a meter."""
    return slopes_of_power(p, t, x, tau)


@power_slopes.register(type(None))
def _(meter, p, t, x, tau):
    return np.empty(0)


@routine
def slopes_of_power(p, t, x, tau):
    """Return the derivatives as `power_slopes` does."""
    nq, first, d, _ = layout(p)
    power, slopes, factors = np.zeros(2 * nq), slopes_for(d), np.zeros(d + 1)
    for k in range(len(p.cable.masses)):
        info = fill_slopes(p, x, k, slopes)
        if k == 0:
            support(p, t, x, tau, info, slopes, factors, power)
        lower, m = first + d * k, d - 1 if k == 0 else d
        upper, twice = 0 if k == 0 else lower - d, 2.0 * info.rate
        for b in range(d):
            damped = slopes.positions[d, b] - info.spring * slopes.unit[b]
            position, velocity = -twice * damped, -twice * slopes.velocities[d, b]
            for f in range(d + 1):
                position += factors[f] * slopes.positions[f, b]
                velocity += factors[f] * slopes.velocities[f, b]
            power[lower + b] += position
            power[nq + lower + b] += velocity
            if b < m:
                power[upper + b] -= position
                power[nq + upper + b] -= velocity
        for f in range(d + 1):
            factors[f] = 0.0
    add_pushes_power(p.forces, p, t, power)
    lean_power(carried(p.base, p.gravity, t), p, x, power)
    return power


@routine
def support(p, t, x, tau, info, slopes, factors, power):
    """Add what axes and hoist do themselves; fill the factors [m/s] by which the first link's force becomes power."""
    nq, first, d, _ = layout(p)
    unit = slopes.unit
    factors[0] = lean(p, p.trolley, x, tau, 0, 0, info.tension * unit[0], power)
    if d == 3:
        factors[1] = lean(p, p.bridge, x, tau, 1, demands(p.trolley), info.tension * unit[1], power)
    if first == d:
        rate, total = x[nq + first - 1], 0.0
        factors[d] = drum_power(p.hoist, tau, rate, 1.0) - drum_power(p.hoist, tau, rate, 0.0)
        power[nq + first - 1] += drum_power(p.hoist, tau, 1.0, info.tension) + 2.0 * info.rate * info.damping
        for f in range(d + 1):
            total += factors[f] * (unit[f] if f < d else 1.0)
        power[first - 1] -= total * info.spring
        power[nq + first - 1] -= total * info.damping


@kernel
def lean(p, axis, x, tau, i, own, pull, power):
    """Return how the power of axis i, linear in the pull, changes with it; add how it changes with its velocity."""
    nq, _, _, _ = layout(p)
    v = x[nq + i]
    step = 1e-3 * abs(v) + 1e-9  # the power is quadratic in v on both sides of v = 0
    ahead, behind = axis_power(axis, tau, own, v + step, pull), axis_power(axis, tau, own, v - step, pull)
    power[nq + i] += (ahead - behind) / (2.0 * step)
    return axis_power(axis, tau, own, v, 1.0) - axis_power(axis, tau, own, v, 0.0)


@generic
def add_pushes_power(forces, p, t, power):
    """Add what velocities do to the power of given forces."""


@add_pushes_power.register(NodeForces)
def _(forces, p, t, power):
    nq, first, d, _ = layout(p)
    a = forces.axis if d == 3 else forces.axis // 2
    power[nq + first + d * (forces.node - 1) + a] += value_at(forces.channel, t)
    add_pushes_power(forces.rest, p, t, power)
