"""The elastic cable's Jacobian, exact and banded, and linear systems with it.

A link couples two neighbouring nodes (the first one node 1 with axes and hoist), so that in the order of the state the
derivatives of accelerations a(q, v) by positions and velocities are bands of width w = 2 d - 1. The velocities' part of
(β I - J) y = b is (β I - ∂a/∂v - ∂a/∂q / β) y_v = b_v + ∂a/∂q b_q / β, and y_q = (b_q + y_v) / β: an elimination whose
cost grows like N. It needs no pivoting, being as good as positive definite where no spring pushes hard.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.base import carried
from crane_sim.jit import kernel, routine
from crane_sim.linear_systems import add_band_product, factor_band, solve_band
from crane_sim.overhead.axes import demands, rail
from crane_sim.overhead.elastic import ElasticCrane, layout, mass_of
from crane_sim.overhead.elastic_carried import lean_on
from crane_sim.overhead.elastic_power import power_slopes
from crane_sim.overhead.elastic_slopes import fill_slopes, slopes_for
from crane_sim.overhead.hoists import drum
from crane_sim.overhead.switches import mode_of


class Bands(NamedTuple):
    """Derivatives of accelerations, as `factor_band` takes them, and of the power supplied."""

    positions: Any  # (nq, 2 w + 1)
    velocities: Any  # (nq, 2 w + 1)
    power: Any  # (2 nq,) by positions and velocities; empty of a crane without a meter


class Factors(NamedTuple):
    """What solves systems with one shift."""

    shift: float  # 1/s
    lu: Any  # (nq, 2 w + 1)
    bands: Bands
    work: Any  # (nq + 2 w,), zeros at both ends


@system.linearised.register(ElasticCrane)
def _(p, t, x, u):
    return linear(p, t, x, system.effort(u, p, t, x))


@routine
def linear(p, t, x, tau):
    """Return the bands at a state; efforts tau are taken as functions of time alone."""
    nq, first, d, _ = layout(p)
    found = Bands(np.zeros((nq, 4 * d - 1)), np.zeros((nq, 4 * d - 1)), power_slopes(p.meter, p, t, x, tau))
    slopes, weights, n = slopes_for(d), np.zeros(d), len(p.cable.masses)
    hang_on(p, t, x, tau, slopes, weights, found)
    lean_on(carried(p.base, p.gravity, t), p, weights, found)
    for k in range(1, n):
        fill_slopes(p, x, k, slopes)
        for a in range(d):
            weights[a] = 1.0 / p.cable.masses[k - 1]
        i = first + d * k
        add_link(slopes, weights, 1.0 / mass_of(p, x, k + 1), (d, d), (i - d, i), found)
    return found


@kernel
def add(found, d, row, column, weight, position, velocity):
    """Add the derivatives of one acceleration by one position and its velocity."""
    j = 2 * d - 1 + column - row
    found.positions[row, j] += weight * position
    found.velocities[row, j] += weight * velocity


@kernel
def add_link(slopes, above, below, size, starts, found):
    """Add a link between coordinates from starts[0] and from starts[1] on, size[0] and size[1] of them.

    `above` and `below` are the accelerations of its ends for a unit force [1/kg], those above one by one.
    """
    (m, d), (upper, lower) = size, starts
    for a in range(d):
        for b in range(d):
            position, velocity = slopes.positions[a, b], slopes.velocities[a, b]
            add(found, d, lower + a, lower + b, -below, position, velocity)
            if b < m:
                add(found, d, lower + a, upper + b, below, position, velocity)
            if a < m:
                add(found, d, upper + a, lower + b, above[a], position, velocity)
            if a < m and b < m:
                add(found, d, upper + a, upper + b, -above[a], position, velocity)


@routine
def hang_on(p, t, x, tau, slopes, give, found):
    """Add the first link, axes and hoist; fill the axes' compliances `give` (d,)."""
    _, first, d, _ = layout(p)
    info, below = fill_slopes(p, x, 0, slopes), 1.0 / mass_of(p, x, 1)
    give[0] = rub(p, p.trolley, t, x, tau, 0, 0, found)
    if d == 3:
        give[1] = rub(p, p.bridge, t, x, tau, 1, demands(p.trolley), found)
    add_link(slopes, give, below, (d - 1, d), (0, first), found)
    if first == d:
        top, pay = first - 1, drum(p.hoist, t, tau)[0]
        add(found, d, top, top, -pay, info.spring, info.damping)
        for a in range(d):
            position, velocity = info.spring * slopes.unit[a], info.damping * slopes.unit[a]
            add(found, d, first + a, top, below, position, velocity)
            add(found, d, top, first + a, pay, slopes.positions[d, a], slopes.velocities[d, a])
            if a < d - 1:
                add(found, d, a, top, -give[a], position, velocity)
                add(found, d, top, a, -pay, slopes.positions[d, a], slopes.velocities[d, a])


@kernel
def rub(p, axis, t, x, tau, i, own, found):
    """Return the compliance of axis i; add what its velocity does to its acceleration, which is linear in it."""
    nq, _, d, modes = layout(p)
    mode = mode_of(p.switches, x, modes, i)
    give, still = rail(axis, t, tau, own, 0.0, mode)
    found.velocities[i, 2 * d - 1] += rail(axis, t, tau, own, 1.0, mode)[1] - still
    return give


@system.factored.register(ElasticCrane)
def _(p, jacobian, shift):
    return shifted(p, jacobian, shift)


@routine
def shifted(p, found, shift):
    """Return the factors of β I - ∂a/∂v - ∂a/∂q / β."""
    nq, _, d, _ = layout(p)
    width, lu = 2 * d - 1, np.empty_like(found.positions)
    for i in range(nq):
        for j in range(2 * width + 1):
            lu[i, j] = -found.velocities[i, j] - found.positions[i, j] / shift
        lu[i, width] += shift
    factor_band(lu)
    return Factors(shift, lu, found, np.zeros(nq + 2 * width))


@system.solve_shifted.register(ElasticCrane)
def _(p, factors, b):
    solve(p, factors, b)


@routine
def solve(p, factors, b):
    """Overwrite b with the solution; the energy supplied follows from the rest, modes stay."""
    nq, _, d, modes = layout(p)
    shift, width, lower = factors.shift, 2 * d - 1, b[nq : 2 * nq]
    add_band_product(factors.bands.positions, b, 1.0 / shift, lower, width, factors.work)
    solve_band(factors.lu, lower, width, factors.work)
    for i in range(nq):
        b[i] = (b[i] + b[nq + i]) / shift
    if modes > 2 * nq:
        for i in range(2 * nq):
            b[2 * nq] += factors.bands.power[i] * b[i]
        b[2 * nq] /= shift
