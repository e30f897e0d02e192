"""The elastic cable's Jacobian, exact and banded, and linear systems with it.

A link couples two neighbouring nodes (the first one node 1 with axes and hoist), so that in the order of the state the
derivatives of accelerations a(q, v) by positions and velocities are bands of width w = 2 d - 1. The velocities' part of
(β I - J) y = b is (β I - ∂a/∂v - ∂a/∂q / β) y_v = b_v + ∂a/∂q b_q / β, and y_q = (b_q + y_v) / β: an elimination whose
cost grows like N. It needs no pivoting, being as good as positive definite where no spring pushes hard.

Derivatives of a link's force come first, then those of the power that a meter integrates, then the bands.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.overhead.elastic import (
    ElasticCrane,
    base_jacobian,
    base_power_jacobian,
    elastic_layout,
    link,
    mass_of,
    node_vector,
    tautness,
)
from crane_sim.models.overhead.elastic_wind import elastic_wind_jacobian, elastic_wind_power_jacobian
from crane_sim.models.overhead.modes import get_mode
from crane_sim.models.supports.hoist import hoist_response
from crane_sim.models.supports.rails import axis_linear_span, input_count
from crane_sim.numerics.jit import generic, routine
from crane_sim.numerics.linear_systems import add_band_product, factor_band, solve_band
from crane_sim.trajectories.inputs import value_at


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


def allocate_slopes(d):
    """Return slopes to fill, in d dimensions."""
    return Slopes(np.empty(d), np.empty((d + 1, d)), np.empty((d + 1, d)))


@routine
def fill_slopes(p, x, k, slopes):
    """Fill the slopes of link k, from 0; return its `Link`."""
    _, _, d, modes = elastic_layout(p)
    (nx, ny, nz), length, stretch, rate = link(p, x, k)
    (ux, uy, uz), (vx, vy, vz) = node_vector(p, x, k, 1), node_vector(p, x, k + 1, 1)
    wx, wy, wz = vx - ux, vy - uy, vz - uz
    along = nx * wx + ny * wy + nz * wz
    taut = tautness(p.event_limits, x, modes + d - 1 + k)
    spring, damping = taut * p.cable.stiffness[k], taut * p.cable.damping[k]
    tension, bend = spring * stretch + damping * rate, damping / length
    unit, positions, velocities = slopes
    put_vector(unit, d, nx, ny, nz)
    put_vector(velocities[d], d, damping * nx, damping * ny, damping * nz)
    put_vector(
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


def put_vector(out, d, x, y, z):
    """Write a vector into out (d,); in the plane its last component is the second one."""
    out[0], out[1] = x, y
    out[d - 1] = z


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
    nq, first, d, _ = elastic_layout(p)
    power, slopes, factors = np.zeros(2 * nq), allocate_slopes(d), np.zeros(d + 1)
    for k in range(len(p.cable.masses)):
        info = fill_slopes(p, x, k, slopes)
        if k == 0:
            add_upper_end_power(p, t, x, tau, info, slopes, factors, power)
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
    add_node_forces_power(p.forces, p, t, power)
    base = base_kinematics_at(p.base, p.gravity, t)
    base_power_jacobian(base, p, x, power)
    elastic_wind_power_jacobian(p.wind, p, base, t, x, power)
    return power


@routine
def add_upper_end_power(p, t, x, tau, info, slopes, factors, power):
    """Add the terms of axes and hoist; fill the factors [m/s] by which the first link's force becomes power."""
    nq, first, d, _ = elastic_layout(p)
    unit = slopes.unit
    factors[0] = pull_power_jacobian(p, p.trolley, x, tau, 0, 0, info.tension * unit[0], power)
    if d == 3:
        factors[1] = pull_power_jacobian(p, p.bridge, x, tau, 1, input_count(p.trolley), info.tension * unit[1], power)
    if first == d:
        rate, total = x[nq + first - 1], 0.0
        factors[d] = p.hoist.power(tau, rate, 1.0) - p.hoist.power(tau, rate, 0.0)
        power[nq + first - 1] += p.hoist.power(tau, 1.0, info.tension) + 2.0 * info.rate * info.damping
        for f in range(d + 1):
            total += factors[f] * (unit[f] if f < d else 1.0)
        power[first - 1] -= total * info.spring
        power[nq + first - 1] -= total * info.damping


def pull_power_jacobian(p, axis, x, tau, i, own, pull, power):
    """Return how the power of axis i, linear in the pull, changes with it; add how it changes with its velocity."""
    nq, _, _, _ = elastic_layout(p)
    v = x[nq + i]
    step = 1e-3 * abs(v) + 1e-9  # the power is quadratic in v on both sides of v = 0
    low, high, width = axis_linear_span(axis, v, (v - step, v + step, 2.0 * step))
    ahead, behind = axis.power(tau, own, high, pull), axis.power(tau, own, low, pull)
    power[nq + i] += (ahead - behind) / width
    return axis.power(tau, own, v, 1.0) - axis.power(tau, own, v, 0.0)


def add_node_forces_power(forces, p, t, power):
    """Add the derivatives of the power of forces on nodes with respect to velocities."""
    nq, first, d, _ = elastic_layout(p)
    for force in forces or ():
        a = force.axis if d == 3 else force.axis // 2
        power[nq + first + d * (force.node - 1) + a] += value_at(force.channel, t)


class Bands(NamedTuple):
    """Derivatives of accelerations, as `factor_band` takes them, and of the power supplied."""

    positions: Any  # (nq, 2 w + 1)
    velocities: Any  # (nq, 2 w + 1)
    power: Any  # (2 nq,) by positions and velocities; empty of a crane without a meter


class Factors(NamedTuple):
    """Factors for systems with one shift."""

    shift: float  # 1/s
    lu: Any  # (nq, 2 w + 1)
    bands: Bands
    work: Any  # (nq + 2 w,), zeros at both ends


@system.compute_jacobian.register(ElasticCrane)
def _(p, t, x, u):
    return bands_at(p, t, x, system.effort(u, p, t, x))


@routine
def bands_at(p, t, x, tau):
    """Return the bands at a state; efforts tau are taken as functions of time alone."""
    nq, first, d, _ = elastic_layout(p)
    bands = Bands(np.zeros((nq, 4 * d - 1)), np.zeros((nq, 4 * d - 1)), power_slopes(p.energy_meter, p, t, x, tau))
    slopes, weights, n = allocate_slopes(d), np.zeros(d), len(p.cable.masses)
    add_axes_jacobian(p, t, x, tau, slopes, weights, bands)
    base = base_kinematics_at(p.base, p.gravity, t)
    base_jacobian(base, p, weights, bands)
    elastic_wind_jacobian(p.wind, p, base, t, x, bands)
    for k in range(1, n):
        fill_slopes(p, x, k, slopes)
        for a in range(d):
            weights[a] = 1.0 / p.cable.masses[k - 1]
        i = first + d * k
        add_link(slopes, weights, 1.0 / mass_of(p, x, k + 1), (d, d), (i - d, i), bands)
    return bands


def add_entry(bands, d, row, column, weight, position, velocity):
    """Add the derivatives of one acceleration by one position and its velocity."""
    j = 2 * d - 1 + column - row
    bands.positions[row, j] += weight * position
    bands.velocities[row, j] += weight * velocity


def add_link(slopes, upper_inv_masses, lower_inv_mass, size, starts, bands):
    """Add a link between coordinates from starts[0] and from starts[1] on, size[0] and size[1] of them.

    `upper_inv_masses` are those of the upper end, one by one, `lower_inv_mass` is that of the lower end [1/kg].
    """
    (m, d), (upper, lower) = size, starts
    for a in range(d):
        for b in range(d):
            position, velocity = slopes.positions[a, b], slopes.velocities[a, b]
            add_entry(bands, d, lower + a, lower + b, -lower_inv_mass, position, velocity)
            if b < m:
                add_entry(bands, d, lower + a, upper + b, lower_inv_mass, position, velocity)
            if a < m:
                add_entry(bands, d, upper + a, lower + b, upper_inv_masses[a], position, velocity)
            if a < m and b < m:
                add_entry(bands, d, upper + a, upper + b, -upper_inv_masses[a], position, velocity)


@routine
def add_axes_jacobian(p, t, x, tau, slopes, inv_masses, bands):
    """Add the first link, axes and hoist; fill the axes' `inv_masses` (d,) [1/kg]."""
    nq, first, d, _ = elastic_layout(p)
    info, lower_inv_mass = fill_slopes(p, x, 0, slopes), 1.0 / mass_of(p, x, 1)
    inv_masses[0] = axis_jacobian(p, p.trolley, t, x, tau, 0, 0, bands)
    if d == 3:
        inv_masses[1] = axis_jacobian(p, p.bridge, t, x, tau, 1, input_count(p.trolley), bands)
    add_link(slopes, inv_masses, lower_inv_mass, (d - 1, d), (0, first), bands)
    if first == d:
        top, hoist_inv_mass = first - 1, hoist_response(p.hoist, t, tau, x, nq + first - 1)[0]
        add_entry(bands, d, top, top, -hoist_inv_mass, info.spring, info.damping)
        for a in range(d):
            position, velocity = info.spring * slopes.unit[a], info.damping * slopes.unit[a]
            add_entry(bands, d, first + a, top, lower_inv_mass, position, velocity)
            add_entry(bands, d, top, first + a, hoist_inv_mass, slopes.positions[d, a], slopes.velocities[d, a])
            if a < d - 1:
                add_entry(bands, d, a, top, -inv_masses[a], position, velocity)
                add_entry(bands, d, top, a, -hoist_inv_mass, slopes.positions[d, a], slopes.velocities[d, a])


def axis_jacobian(p, axis, t, x, tau, i, own, bands):
    """Return the inverse mass of axis i; add what its velocity does to its acceleration."""
    nq, _, d, modes = elastic_layout(p)
    mode = get_mode(p.event_limits, x, modes, i)
    low, high, width = axis_linear_span(axis, x[nq + i], (0.0, 1.0, 1.0))
    inv_mass, still = axis.response(t, tau, own, low, mode)
    bands.velocities[i, 2 * d - 1] += (axis.response(t, tau, own, high, mode)[1] - still) / width
    return inv_mass


@system.factor_shifted.register(ElasticCrane)
def _(p, jacobian, shift):
    return factor_bands(p, jacobian, shift)


@routine
def factor_bands(p, bands, shift):
    """Return the factors of β I - ∂a/∂v - ∂a/∂q / β."""
    nq, _, d, _ = elastic_layout(p)
    width, lu = 2 * d - 1, np.empty_like(bands.positions)
    for i in range(nq):
        for j in range(2 * width + 1):
            lu[i, j] = -bands.velocities[i, j] - bands.positions[i, j] / shift
        lu[i, width] += shift
    factor_band(lu)
    return Factors(shift, lu, bands, np.zeros(nq + 2 * width))


@system.solve_shifted.register(ElasticCrane)
def _(p, factors, b):
    solve(p, factors, b)


@routine
def solve(p, factors, b):
    """Overwrite b with the solution; the energy supplied follows from the rest, modes stay."""
    nq, _, d, modes = elastic_layout(p)
    shift, width, lower = factors.shift, 2 * d - 1, b[nq : 2 * nq]
    add_band_product(factors.bands.positions, b, 1.0 / shift, lower, width, factors.work)
    solve_band(factors.lu, lower, width, factors.work)
    for i in range(nq):
        b[i] = (b[i] + b[nq + i]) / shift
    if modes > 2 * nq:
        for i in range(2 * nq):
            b[2 * nq] += factors.bands.power[i] * b[i]
        b[2 * nq] /= shift
