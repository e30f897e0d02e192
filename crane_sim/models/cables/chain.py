"""Rigid links with lumped masses in the vertical plane: their tensions and angular accelerations.

The tensions solve a tridiagonal, positive definite system of N equations, whose condition a heavy
payload does not spoil as it does that of the N x N mass matrix. Angles are absolute, from the
downward vertical; n_k = (sin α_k, -cos α_k) points down link k, t_k = (cos α_k, sin α_k) where it
moves when α_k grows. Node 0 is the trolley.

A link with a moment of inertia (`Rods`) also transmits a transverse force, and its angular
acceleration is an unknown, too. Stiffness and damping of joints between links (`Joints`) are
couples on the links, equivalent to transverse forces on the nodes at their ends.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import local_array, routine, simd_range, use_wide_vectors
from crane_sim.numerics.rows import elementwise


class Chain(NamedTuple):
    """Node masses and link lengths from the top, (N,) arrays; the last node is the payload.

    Of a short chain in the plane they are tuples (`make_chain`): code is made for the number of its
    links.
    """

    masses: Any  # kg
    lengths: Any  # m; where there is a hoist, the first one is a coordinate and not used

    def with_payload(self, mass):
        """Return the cable with another payload [kg]."""
        if isinstance(self.masses, tuple):
            return self._replace(masses=(*self.masses[:-1], mass))
        masses = self.masses.copy()
        masses[len(masses) - 1] = mass
        return self._replace(masses=masses)


LONGEST_KNOWN = 16
"""Links of a chain in the plane up to which their number is part of its code."""


def make_chain(masses, lengths):
    """Return the chain in the plane with these masses and lengths."""
    if len(masses) > LONGEST_KNOWN:
        return Chain(np.array(masses), np.array(lengths))
    return Chain(tuple(map(float, masses)), tuple(map(float, lengths)))


class Rods(NamedTuple):
    """Moments of inertia of links about their ends' line, (N,), as they turn (Brogliato, 8.1)."""

    inertia: Any  # kg m²


ROWS = 13
"""Rows of the work array (ROWS, N + 1) in which one evaluation keeps what it computes; links in
columns 0 to N - 1."""
SIN, COS, RATE, LENGTH = 0, 1, 2, 3  # of the links
INV_MASS = 4  # 1/kg, of the node below each link
# m/s², what a link's tension has to supply: the relative acceleration of its ends along it
RHS_ALONG = 5
RHS_ACROSS = 6  # m/s², the relative acceleration of its ends across it that needs no tension
TENSION = 7  # N
TURNING = 8  # rad/s², angular acceleration
DIAGONAL, FACTOR = 9, 10  # 1/kg, of the system's matrix; of its elimination
# 1/kg, cosine and sine of the bend from link k to k + 1, over the mass of the node between
BEND_COS, BEND_SIN = 11, 12


@routine
def work_array(masses, lengths):
    """Return a work array with what does not change; the last column, without a link, is zero."""
    n = len(masses)
    w = np.zeros((ROWS, n + 1))
    for k in range(n):
        w[LENGTH, k], w[INV_MASS, k] = lengths[k], 1.0 / masses[k]
    return w


def copy_constants(work, w):
    """Fill what does not change of a work array w, from that of the run."""
    n = w.shape[1] - 1
    for row in range(ROWS):
        w[row, n] = 0.0
    w[BEND_COS, n - 1], w[BEND_SIN, n - 1] = 0.0, 0.0
    for k in range(n):
        w[LENGTH, k], w[INV_MASS, k] = work[LENGTH, k], work[INV_MASS, k]


def add_node_acceleration(w, node, x, z):
    """Add an acceleration (x, z) [m/s²] of a node, from 1, to the links that end there."""
    k = node - 1
    w[RHS_ALONG, k] += w[SIN, k] * x - w[COS, k] * z
    w[RHS_ACROSS, k] += w[COS, k] * x + w[SIN, k] * z
    if node < w.shape[1] - 1:
        w[RHS_ALONG, node] -= w[SIN, node] * x - w[COS, node] * z
        w[RHS_ACROSS, node] -= w[COS, node] * x + w[SIN, node] * z


def add_couple(w, k, force):
    """Add a couple on link k: a force [N] across it on the lower node, and back on the upper."""
    if k > 0:
        acc = -force * w[INV_MASS, k - 1]
        add_node_acceleration(w, k, acc * w[COS, k], acc * w[SIN, k])
    acc = force * w[INV_MASS, k]
    add_node_acceleration(w, k + 1, acc * w[COS, k], acc * w[SIN, k])


def rod_pull(rods, w):
    """Return the horizontal force [N] on the trolley that the first link carries across."""
    return 0.0 if rods is None else rods.inertia[0] / w[LENGTH, 0] * w[TURNING, 0] * w[COS, 0]


def assemble_rhs(w, bias_acc, gravity):
    """Fill what the links' own motion, gravity and the trolley's `bias_acc` [m/s²] ask of them."""
    for k in simd_range(w.shape[1] - 1):
        w[RHS_ALONG, k], w[RHS_ACROSS, k] = w[LENGTH, k] * w[RATE, k] * w[RATE, k], 0.0
    w[RHS_ALONG, 0] += w[COS, 0] * gravity - w[SIN, 0] * bias_acc
    w[RHS_ACROSS, 0] = -(w[COS, 0] * bias_acc + w[SIN, 0] * gravity)


def solve_links(rods, w, top):
    """Solve for tensions [N] and angular accelerations [rad/s²] of the links in the work array w.

    Args:
        rods: the links' inertia, None where they have none.
        w: work array with everything else.
        top: (inverse mass of the axis [1/kg], inverse mass and bias acceleration of the first
            length, its rate [m/s]); an inverse mass of -1 says that the acceleration is the tension
            itself (`hoist_response`).
    """
    if rods is not None:
        solve_pairs(rods.inertia, w, top)
    else:
        solve_tensions(w, top)
        angular_accelerations(w, top)


@elementwise
def fill_sines(angle):
    """Fill sines and cosines of angles."""
    return sincos(angle)


def fill_known_sines(n, angles, readable, w):
    """Fill sines and cosines of n angles, a known number.

    Whole vectors are computed where so many numbers can be read.
    """
    lanes = (n + 7) // 8 * 8
    if lanes > readable:
        for k in range(n):
            w[SIN, k], w[COS, k] = sincos(angles[k])
        return
    found = local_array((2, lanes))
    fill_sines_of_lanes(angles, found)
    for k in range(n):
        w[SIN, k], w[COS, k] = found[0, k], found[1, k]


@routine
def fill_sines_of_lanes(angles, out):
    """Fill sines and cosines (2, lanes)."""
    use_wide_vectors()
    for k in simd_range(out.shape[1]):
        out[0, k], out[1, k] = sincos(angles[k])


@elementwise
def fill_bends(s, c, s_below, c_below, inv_mass):
    """Fill cosines and sines of bends, over the mass between a link and the one below."""
    return (s * s_below + c * c_below) * inv_mass, (c * s_below - s * c_below) * inv_mass


def link_angles(w):
    """Fill the rows of the bends."""
    fill_bends(
        w.shape[1] - 2,
        (w[BEND_COS], w[BEND_SIN]),
        (w[SIN], w[COS], w[SIN, 1:], w[COS, 1:], w[INV_MASS]),
    )


def assemble_diagonal(w, top):
    """Fill the diagonal, and add the hoist to the right-hand side of the first link."""
    axis_inv_mass, hoist_inv_mass, hoist_bias_acc, _ = top
    for k in simd_range(1, w.shape[1] - 1):
        w[DIAGONAL, k] = w[INV_MASS, k - 1] + w[INV_MASS, k]
    w[DIAGONAL, 0] = w[INV_MASS, 0] + w[SIN, 0] * w[SIN, 0] * axis_inv_mass + hoist_inv_mass
    w[RHS_ALONG, 0] -= hoist_bias_acc
    if hoist_inv_mass < 0.0:
        # a massless winch: the first tension is given, which replaces the first link's equation
        w[DIAGONAL, 0], w[RHS_ALONG, 0] = 1.0, hoist_bias_acc
        w[RHS_ALONG, 1] += w[BEND_COS, 0] * hoist_bias_acc


def eliminate_row(w, k, off_diagonal, less, more):
    """Eliminate row k of the system; return the changes of the next row.

    The changes are those of its pivot, to subtract, and of its right-hand side.

    Args:
        w: work array.
        k: of the row.
        off_diagonal: entry of rows k and k + 1.
        less, more: changes of pivot and right-hand side by the row before.
    """
    pivot, right = w[DIAGONAL, k] - less, w[RHS_ALONG, k] + more
    inverse = 1.0 / pivot
    w[TENSION, k], w[FACTOR, k] = right * inverse, off_diagonal * inverse
    return off_diagonal * off_diagonal / pivot, w[FACTOR, k] * right


def solve_tensions(w, top):
    """Eliminate from both ends to the middle and substitute back; arguments of `solve_links`.

    The two halves do not wait for each other, so the processor works on both at once; the pivots
    are those of a positive definite matrix, whichever order they are taken in.
    """
    n = w.shape[1] - 1
    link_angles(w)
    assemble_diagonal(w, top)
    first = w[BEND_COS, 0] if top[1] >= 0.0 else 0.0
    middle, half = n // 2, (n - 1) // 2
    less, more, less_below, more_below = 0.0, 0.0, 0.0, 0.0
    for k in range(middle):
        less, more = eliminate_row(w, k, first if k == 0 else w[BEND_COS, k], less, more)
        if k < half:
            j = n - 1 - k
            upper = first if j == 1 else w[BEND_COS, j - 1]
            less_below, more_below = eliminate_row(w, j, upper, less_below, more_below)
    tension = (w[RHS_ALONG, middle] + more + more_below) / (w[DIAGONAL, middle] - less - less_below)
    below, w[TENSION, middle] = tension, tension
    for k in range(1, middle + 1):
        tension = w[TENSION, middle - k] + w[FACTOR, middle - k] * tension
        w[TENSION, middle - k] = tension
        if k <= half:
            below = w[TENSION, middle + k] + w[FACTOR, middle + k] * below
            w[TENSION, middle + k] = below


def angular_accelerations(w, top):
    """Fill the angular accelerations, without differences that a heavy payload makes large."""
    n, (axis_inv_mass, _, _, rate) = w.shape[1] - 1, top
    first = w[COS, 0] * axis_inv_mass * w[TENSION, 0] * w[SIN, 0] + 2.0 * rate * w[RATE, 0]
    w[TURNING, 0] = (w[RHS_ACROSS, 0] + w[BEND_SIN, 0] * w[TENSION, 1] - first) / w[LENGTH, 0]
    for k in simd_range(1, n):
        pulled = w[BEND_SIN, k] * w[TENSION, k + 1] - w[BEND_SIN, k - 1] * w[TENSION, k - 1]
        w[TURNING, k] = (w[RHS_ACROSS, k] + pulled) / w[LENGTH, k]


def massless_hoist_acceleration(w, axis_inv_mass, rhs_along):
    """Return the acceleration of the first length behind a massless winch.

    `rhs_along` was the first link's.
    """
    inv_mass = w[INV_MASS, 0] + w[SIN, 0] * w[SIN, 0] * axis_inv_mass
    return rhs_along - inv_mass * w[TENSION, 0] + w[BEND_COS, 0] * w[TENSION, 1]


def rod_energy(rods, rates):
    """Return the kinetic energy [J] of turning links."""
    energy = 0.0
    if rods is not None:
        for k in range(len(rates)):
            energy += 0.5 * rods.inertia[k] * rates[k] ** 2
    return energy


def coupling(w, inertia, k, j):
    """Return the 2 x 2 block, by rows, of the effect of link j's (tension, turning) on link k.

    It acts across the node between them.
    """
    node = min(k, j)
    along, across, arm = w[BEND_COS, node], w[BEND_SIN, node], inertia[j] / w[LENGTH, j]
    across = across if j > k else -across
    return -along, across * arm, -across, -along * arm


def diagonal_block(w, inertia, top, k):
    """Return the 2 x 2 block, by rows, of link k's own (tension, turning)."""
    arm, length = inertia[k] / w[LENGTH, k], w[LENGTH, k]
    if k > 0:
        own = w[INV_MASS, k - 1] + w[INV_MASS, k]
        return own, 0.0, 0.0, own * arm + length
    axis, hoist, _, _ = top
    s, c, own = w[SIN, 0], w[COS, 0], w[INV_MASS, 0]
    return (
        own + s * s * axis + hoist,
        s * c * axis * arm,
        s * c * axis,
        (own + c * c * axis) * arm + length,
    )


def block_rhs(w, top, k):
    """Return the right-hand sides of link k: along it and across it."""
    along, across = w[RHS_ALONG, k], w[RHS_ACROSS, k]
    if k > 0:
        return along, across
    _, _, hoist_bias_acc, rate = top
    return along - hoist_bias_acc, across - 2.0 * rate * w[RATE, 0]


@routine
def solve_pairs(inertia, w, top):
    """Eliminate 2 x 2 blocks downwards, substitute upwards; arguments of `chain.solve_links`."""
    n = w.shape[1] - 1
    right = np.zeros((n, 4))  # the inverse of an eliminated block times the one right of it
    link_angles(w)
    for k in range(n):
        a, b, c, d = diagonal_block(w, inertia, top, k)
        along, across = block_rhs(w, top, k)
        if k > 0:
            e, f, g, h = coupling(w, inertia, k, k - 1)
            a, b = (
                a - e * right[k - 1, 0] - f * right[k - 1, 2],
                b - e * right[k - 1, 1] - f * right[k - 1, 3],
            )
            c, d = (
                c - g * right[k - 1, 0] - h * right[k - 1, 2],
                d - g * right[k - 1, 1] - h * right[k - 1, 3],
            )
            along = along - e * w[TENSION, k - 1] - f * w[TURNING, k - 1]
            across = across - g * w[TENSION, k - 1] - h * w[TURNING, k - 1]
        inverse = 1.0 / (a * d - b * c)
        w[TENSION, k], w[TURNING, k] = (
            (d * along - b * across) * inverse,
            (a * across - c * along) * inverse,
        )
        if k + 1 < n:
            e, f, g, h = coupling(w, inertia, k, k + 1)
            right[k, 0], right[k, 1] = (d * e - b * g) * inverse, (d * f - b * h) * inverse
            right[k, 2], right[k, 3] = (a * g - c * e) * inverse, (a * h - c * f) * inverse
    for k in range(n - 2, -1, -1):
        along, across = w[TENSION, k + 1], w[TURNING, k + 1]
        w[TENSION, k] -= right[k, 0] * along + right[k, 1] * across
        w[TURNING, k] -= right[k, 2] * along + right[k, 3] * across


class Joints(NamedTuple):
    """Stiffness and damping between links, (N,) arrays; the first is between trolley and link 1."""

    stiffness: Any  # N m/rad
    damping: Any  # N m s/rad


def add_joints(joints, w, x, first):
    """Add moments of joints to the right-hand sides; return the trolley's force.

    The links' angles begin at x[first].
    """
    if joints is None:
        return 0.0
    n = len(joints.stiffness)
    moment, pull = joints.stiffness[0] * x[first] + joints.damping[0] * w[RATE, 0], 0.0
    for k in range(n):
        after = 0.0
        if k + 1 < n:
            after = joints.stiffness[k + 1] * (x[first + k + 1] - x[first + k])
            after += joints.damping[k + 1] * (w[RATE, k + 1] - w[RATE, k])
        force = (after - moment) / w[LENGTH, k]
        if k == 0:
            pull = -force * w[COS, 0]
        add_couple(w, k, force)
        moment = after
    return pull


def joint_energy(joints, angles):
    """Return the energy [J] stored in the joints."""
    if joints is None:
        return 0.0
    energy = 0.5 * joints.stiffness[0] * angles[0] ** 2
    for k in range(1, len(angles)):
        energy += 0.5 * joints.stiffness[k] * (angles[k] - angles[k - 1]) ** 2
    return energy


def joint_power(joints, rates):
    """Return the power [W] that the joints' damping takes, negative."""
    if joints is None:
        return 0.0
    power = -joints.damping[0] * rates[0] ** 2
    for k in range(1, len(rates)):
        power -= joints.damping[k] * (rates[k] - rates[k - 1]) ** 2
    return power
