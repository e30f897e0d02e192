"""The elastic cable's Jacobian as bands, and linear systems with it.

A link couples two neighbouring nodes of d coordinates (the first one node 1 with the f coordinates
of support and hoist), so that in the order of the state the derivatives of accelerations a(q, v) by
positions and velocities are bands of width w = d - 1 + max(d, f): columns that are 2 w + 1 apart
share no row, and one direction has them all. The part of (β I - J) y = b for velocities is (β I -
∂a/∂v - ∂a/∂q / β) y_v = b_v + ∂a/∂q b_q / β, and y_q = (b_q + y_v) / β: an elimination whose cost
grows like N. It needs no pivoting, being as good as positive definite where no spring pushes hard.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.carrier.layout import layout_of
from crane_sim.models.elastic.crane import ElasticCrane
from crane_sim.numerics.derivatives import DIRECTIONS, directional_derivatives
from crane_sim.numerics.jit import routine, simd_range
from crane_sim.numerics.linear_systems import add_band_product, factor_band, solve_band


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


def band_width(p):
    """Return the width w of the bands."""
    d, (_, first, _) = p.dimensions(), layout_of(p)
    return d - 1 + max(d, first)


@system.compute_jacobian.register(ElasticCrane)
def compute_bands(p, t, x, u):
    """Return the Jacobian as bands, and the derivative in time."""
    return bands_at(p, t, x, system.effort(u, p, t, x))


@routine
def bands_at(p, t, x, tau):
    """Return (the bands at a state, the derivative in time); efforts tau depend on time alone."""
    (nq, _, modes), width = layout_of(p), band_width(p)
    metered = modes > 2 * nq  # the power depends on all coordinates
    period = nq if metered else 2 * width + 1
    bands = Bands(
        np.zeros((nq, 2 * width + 1)),
        np.zeros((nq, 2 * width + 1)),
        np.zeros(2 * nq if metered else 0),
    )
    seeds, of_time, change = np.zeros((len(x), DIRECTIONS)), np.zeros(DIRECTIONS), np.empty_like(x)
    for first in range(0, 2 * period + 1, DIRECTIONS):
        mark_columns(seeds, nq, period, first, 1.0)
        for k in range(DIRECTIONS):
            of_time[k] = 1.0 if first + k == 2 * period else 0.0
        rows = directional_derivatives(system.rhs, (p, t, x, tau), (None, of_time, seeds, None))[1]
        mark_columns(seeds, nq, period, first, 0.0)
        for j in range(2 * nq):
            k = direction_of(j, nq, period) - first
            if 0 <= k < DIRECTIONS:
                take_column(bands, rows, j, k)
        if 2 * period < first + DIRECTIONS:
            for i in range(len(x)):
                change[i] = rows[i, 2 * period - first]
    return bands, change


def direction_of(j, nq, period):
    """Return the number of the direction that coordinate or velocity j is moved in."""
    return j % period if j < nq else period + (j - nq) % period


def mark_columns(seeds, nq, period, first, mark):
    """Write a mark where a direction, from number `first` on, moves a coordinate or velocity."""
    for j in range(2 * nq):
        k = direction_of(j, nq, period) - first
        if 0 <= k < DIRECTIONS:
            seeds[j, k] = mark


def take_column(bands, rows, j, k):
    """Copy the derivatives by coordinate or velocity j from direction k of `rows`."""
    nq, width = len(bands.positions), bands.positions.shape[1] // 2
    column = j if j < nq else j - nq
    for i in range(max(0, column - width), min(nq, column + width + 1)):
        if j < nq:
            bands.positions[i, width + column - i] = rows[nq + i, k]
        else:
            bands.velocities[i, width + column - i] = rows[nq + i, k]
    if len(bands.power) > 0:
        bands.power[j] = rows[2 * nq, k]


@system.factor_shifted.register(ElasticCrane)
@routine
def factor_bands(p, bands, shift):
    """Return the factors of β I - ∂a/∂v - ∂a/∂q / β."""
    (nq, _, _), width, lu = layout_of(p), band_width(p), np.empty_like(bands.positions)
    for i in range(nq):
        for j in range(2 * width + 1):
            lu[i, j] = -bands.velocities[i, j] - bands.positions[i, j] / shift
        lu[i, width] += shift
    factor_band(lu)
    return Factors(shift, lu, bands, np.zeros(nq + 2 * width))


@system.solve_shifted.register(ElasticCrane)
@routine
def solve(p, factors, b):
    """Overwrite b with the solution; the energy supplied follows from the rest, modes stay."""
    (nq, _, modes), shift, width = layout_of(p), factors.shift, band_width(p)
    lower = b[nq : 2 * nq]
    add_band_product(factors.bands.positions, b, 1.0 / shift, lower, width, factors.work)
    solve_band(factors.lu, lower, width, factors.work)
    for i in simd_range(nq):
        b[i] = (b[i] + b[nq + i]) / shift
    if modes > 2 * nq:
        for i in range(2 * nq):
            b[2 * nq] += factors.bands.power[i] * b[i]
        b[2 * nq] /= shift
