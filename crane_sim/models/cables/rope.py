"""One rigid, massless rope of varying length, in the coordinates of its payload.

The state is the payload's position and velocity (X, Y, Z, X', Y', Z') in the support's frame: no angles, so the swing
may pass any direction; the only singular point is a rope of zero length. The drive decides the tension:

- ForceRope: the winch applies the effort u (positive pays out), so the tension is -u plus the spring's;
- MotionRope: the winch imposes the rope's acceleration, or, with a time constant, follows a commanded velocity;
- LockedRope: the rope keeps its length.
"""

from math import sqrt
from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.models.effects import RopeSpring, add_spring, add_spring_energy
from crane_sim.models.rotating_frame import inertial_acceleration
from crane_sim.models.supports import support_acceleration, tip_acceleration, tip_mobility
from crane_sim.models.supports.hoist import winch_acceleration
from crane_sim.numerics.jit import generic

Vector = tuple[float, float, float]


class ForceRope(NamedTuple):
    """A winch without inertia, commanded by force."""

    spring: RopeSpring | None = None


class MotionRope(NamedTuple):
    """A winch that imposes the rope's motion: its input is an acceleration [m/s²], or a velocity [m/s] with a lag."""

    time_constant: Positive | None = None  # s, of the lag; None: the input is the acceleration


class LockedRope(NamedTuple):
    """A braked winch."""

    length: Positive  # m


class RopeKinematics(NamedTuple):
    """Direction, length and rates of the rope, from tip to payload, in the support's frame."""

    n: Vector  # unit vector
    length: float  # m
    rate: float  # m/s, of the length
    velocity: Vector  # m/s, of the payload's coordinates relative to the tip's


def rope_kinematics(pose, xc):
    """Return the RopeKinematics of payload state xc below a support in posture pose."""
    ex, ey, ez = xc[0] - pose.tip[0], xc[1] - pose.tip[1], xc[2] - pose.tip[2]
    vx, vy, vz = xc[3] - pose.tip_velocity[0], xc[4] - pose.tip_velocity[1], xc[5] - pose.tip_velocity[2]
    length = sqrt(ex * ex + ey * ey + ez * ez)
    inverse = 1.0 / length
    n = (ex * inverse, ey * inverse, ez * inverse)
    return RopeKinematics(n, length, n[0] * vx + n[1] * vy + n[2] * vz, (vx, vy, vz))


def swing_angles(rope_state):
    """Return (sin θ1, cos θ1, cos θ2, cos θ2 θ1', θ2') of RopeKinematics; θ1 = 0 where θ2 = ±90 deg."""
    nx, ny, nz = rope_state.n
    vx, vy, vz = rope_state.velocity
    c2 = sqrt(ny * ny + nz * nz)
    s1, c1 = (ny / c2, -nz / c2) if c2 > 0.0 else (0.0, 1.0)
    return s1, c1, c2, (c1 * vy + s1 * vz) / rope_state.length, (c2 * vx + nx * (c1 * vz - s1 * vy)) / rope_state.length


@generic
def rope_tension(rope, p, pose, rope_state, tau, force, reaction):
    """Return the tension [N].

    Args:
        rope: the rope's parameters; their type chooses the drive.
        p: the crane.
        pose, rope_state: posture of the support, RopeKinematics.
        tau: efforts of all joints; the winch's is the fourth.
        force: on the payload, the rope's left out (3,) [N].
        reaction: on the tip, the rope's left out (3,) [N].
    """
    raise NotImplementedError


@rope_tension.register(ForceRope)
def _(rope, p, pose, rope_state, tau, force, reaction):
    return winch_tension(p.friction, p, pose, rope_state, tau, force, reaction)


@generic
def winch_tension(friction, p, pose, rope_state, tau, force, reaction):
    """Return the tension [N] of a force-driven winch with the joints' friction; other arguments of `rope_tension`."""
    return winch_pull(p.cable, tau, rope_state)


@generic
def winch_pull(rope, tau, rope_state):
    """Return the tension [N] at which the efforts on a winch without inertia balance; 0 of one without an effort."""
    return 0.0


@winch_pull.register(ForceRope)
def _(rope, tau, rope_state):
    return -add_spring(rope.spring, tau[3], rope_state.length)


@rope_tension.register(MotionRope)
def _(rope, p, pose, rope_state, tau, force, reaction):
    return imposed_tension(
        p, pose, rope_state, tau, force, reaction, winch_acceleration(rope.time_constant, rope_state.rate, tau[3])
    )


@rope_tension.register(LockedRope)
def _(rope, p, pose, rope_state, tau, force, reaction):
    return imposed_tension(p, pose, rope_state, tau, force, reaction, 0.0)


def imposed_tension(p, pose, rope_state, tau, force, reaction, length_acceleration):
    """Return the tension that gives the rope this second derivative of its length."""
    qdd = support_acceleration(p.support, pose, p.gravity, tau, reaction)
    relative, yaw_acceleration = tip_acceleration(p.support, pose, qdd)
    tip = inertial_acceleration(relative, pose.tip, pose.tip_velocity, pose.yaw_rate, yaw_acceleration)
    nx, ny, nz = rope_state.n
    m = p.load.mass
    pull = nx * (force[0] / m - tip[0]) + ny * (force[1] / m - tip[1]) + nz * (force[2] / m - tip[2])
    return (pull + centripetal(pose, rope_state) - length_acceleration) / (
        1.0 / m + tip_mobility(p.support, pose, rope_state.n)
    )


def centripetal(pose, rope_state):
    """Return length times |n'|², n' in inertial axes."""
    ex, ey = rope_state.n[0] * rope_state.length, rope_state.n[1] * rope_state.length
    vx, vy, vz = rope_state.velocity
    vx, vy = vx - pose.yaw_rate * ey, vy + pose.yaw_rate * ex
    return (vx * vx + vy * vy + vz * vz - rope_state.rate * rope_state.rate) / rope_state.length


@generic
def winch_power(rope, u, rope_state, tension):
    """Return the power [W] that the winch supplies."""
    return -tension * rope_state.rate


@winch_power.register(ForceRope)
def _(rope, u, rope_state, tension):
    return u[3] * rope_state.rate


@winch_power.register(LockedRope)
def _(rope, u, rope_state, tension):
    return 0.0


@generic
def add_rope_energy(rope, energy, length):
    """Return energy plus what the rope stores at this length."""
    return energy


@add_rope_energy.register(ForceRope)
def _(rope, energy, length):
    return add_spring_energy(rope.spring, energy, length)


@generic
def limit_winch(rope, friction, u):
    """Return u with the winch's command replaced by what a rope can transmit: tension."""
    return u


@limit_winch.register(ForceRope)
def _(rope, friction, u):
    return limit_to_pull(friction, u)


@generic
def limit_to_pull(friction, u):
    """Return the result of `limit_winch` for a winch without inertia and with the joints' friction."""
    return (u[0], u[1], u[2], min(u[3], 0.0))


def without_rate(rope_state, xc):
    """Return the payload state whose rope neither runs out nor in."""
    nx, ny, nz = rope_state.n
    rate = rope_state.rate
    return (xc[0], xc[1], xc[2], xc[3] - rate * nx, xc[4] - rate * ny, xc[5] - rate * nz)


@generic
def project_to_rope(rope, pose, xc):
    """Return the payload state put back on the rope: what the drive holds exactly, rounding must not undo."""
    return xc


@project_to_rope.register(LockedRope)
def _(rope, pose, xc):
    rope_state = rope_kinematics(pose, xc)
    nx, ny, nz = rope_state.n
    x, y, z = pose.tip
    return (
        x + rope.length * nx,
        y + rope.length * ny,
        z + rope.length * nz,
        xc[3] - rope_state.rate * nx,
        xc[4] - rope_state.rate * ny,
        xc[5] - rope_state.rate * nz,
    )
