"""What a crane shows to the outside: joint coordinates, energies, accelerations, points in the world."""

from math import atan2, cos, sin

from crane_sim import crane_modes as _modes  # noqa: F401  registers what ends a run
from crane_sim import system
from crane_sim.base import BaseState, added_energy, base_state, pose_at, to_world
from crane_sim.cables.rope import LockedRope, add_rope_energy, span, swing
from crane_sim.frames import inertial_velocity
from crane_sim.jit import generic
from crane_sim.meter import metered_state, reading
from crane_sim.model import Crane, motion
from crane_sim.supports import (
    corners,
    demanded,
    driven,
    entered,
    posture,
    shown,
    shown_acceleration,
    skeleton,
    support_base_energy,
    support_kinetic,
    support_potential,
    tip_acceleration,
    yaw,
)
from crane_sim.supports.knuckle import Knuckle

POLE = 1e-9
"""cos θ2 below which the rate of θ1, infinite at the pole, is reported as if at this distance from it."""


@system.joints.register(Crane)
def _(p, x):
    return shown(p.support, p, x)


@system.actuated.register(Crane)
def _(p, x):
    return driven(p.support, p, x)


@system.held.register(Crane)
def _(p, row):
    return demanded(p.support, p, row)


@system.state.register(Crane)
def _(p, t, q, v):
    return metered_state(p.meter, entered(p.support, p, q, v))


@system.acceleration.register(Crane)
def _(p, t, x, u):
    return shown_acceleration(p.support, p, motion(p, t, x[0], x[1], system.effort(u, p, t, x)))


@shown.register(Knuckle)
def _(support, p, x):
    xs, xc = x[0], x[1]
    line = span(posture(p.support, xs), xc)
    _, _, c2, w1, w2 = swing(line)
    theta1, theta2 = atan2(line.n[1], -line.n[2]), atan2(line.n[0], c2)
    return (*xs[:3], line.length, theta1, theta2), (*xs[3:], line.rate, w1 / max(c2, POLE), w2)


@generic
def winch_joint(rope, line):
    """Return the actuated rope coordinate and its rate, each a tuple, empty for a braked winch."""
    return (line.length,), (line.rate,)


@winch_joint.register(LockedRope)
def _(rope, line):
    return (), ()


@driven.register(Knuckle)
def _(support, p, x):
    q, v = winch_joint(p.cable, span(posture(p.support, x[0]), x[1]))
    return (*x[0][:3], *q), (*x[0][3:], *v)


@generic
def winch_effort(rope, row):
    """Return the winch's effort in the array `row` as a tuple, empty for a braked winch."""
    return (row[3],)


@winch_effort.register(LockedRope)
def _(rope, row):
    return ()


@demanded.register(Knuckle)
def _(support, p, row):
    return (row[0], row[1], row[2], *winch_effort(p.cable, row))


@entered.register(Knuckle)
def _(support, p, q, v):
    d, s1, c1, s2, c2 = q[3], sin(q[4]), cos(q[4]), sin(q[5]), cos(q[5])
    rate, w1, w2 = v[3], d * c2 * v[4], d * v[5]
    pose = posture(p.support, (q[0], q[1], q[2], v[0], v[1], v[2]))
    (x, y, z), (vx, vy, vz) = pose.tip, pose.tip_velocity
    payload = (x + d * s2, y + d * c2 * s1, z - d * c1 * c2)
    velocity = (
        vx + rate * s2 + w2 * c2,
        vy + rate * c2 * s1 + w1 * c1 - w2 * s1 * s2,
        vz - rate * c1 * c2 + w1 * s1 + w2 * c1 * s2,
    )
    return (q[0], q[1], q[2], v[0], v[1], v[2]), (*payload, *velocity)


@shown_acceleration.register(Knuckle)
def _(support, p, now):
    line = now.line
    tip, _ = tip_acceleration(p.support, now.pose, now.support)
    ax, ay, az = now.payload[0] - tip[0], now.payload[1] - tip[1], now.payload[2] - tip[2]
    nx, ny, nz = line.n
    s1, c1, c2, w1, w2 = swing(line)
    vx, vy, vz = line.velocity
    turning = (vx * vx + vy * vy + vz * vz - line.rate * line.rate) / line.length
    rope = nx * ax + ny * ay + nz * az + turning
    theta1 = w1 / max(c2, POLE)
    first = (c1 * ay + s1 * az - 2.0 * line.rate * w1) / line.length + 2.0 * nx * theta1 * w2
    second = (c2 * ax + nx * (c1 * az - s1 * ay) - 2.0 * line.rate * w2) / line.length - nx * c2 * theta1 * theta1
    return (*now.support, rope, first / max(c2, POLE), second)


@system.kinetic.register(Crane)
def _(p, x):
    pose = posture(p.support, x[0])
    vx, vy, vz = inertial_velocity(x[1][:3], x[1][3:], pose.yaw_rate)
    return support_kinetic(p.support, pose) + 0.5 * p.load.mass * (vx * vx + vy * vy + vz * vz)


@system.potential.register(Crane)
def _(p, x):
    pose = posture(p.support, x[0])
    energy = support_potential(p.support, pose, p.gravity) + p.gravity * p.load.mass * x[1][2]
    return add_rope_energy(p.cable, energy, span(pose, x[1]).length)


@system.base_energy.register(Crane)
def _(p, t, x):
    return added_to(base_state(p.base, t, yaw(p.support, x[0])), p, x)


@generic
def added_to(now, p, x):
    """Return (kinetic, potential) energy [J] in the world less those relative to the base; `now`: `base_state`."""
    return 0.0, 0.0


@added_to.register(BaseState)
def _(now, p, x):
    pose = posture(p.support, x[0])
    moving = inertial_velocity(x[1][:3], x[1][3:], pose.yaw_rate)
    kinetic, potential = added_energy(now, p.gravity, p.load.mass, x[1][:3], moving)
    others = support_base_energy(p.support, now, pose, p.gravity)
    return kinetic + others[0], potential + others[1]


@system.point_count.register(Crane)
def _(p):
    return 1 + corners(p.support)


@system.tip_index.register(Crane)
def _(p):
    return corners(p.support) - 1


@system.points.register(Crane)
def _(p, t, x, out):
    angle, pose = yaw(p.support, x[0]), pose_at(p.base, t)
    c, s = cos(angle), sin(angle)
    for i, (a, b, z) in enumerate((*skeleton(p.support, x[0]), x[1][:3])):
        out[i, 0], out[i, 1], out[i, 2] = to_world(pose, (c * a - s * b, s * a + c * b, z))


@corners.register(Knuckle)
def _(support):
    return 3


@system.supplied.register(Crane)
def _(p, x):
    return reading(p.meter, x)
