"""Joint coordinates of cranes with one rope: the support's own, then the rope's and the swing's.

What a support registers here depends on the rope below it, so supports and cables are independent of each other.
"""

from math import atan2, cos, sin, sqrt

from crane_sim.models.cables.rope import LockedRope, rope_kinematics, swing_angles
from crane_sim.models.supports import (
    actuated_joints,
    efforts_from_row,
    forward_kinematics,
    joint_accelerations,
    joint_coordinates,
    state_from_joints,
    tip_acceleration,
)
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.numerics.jit import generic

POLE = 1e-9
"""cos θ2 below which the rate of θ1, infinite at the pole, is reported as if at this distance from it."""


@joint_coordinates.register(Knuckle)
def _(support, p, x):
    xs, xc = x[0], x[1]
    rope_state = rope_kinematics(forward_kinematics(p.support, xs), xc)
    _, _, c2, w1, w2 = swing_angles(rope_state)
    theta1, theta2 = atan2(rope_state.n[1], -rope_state.n[2]), atan2(rope_state.n[0], c2)
    return (*xs[:3], rope_state.length, theta1, theta2), (*xs[3:], rope_state.rate, w1 / max(c2, POLE), w2)


@generic
def winch_joint(rope, rope_state):
    """Return the actuated rope coordinate and its rate, each a tuple, empty for a braked winch."""
    return (rope_state.length,), (rope_state.rate,)


@winch_joint.register(LockedRope)
def _(rope, rope_state):
    return (), ()


@actuated_joints.register(Knuckle)
def _(support, p, x):
    q, v = winch_joint(p.cable, rope_kinematics(forward_kinematics(p.support, x[0]), x[1]))
    return (*x[0][:3], *q), (*x[0][3:], *v)


@generic
def winch_effort(rope, row):
    """Return the winch's effort in the array `row` as a tuple, empty for a braked winch."""
    return (row[3],)


@winch_effort.register(LockedRope)
def _(rope, row):
    return ()


@efforts_from_row.register(Knuckle)
def _(support, p, row):
    return (row[0], row[1], row[2], *winch_effort(p.cable, row))


@state_from_joints.register(Knuckle)
def _(support, p, q, v):
    d, s1, c1, s2, c2 = q[3], sin(q[4]), cos(q[4]), sin(q[5]), cos(q[5])
    rate, w1, w2 = v[3], d * c2 * v[4], d * v[5]
    pose = forward_kinematics(p.support, (q[0], q[1], q[2], v[0], v[1], v[2]))
    (x, y, z), (vx, vy, vz) = pose.tip, pose.tip_velocity
    payload = (x + d * s2, y + d * c2 * s1, z - d * c1 * c2)
    velocity = (
        vx + rate * s2 + w2 * c2,
        vy + rate * c2 * s1 + w1 * c1 - w2 * s1 * s2,
        vz - rate * c1 * c2 + w1 * s1 + w2 * c1 * s2,
    )
    return (q[0], q[1], q[2], v[0], v[1], v[2]), (*payload, *velocity)


@joint_accelerations.register(Knuckle)
def _(support, p, motion):
    rope_state = motion.rope_state
    tip, _ = tip_acceleration(p.support, motion.pose, motion.support_acceleration)
    ax, ay, az = (
        motion.payload_acceleration[0] - tip[0],
        motion.payload_acceleration[1] - tip[1],
        motion.payload_acceleration[2] - tip[2],
    )
    nx, ny, nz = rope_state.n
    s1, c1, c2, w1, w2 = swing_angles(rope_state)
    vx, vy, vz = rope_state.velocity
    turning = (vx * vx + vy * vy + vz * vz - rope_state.rate * rope_state.rate) / rope_state.length
    rope = nx * ax + ny * ay + nz * az + turning
    theta1 = w1 / max(c2, POLE)
    first = (c1 * ay + s1 * az - 2.0 * rope_state.rate * w1) / rope_state.length + 2.0 * nx * theta1 * w2
    second = (
        c2 * ax + nx * (c1 * az - s1 * ay) - 2.0 * rope_state.rate * w2
    ) / rope_state.length - nx * c2 * theta1 * theta1
    return (*motion.support_acceleration, rope, first / max(c2, POLE), second)


@joint_coordinates.register(DrivenPoint)
def _(support, p, x):
    rope_state = rope_kinematics(forward_kinematics(support, x[0]), x[1])
    return (*x[0][:3], *rope_state.n), (*x[0][3:], *_direction_rates(rope_state))


def _direction_rates(rope_state):
    """Return the derivative (3,) [1/s] of the rope's unit vector."""
    (nx, ny, nz), (vx, vy, vz), rate = rope_state.n, rope_state.velocity, rope_state.rate
    return (
        (vx - rate * nx) / rope_state.length,
        (vy - rate * ny) / rope_state.length,
        (vz - rate * nz) / rope_state.length,
    )


@joint_accelerations.register(DrivenPoint)
def _(support, p, motion):
    rope_state, tip = motion.rope_state, motion.support_acceleration
    (nx, ny, nz), (wx, wy, wz) = rope_state.n, _direction_rates(rope_state)
    ax, ay, az = (
        motion.payload_acceleration[0] - tip[0],
        motion.payload_acceleration[1] - tip[1],
        motion.payload_acceleration[2] - tip[2],
    )
    along = nx * ax + ny * ay + nz * az + rope_state.length * (wx * wx + wy * wy + wz * wz)
    x = (ax - along * nx - 2.0 * rope_state.rate * wx) / rope_state.length
    y = (ay - along * ny - 2.0 * rope_state.rate * wy) / rope_state.length
    return (*tip, x, y, (az - along * nz - 2.0 * rope_state.rate * wz) / rope_state.length)


@state_from_joints.register(DrivenPoint)
def _(support, p, q, v):
    inverse, length = 1.0 / sqrt(q[3] * q[3] + q[4] * q[4] + q[5] * q[5]), p.cable.length
    nx, ny, nz = q[3] * inverse, q[4] * inverse, q[5] * inverse
    along = nx * v[3] + ny * v[4] + nz * v[5]
    payload = (q[0] + length * nx, q[1] + length * ny, q[2] + length * nz)
    x, y = v[0] + length * (v[3] - along * nx), v[1] + length * (v[4] - along * ny)
    z = v[2] + length * (v[5] - along * nz)
    return (q[0], q[1], q[2], v[0], v[1], v[2]), (*payload, x, y, z)
