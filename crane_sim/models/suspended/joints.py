"""Joint coordinates of a suspended crane: the simple crane's first, then further links and the load's attitude.

A support that turns gives those of `single_rope`: its own coordinates, the first link's length and its two swing
angles in the turning frame,

    n = (sin θ2, cos θ2 sin θ1, -cos θ2 cos θ1),

so that a law for the simple crane reads them unchanged. A driven point has its position and the first link's unit
vector. Further links are unit vectors in the axes of the base, an attitude is a quaternion (w, x, y, z).
"""

from math import atan2, cos, sin, sqrt

import numpy as np

from crane_sim import system
from crane_sim.models.moving_base import to_turned_axes
from crane_sim.models.single_rope.joint_coordinates import POLE
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.hoist import hoist_coordinates, hoist_modes
from crane_sim.models.supports.joint_modes import initialize_modes
from crane_sim.models.supports.support import coordinate_count, read_state, trailing_count, yaw
from crane_sim.models.suspended.crane import SuspendedCrane, first_length, mode_count, suspended_layout
from crane_sim.models.suspended.exchange import count_exchanges
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine


def has_swing_angles(support):
    """Return whether the first link is given by its length and swing angles; otherwise by its unit vector."""
    return not isinstance(support.structure, DrivenPoint)


def swing_count(p):
    """Return the number of joint coordinates that give the first link."""
    return 3 if has_swing_angles(p.support) else 3 + hoist_coordinates(p.hoist)


@routine
def joint_count(p):
    """Return the number of joint coordinates."""
    nq, first, _ = suspended_layout(p)
    return coordinate_count(p.support) + swing_count(p) + nq - first - 3


def angles_of(n, rates):
    """Return (θ1, θ2) and their rates of a unit vector (3,) and its rates, in the turning frame."""
    c2 = sqrt(n[1] * n[1] + n[2] * n[2])
    theta1 = atan2(n[1], -n[2]) if c2 > 0.0 else 0.0
    s1, c1 = sin(theta1), cos(theta1)
    first = (c1 * rates[1] + s1 * rates[2]) / max(c2, POLE)
    return (theta1, atan2(n[0], c2)), (first, c2 * rates[0] + n[0] * (c1 * rates[2] - s1 * rates[1]))


def vector_of(angles, rates):
    """Return (unit vector, its rates), each (3,), of swing angles (θ1, θ2) and their rates."""
    s1, c1, s2, c2 = sin(angles[0]), cos(angles[0]), sin(angles[1]), cos(angles[1])
    (w1, w2) = rates
    n = (s2, c2 * s1, -c2 * c1)
    return n, (c2 * w2, c2 * c1 * w1 - s2 * s1 * w2, c2 * s1 * w1 + s2 * c1 * w2)


def in_turning_frame(p, x, v, i, nq):
    """Return (unit vector, its rates) of the first link in the support's frame; v: rates begin there, i: the vector."""
    angle = yaw(p.support, read_state(p.support, x, nq).q)
    s, c = sincos(angle)
    n = to_turned_axes((x[i], x[i + 1], x[i + 2]), s, c)
    x1, y1, z1 = to_turned_axes((x[v + i], x[v + i + 1], x[v + i + 2]), s, c)
    w = yaw_entry(p.support, x, nq)
    return n, (x1 + w * n[1], y1 - w * n[0], z1)


def yaw_entry(support, row, i):
    """Return the entry of a row of rates or accelerations, which begin at i, of the angle about the vertical."""
    return sum((row[i + k] for k in support.structure.mechanism().yaw), 0.0)


@system.joints.register(SuspendedCrane)
def _(p, x):
    return joint_arrays(p, x)


@routine
def joint_arrays(p, x):
    """Return (q, v), arrays (nj,)."""
    nq, first, _ = suspended_layout(p)
    nd = trailing_count(p.support)
    ns, count = coordinate_count(p.support) - nd, joint_count(p)
    q, v = np.empty(count), np.empty(count)
    for i in range(ns):
        q[i], v[i] = x[i], x[nq + i]
    for i in range(nd):
        q[count - nd + i], v[count - nd + i] = x[ns + i], x[nq + ns + i]
    count -= nd
    at = ns
    if has_swing_angles(p.support):
        q[at], v[at] = first_length(p.hoist, p, x, nq)
        n, rates = in_turning_frame(p, x, nq, first, nq)
        (q[at + 1], q[at + 2]), (v[at + 1], v[at + 2]) = angles_of(n, rates)
        at, first = at + 3, first + 3
    for i in range(count - at):
        q[at + i], v[at + i] = x[nq - (count - at) + i], x[2 * nq - (count - at) + i]
    return q, v


@system.state.register(SuspendedCrane)
def _(p, t, q, v):
    nq, first, end = suspended_layout(p)
    x, nd = np.zeros(end + mode_count(p)), trailing_count(p.support)
    ns, n = coordinate_count(p.support) - nd, len(q) - nd
    for i in range(ns):
        x[i], x[nq + i] = q[i], v[i]
    for i in range(nd):
        x[ns + i], x[nq + ns + i] = q[n + i], v[n + i]
    at = ns
    if has_swing_angles(p.support):
        if first > ns + nd:
            x[ns + nd], x[nq + ns + nd] = q[ns], v[ns]
        direction, rates = vector_of((q[ns + 1], q[ns + 2]), (v[ns + 1], v[ns + 2]))
        s, c = sincos(yaw(p.support, read_state(p.support, x, nq).q))
        w = yaw_entry(p.support, x, nq)
        rates = (rates[0] - w * direction[1], rates[1] + w * direction[0], rates[2])
        (x[first], x[first + 1], x[first + 2]) = to_turned_axes(direction, -s, c)
        (x[nq + first], x[nq + first + 1], x[nq + first + 2]) = to_turned_axes(rates, -s, c)
        at = ns + 3
    for i in range(n - at):
        x[nq - (n - at) + i], x[2 * nq - (n - at) + i] = q[at + i], v[at + i]
    if hoist_modes(p.hoist) > 0:
        x[end] = np.sign(x[nq + ns + nd])
    count_exchanges(p.exchange, t, x, end)
    initialize_modes(p.support, x, read_state(p.support, x, nq))
    return x


@system.acceleration.register(SuspendedCrane)
def _(p, t, x, u):
    return accelerations_of_joints(p, x, system.rhs(p, t, x, u))


@routine
def accelerations_of_joints(p, x, rates):
    """Return the second derivatives (nj,) of the joint coordinates; rates: derivative of the state x."""
    nq, first, _ = suspended_layout(p)
    nd, out = trailing_count(p.support), np.empty(joint_count(p))
    ns, count = coordinate_count(p.support) - nd, len(out) - nd
    for i in range(ns):
        out[i] = rates[nq + i]
    for i in range(nd):
        out[count + i] = rates[nq + ns + i]
    at = ns
    if has_swing_angles(p.support):
        out[at] = rates[nq + ns + nd] if first > ns + nd else 0.0
        out[at + 1], out[at + 2] = angle_accelerations(p, x, rates, first, nq)
        at += 3
    for i in range(count - at):
        out[at + i] = rates[2 * nq - (count - at) + i]
    return out


def angle_accelerations(p, x, rates, first, nq):
    """Return the second derivatives of the swing angles (θ1, θ2)."""
    n, (dx, dy, dz) = in_turning_frame(p, x, nq, first, nq)
    s, c = sincos(yaw(p.support, read_state(p.support, x, nq).q))
    i = nq + first
    ax, ay, az = to_turned_axes((rates[i], rates[i + 1], rates[i + 2]), s, c)
    w, w_dot = yaw_entry(p.support, x, nq), yaw_entry(p.support, rates, nq)
    ax, ay = ax + 2.0 * w * dy + w_dot * n[1] + w * w * n[0], ay - 2.0 * w * dx - w_dot * n[0] + w * w * n[1]
    c2 = max(sqrt(n[1] * n[1] + n[2] * n[2]), POLE)
    square, rate1 = c2 * c2, (n[1] * dz - n[2] * dy) / (c2 * c2)
    first_acc = (n[1] * az - n[2] * ay) / square - 2.0 * rate1 * (n[1] * dy + n[2] * dz) / square
    return first_acc, (ax + n[0] * (dx / c2) ** 2) / c2
