"""Rigid links with lumped masses in the vertical plane: their tensions and angular accelerations.

The tensions solve a tridiagonal, positive definite system of N equations, whose condition a heavy payload does not
spoil as it does that of the N x N mass matrix. Angles are absolute, from the downward vertical; n_k = (sin α_k, -cos α_k)
points down link k, t_k = (cos α_k, sin α_k) is where it moves when α_k grows. Node 0 is the trolley.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.jit import generic, kernel, routine


class Chain(NamedTuple):
    """Node masses and link lengths from the top, (N,) arrays; the last node is the payload."""

    masses: Any  # kg
    lengths: Any  # m; the first one is the initial one where there is a hoist


class Joints(NamedTuple):
    """Stiffness and damping between links, (N,) arrays; the first one is between the trolley and link 1."""

    stiffness: Any  # N m/rad
    damping: Any  # N m s/rad


class Rods(NamedTuple):
    """Moments of inertia of the links about their ends' line, (N,): they turn with the links (Brogliato, 8.1)."""

    inertia: Any  # kg m²


class Links(NamedTuple):
    """What the links' states give, arrays (N,)."""

    sines: Any
    cosines: Any
    rates: Any  # rad/s
    lengths: Any  # m
    below: Any  # 1/kg, one over the mass of the node below each link


@generic
def add_joints(joints, links, angles, acc):
    """Add what the joints' moments do to the nodes' free accelerations (N + 1, 3) [m/s²]; node 0 gets forces [N]."""


@add_joints.register(Joints)
def _(joints, links, angles, acc):
    n = len(links.rates)
    moment = joints.stiffness[0] * angles[0] + joints.damping[0] * links.rates[0]
    for k in range(n):
        after = 0.0
        if k + 1 < n:
            after = joints.stiffness[k + 1] * (angles[k + 1] - angles[k])
            after += joints.damping[k + 1] * (links.rates[k + 1] - links.rates[k])
        force = (after - moment) / links.lengths[k]  # the couple of link k: on its lower node, and back on its upper one
        above = 1.0 if k == 0 else links.below[k - 1]
        acc[k, 0] -= force * above * links.cosines[k]
        acc[k, 2] -= force * above * links.sines[k]
        acc[k + 1, 0] += force * links.below[k] * links.cosines[k]
        acc[k + 1, 2] += force * links.below[k] * links.sines[k]
        moment = after


@generic
def joint_energy(joints, angles):
    """Return the energy [J] stored in the joints."""
    return 0.0


@joint_energy.register(Joints)
def _(joints, angles):
    energy = 0.5 * joints.stiffness[0] * angles[0] ** 2
    for k in range(1, len(angles)):
        energy += 0.5 * joints.stiffness[k] * (angles[k] - angles[k - 1]) ** 2
    return energy


@generic
def joint_power(joints, rates):
    """Return the power [W] that the joints' damping takes, negative."""
    return 0.0


@joint_power.register(Joints)
def _(joints, rates):
    power = -joints.damping[0] * rates[0] ** 2
    for k in range(1, len(rates)):
        power -= joints.damping[k] * (rates[k] - rates[k - 1]) ** 2
    return power


@generic
def rod_energy(rods, rates):
    """Return the kinetic energy [J] of turning links."""
    return 0.0


@rod_energy.register(Rods)
def _(rods, rates):
    energy = 0.0
    for k in range(len(rates)):
        energy += 0.5 * rods.inertia[k] * rates[k] ** 2
    return energy


@generic
def rod_pull(rods, links, turning):
    """Return the horizontal force [N] on the trolley that the first link carries across."""
    return 0.0


@generic
def solve_links(rods, links, top, acc, tension, turning):
    """Solve for the links' tensions [N] and angular accelerations [rad/s²].

    Args:
        rods: the links' inertia, None where they have none.
        links: what their states give.
        top: (compliance of the axis [1/kg], compliance and free acceleration of the first length, its rate [m/s]);
            a compliance of -1 says that the acceleration is the tension itself (`drum`).
        acc: accelerations of nodes 0 to N without tensions (N + 1, 3) [m/s²], world frame.
        tension, turning: to fill (N,).
    """
    solve_tensions(links, top, acc, tension)
    turn(links, top, acc, tension, turning)


@kernel
def demanded(links, top, acc, k):
    """Return what link k's tension has to supply: the relative acceleration of its ends along it [m/s²]."""
    w, s, c = links.rates[k], links.sines[k], links.cosines[k]
    return links.lengths[k] * w * w + s * (acc[k + 1, 0] - acc[k, 0]) - c * (acc[k + 1, 2] - acc[k, 2])


@routine
def solve_tensions(links, top, acc, tension):
    """Eliminate downwards, substitute upwards; arguments as of `solve_links`."""
    n, (give, pay, run, _) = len(tension), top
    s, c, below = links.sines, links.cosines, links.below
    diagonal = np.empty(n)
    diagonal[0] = below[0] + s[0] * s[0] * give + pay
    tension[0] = demanded(links, top, acc, 0) - run
    if pay < 0.0:
        diagonal[0], tension[0] = 1.0, run
    for k in range(1, n):
        upper = -(s[k - 1] * s[k] + c[k - 1] * c[k]) * below[k - 1]
        ratio = upper / diagonal[k - 1]
        known = 0.0 if pay < 0.0 and k == 1 else upper  # row 0 of a massless winch does not know T_1
        diagonal[k] = below[k - 1] + below[k] - ratio * known
        tension[k] = demanded(links, top, acc, k) - ratio * tension[k - 1]
    tension[n - 1] /= diagonal[n - 1]
    for k in range(n - 2, -1, -1):
        upper = -(s[k] * s[k + 1] + c[k] * c[k + 1]) * below[k]
        if k > 0 or pay >= 0.0:
            tension[k] = (tension[k] - upper * tension[k + 1]) / diagonal[k]


@kernel
def turn(links, top, acc, tension, turning):
    """Fill the angular accelerations; no difference of large numbers, so that a heavy payload does no harm."""
    n, (give, _, _, rate) = len(tension), top
    s, c = links.sines, links.cosines
    above = -c[0] * give * tension[0] * s[0] - 2.0 * rate * links.rates[0]
    for k in range(n):
        total = above + c[k] * (acc[k + 1, 0] - acc[k, 0]) + s[k] * (acc[k + 1, 2] - acc[k, 2])
        if k + 1 < n:
            bend = (c[k] * s[k + 1] - s[k] * c[k + 1]) * links.below[k]
            total += bend * tension[k + 1]
            above = -bend * tension[k]
        turning[k] = total / links.lengths[k]
