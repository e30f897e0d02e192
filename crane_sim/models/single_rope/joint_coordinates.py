"""Joint coordinates of cranes with one rope: the support's own, then the rope's and the swing's.

Supports and cables are independent of each other, so what depends on both is here.
"""

from math import atan2, cos, sin, sqrt

from crane_sim.models.cables.rope import LockedRope, rope_kinematics, swing_angles
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.multibody.vectors import add, dot, scale, subtract

POLE = 1e-9
"""cos θ2 below which the rate of θ1, infinite at the pole, is reported as if at this distance from
it."""


def joint_coordinates(p, x):
    """Return (q, v), the joint coordinates of crane p in state x."""
    return point_coordinates(p, x) if isinstance(p.support, DrivenPoint) else boom_coordinates(p, x)


def state_from_joints(p, q, v):
    """Return (support state, payload state) of crane p at joint coordinates q, v."""
    return point_state(p, q, v) if isinstance(p.support, DrivenPoint) else boom_state(p, q, v)


def joint_accelerations(p, motion):
    """Return the joint accelerations of crane p at this CraneMotion."""
    return (
        point_accelerations(p, motion)
        if isinstance(p.support, DrivenPoint)
        else boom_accelerations(p, motion)
    )


def actuated_joints(p, x):
    """Return (q, v) of the actuated joints only."""
    if not isinstance(p.support, DrivenPoint):
        return actuated_boom_joints(p, x)
    return p.support.driven_components(x[0][:3]), p.support.driven_components(x[0][3:])


def efforts_from_row(p, row):
    """Return the efforts in the array `row` as a tuple: none on a winch that is braked."""
    if isinstance(p.support, DrivenPoint):
        return p.support.driven_components(row)
    return (
        (row[0], row[1], row[2])
        if isinstance(p.cable, LockedRope)
        else (row[0], row[1], row[2], row[3])
    )


def boom_coordinates(p, x):
    """Return the joints of a boom, of the rope and of the swing below it."""
    xs, xc = x[0], x[1]
    rope_state = rope_kinematics(p.support.forward_kinematics(xs), xc)
    _, _, c2, w1, w2 = swing_angles(rope_state)
    theta1, theta2 = atan2(rope_state.n[1], -rope_state.n[2]), atan2(rope_state.n[0], c2)
    return (*xs[:3], rope_state.length, theta1, theta2), (
        *xs[3:],
        rope_state.rate,
        w1 / max(c2, POLE),
        w2,
    )


def actuated_boom_joints(p, x):
    """Return the joints of a boom, and that of the rope unless its winch is braked."""
    if isinstance(p.cable, LockedRope):
        return x[0][:3], x[0][3:]
    rope_state = rope_kinematics(p.support.forward_kinematics(x[0]), x[1])
    return (*x[0][:3], rope_state.length), (*x[0][3:], rope_state.rate)


def boom_state(p, q, v):
    """Return the states of a boom and of the payload below it."""
    d, s1, c1, s2, c2 = q[3], sin(q[4]), cos(q[4]), sin(q[5]), cos(q[5])
    rate, w1, w2 = v[3], d * c2 * v[4], d * v[5]
    pose = p.support.forward_kinematics((q[0], q[1], q[2], v[0], v[1], v[2]))
    (x, y, z), (vx, vy, vz) = pose.tip, pose.tip_velocity
    payload = (x + d * s2, y + d * c2 * s1, z - d * c1 * c2)
    velocity = (
        vx + rate * s2 + w2 * c2,
        vy + rate * c2 * s1 + w1 * c1 - w2 * s1 * s2,
        vz - rate * c1 * c2 + w1 * s1 + w2 * c1 * s2,
    )
    return (q[0], q[1], q[2], v[0], v[1], v[2]), (*payload, *velocity)


def boom_accelerations(p, motion):
    """Return the accelerations of the joints of a boom, of the rope and of the swing."""
    rope_state = motion.rope_state
    tip, _ = p.support.tip_acceleration(motion.pose, motion.support_acceleration)
    ax, ay, az = relative = subtract(motion.payload_acceleration, tip)
    nx, length, rate = rope_state.n[0], rope_state.length, rope_state.rate
    s1, c1, c2, w1, w2 = swing_angles(rope_state)
    rope = (
        dot(rope_state.n, relative)
        + (dot(rope_state.velocity, rope_state.velocity) - rate * rate) / length
    )
    theta1 = w1 / max(c2, POLE)
    first = (c1 * ay + s1 * az - 2.0 * rate * w1) / length + 2.0 * nx * theta1 * w2
    second = (
        c2 * ax + nx * (c1 * az - s1 * ay) - 2.0 * rate * w2
    ) / length - nx * c2 * theta1 * theta1
    return (*motion.support_acceleration, rope, first / max(c2, POLE), second)


def point_coordinates(p, x):
    """Return the coordinates of a point and the rope's unit vector."""
    rope_state = rope_kinematics(p.support.forward_kinematics(x[0]), x[1])
    return (*x[0][:3], *rope_state.n), (*x[0][3:], *direction_rates(rope_state))


def direction_rates(rope_state):
    """Return the derivative (3,) [1/s] of the rope's unit vector."""
    parts = zip(rope_state.velocity, rope_state.n, strict=True)
    return tuple([(v - rope_state.rate * n) / rope_state.length for v, n in parts])


def point_accelerations(p, motion):
    """Return the accelerations of a point and of the rope's unit vector."""
    rope_state, tip = motion.rope_state, motion.support_acceleration
    n, length, rate, _ = rope_state
    rates = direction_rates(rope_state)
    relative = subtract(motion.payload_acceleration, tip)
    along = dot(n, relative) + length * dot(rates, rates)
    parts = zip(relative, n, rates, strict=True)
    return (*tip, *[(a - along * unit - 2.0 * rate * w) / length for a, unit, w in parts])


def point_state(p, q, v):
    """Return the states of a point and of the payload below it."""
    n, length = scale(1.0 / sqrt(dot(q[3:], q[3:])), q[3:]), p.cable.length
    velocity = add(v, scale(length, subtract(v[3:], scale(dot(n, v[3:]), n))))
    return (q[0], q[1], q[2], v[0], v[1], v[2]), (*add(q, scale(length, n)), *velocity)
