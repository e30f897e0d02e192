"""A cable of N rigid links with lumped masses in the vertical plane, below a trolley.

Model of Brogliato, "Lagrange dynamics of lumped-mass multibody models of overhead cranes", in absolute angles from the
downward vertical. The link tensions solve a tridiagonal, positive definite system of N equations, whose condition a
heavy payload does not spoil as it does that of the N x N mass matrix.

State: one array [x, (l1), α_1 .. α_N, x', (l1'), α_1' .. α_N'], with l1 where a hoist changes the first link's length.
"""

from math import cos, sin
from typing import Any, NamedTuple

import numpy as np

from crane_sim.jit import generic, routine
from crane_sim.motions import Motion, acceleration_at
from crane_sim.quantities import Positive


class PrescribedHoist(NamedTuple):
    """A winch that gives the first link a length that is a function of time."""

    profile: Motion


class ForceHoist(NamedTuple):
    """A winch with inertia that takes a force command; positive pays out."""

    inertia: Positive  # kg, drum inertia over radius squared


class Chain(NamedTuple):
    """Node masses and link lengths from the top, (N,) arrays; the last node is the payload."""

    masses: Any  # kg
    lengths: Any  # m; the first one is the initial one where there is a hoist


@generic
def hoisted(hoist):
    """Return how many coordinates the hoist has."""
    return 1


@hoisted.register(type(None))
def _(hoist):
    return 0


@generic
def drum(hoist, t, tau):
    """Return (compliance [1/kg], free acceleration [m/s²]) of the first link's length."""
    return 0.0, 0.0


@drum.register(PrescribedHoist)
def _(hoist, t, tau):
    return 0.0, acceleration_at(hoist.profile, t)


@drum.register(ForceHoist)
def _(hoist, t, tau):
    return 1.0 / hoist.inertia, tau[len(tau) - 1] / hoist.inertia


@generic
def first_link(hoist, chain, x, nq):
    """Return (length, rate) of the first link."""
    return x[1], x[nq + 1]


@first_link.register(type(None))
def _(hoist, chain, x, nq):
    return chain.lengths[0], 0.0


@generic
def drum_inertia(hoist):
    """Return the modelled inertia [kg] of the winch."""
    return 0.0


@drum_inertia.register(ForceHoist)
def _(hoist):
    return hoist.inertia


@generic
def drum_power(hoist, tau, rate, tension):
    """Return the power [W] that the winch supplies at this rate of length and tension."""
    return -tension * rate


@drum_power.register(ForceHoist)
def _(hoist, tau, rate, tension):
    return tau[len(tau) - 1] * rate


@routine
def tensions(chain, x, first, nq, length, drive, gravity):
    """Return an array (3, N): sines and cosines of the angles, tensions of the links [N].

    Args:
        chain: masses and lengths.
        x: state; its angles begin at index `first`, their rates at nq + first.
        first, nq: where they are.
        length: of the first link [m].
        drive: (compliance, free acceleration) of the trolley and of the first link's length.
        gravity: m/s².
    """
    n, m = len(chain.masses), chain.masses
    out = np.empty((3, n))
    diagonal = np.empty(n)
    for k in range(n):
        out[0, k], out[1, k] = sin(x[first + k]), cos(x[first + k])
    give, push, pay, run = drive
    s, c, w = out[0, 0], out[1, 0], x[nq + first]
    diagonal[0] = 1.0 / m[0] + s * s * give + pay
    out[2, 0] = length * w * w - run + gravity * c - s * push
    coupling = 0.0
    for k in range(1, n):
        coupling = -(out[0, k - 1] * out[0, k] + out[1, k - 1] * out[1, k]) / m[k - 1]
        ratio = coupling / diagonal[k - 1]
        w = x[nq + first + k]
        diagonal[k] = 1.0 / m[k - 1] + 1.0 / m[k] - ratio * coupling
        out[2, k] = chain.lengths[k] * w * w - ratio * out[2, k - 1]
    out[2, n - 1] /= diagonal[n - 1]
    for k in range(n - 2, -1, -1):
        coupling = -(out[0, k] * out[0, k + 1] + out[1, k] * out[1, k + 1]) / m[k]
        out[2, k] = (out[2, k] - coupling * out[2, k + 1]) / diagonal[k]
    return out
