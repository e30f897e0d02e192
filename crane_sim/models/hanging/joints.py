"""Joint coordinates of a crane whose load hangs below a support: its own, links, the attitude.

They are those of the simple crane, then those of further links, then the load's attitude.

A support that turns gives those of `single_rope`: its own coordinates, the first link's length and
its two swing angles in the turning frame,

    n = (sin θ2, cos θ2 sin θ1, -cos θ2 cos θ1),

so that a law for the simple crane reads them unchanged. A driven point and an overhead crane have
their own coordinates, the length where a hoist changes it, and the first link's unit vector.
Further links are unit vectors in the axes of the base, an attitude is a quaternion (w, x, y, z).
"""

from math import atan2, cos, sin, sqrt

import numpy as np

from crane_sim.models.carrier.layout import layout_of, rope_length
from crane_sim.models.single_rope.joint_coordinates import POLE
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.hoist import hoist_coordinates
from crane_sim.models.supports.support import (
    coordinate_count,
    read_state,
    to_coordinate_order,
    to_joint_order,
    trailing_count,
    yaw,
)
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.multibody.vectors import to_turned_axes
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine


def has_swing_angles(p):
    """Return whether length and swing angles give the first link, and not its unit vector."""
    return (
        isinstance(p, SuspendedCrane)
        and p.overhead is None
        and not isinstance(p.support.structure, DrivenPoint)
    )


def swing_start(p):
    """Return the index of the first link's length among the joints."""
    return coordinate_count(p.support) - trailing_count(p.support)


def with_swing(p, row, swing):
    """Return a row in the order of joints with (length, θ1, θ2) for the first link."""
    start, taken = swing_start(p), hoist_coordinates(p.hoist) + 3
    out = np.empty(len(row) + 3 - taken)
    for i in range(start):
        out[i] = row[i]
    out[start], out[start + 1], out[start + 2] = swing
    for i in range(start + 3, len(out)):
        out[i] = row[i + taken - 3]
    return out


def without_swing(p, row):
    """Return a row in the order of joints with 0 for the first link's unit vector.

    The length is kept where a hoist changes it.
    """
    start, taken = swing_start(p), hoist_coordinates(p.hoist) + 3
    out = np.zeros(len(row) + taken - 3)
    for i in range(start + hoist_coordinates(p.hoist)):
        out[i] = row[i]
    for i in range(start + 3, len(row)):
        out[i + taken - 3] = row[i]
    return out


def angles_of(n, rates):
    """Return (θ1, θ2) and their rates of a unit vector (3,) and its rates, in the turning frame."""
    c2 = sqrt(n[1] * n[1] + n[2] * n[2])
    theta1 = atan2(n[1], -n[2]) if c2 > 0.0 else 0.0
    s1, c1 = sin(theta1), cos(theta1)
    first = (c1 * rates[1] + s1 * rates[2]) / max(c2, POLE)
    return (theta1, atan2(n[0], c2)), (
        first,
        c2 * rates[0] + n[0] * (c1 * rates[2] - s1 * rates[1]),
    )


def vector_of(angles, rates):
    """Return (unit vector, its rates), each (3,), of swing angles (θ1, θ2) and their rates."""
    s1, c1, s2, c2 = sin(angles[0]), cos(angles[0]), sin(angles[1]), cos(angles[1])
    (w1, w2) = rates
    n = (s2, c2 * s1, -c2 * c1)
    return n, (c2 * w2, c2 * c1 * w1 - s2 * s1 * w2, c2 * s1 * w1 + s2 * c1 * w2)


def in_turning_frame(p, x):
    """Return (unit vector, its rates) of the first link in the support's frame."""
    nq, i, _ = layout_of(p)
    s, c = sincos(yaw(p.support, read_state(p.support, x, nq).q))
    n = to_turned_axes((x[i], x[i + 1], x[i + 2]), s, c)
    x1, y1, z1 = to_turned_axes((x[nq + i], x[nq + i + 1], x[nq + i + 2]), s, c)
    w = yaw_entry(p.support, x, nq)
    return n, (x1 + w * n[1], y1 - w * n[0], z1)


def yaw_entry(support, row, i):
    """Return the entry of the angle about the vertical in a row of rates that begins at i.

    The row may be one of accelerations.
    """
    return sum((row[i + k] for k in support.structure.mechanism().yaw), 0.0)


@routine
def joint_coordinates(p, x):
    """Return (q, v), arrays (nj,)."""
    nq, _, _ = layout_of(p)
    q, v = to_joint_order(p.support, x[:nq]), to_joint_order(p.support, x[nq : 2 * nq])
    if not has_swing_angles(p):
        return q, v
    (length, rate), (angles, angle_rates) = rope_length(p, x), angles_of(*in_turning_frame(p, x))
    return with_swing(p, q, (length, *angles)), with_swing(p, v, (rate, *angle_rates))


def write_joints(p, x, q, v):
    """Write joint positions and velocities into state x."""
    if not has_swing_angles(p):
        fill_coordinates(p, x, q, v)
        return
    fill_coordinates(p, x, without_swing(p, q), without_swing(p, v))
    i = swing_start(p) + 1
    write_direction(p, x, *vector_of((q[i], q[i + 1]), (v[i], v[i + 1])))


def fill_coordinates(p, x, q, v):
    """Write positions and rates, given in the order of joints, into state x."""
    positions, rates = to_coordinate_order(p.support, q), to_coordinate_order(p.support, v)
    for i in range(len(positions)):
        x[i], x[len(positions) + i] = positions[i], rates[i]


def write_direction(p, x, direction, rates):
    """Write the first link's unit vector and rates, given in the support's frame, into state x."""
    nq, first, _ = layout_of(p)
    s, c = sincos(yaw(p.support, read_state(p.support, x, nq).q))
    w = yaw_entry(p.support, x, nq)
    rates = (rates[0] - w * direction[1], rates[1] + w * direction[0], rates[2])
    (x[first], x[first + 1], x[first + 2]) = to_turned_axes(direction, -s, c)
    (x[nq + first], x[nq + first + 1], x[nq + first + 2]) = to_turned_axes(rates, -s, c)


@routine
def accelerations_of_joints(p, x, rates):
    """Return the joint coordinates' second derivatives (nj,); rates: derivative of the state x."""
    nq, first, _ = layout_of(p)
    out = to_joint_order(p.support, rates[nq : 2 * nq])
    if not has_swing_angles(p):
        return out
    length = 0.0 if p.hoist is None else rates[nq + first - 1]
    return with_swing(p, out, (length, *angle_accelerations(p, x, rates)))


def angle_accelerations(p, x, rates):
    """Return the second derivatives of the swing angles (θ1, θ2)."""
    (nq, first, _), (n, (dx, dy, dz)) = layout_of(p), in_turning_frame(p, x)
    s, c = sincos(yaw(p.support, read_state(p.support, x, nq).q))
    i = nq + first
    ax, ay, az = to_turned_axes((rates[i], rates[i + 1], rates[i + 2]), s, c)
    w, w_dot = yaw_entry(p.support, x, nq), yaw_entry(p.support, rates, nq)
    ax, ay = (
        ax + 2.0 * w * dy + w_dot * n[1] + w * w * n[0],
        ay - 2.0 * w * dx - w_dot * n[0] + w * w * n[1],
    )
    c2 = max(sqrt(n[1] * n[1] + n[2] * n[2]), POLE)
    square, rate1 = c2 * c2, (n[1] * dz - n[2] * dy) / (c2 * c2)
    first_acc = (n[1] * az - n[2] * ay) / square - 2.0 * rate1 * (n[1] * dy + n[2] * dz) / square
    return first_acc, (ax + n[0] * (dx / c2) ** 2) / c2
