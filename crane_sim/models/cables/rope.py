"""One rigid, massless rope of varying length, in the coordinates of its payload.

The state is the payload's position and velocity (X, Y, Z, X', Y', Z') in the support's frame: no
angles, so the swing may pass any direction; the only singular point is a rope of zero length. The
drive decides the tension:

- ForceRope: the winch applies the effort u (positive pays out), so the tension is -u plus the
  spring's;
- MotionRope: the winch imposes the rope's acceleration, or, with a time constant, follows a
  commanded velocity;
- LockedRope: the rope keeps its length.

The method `tension` returns it [N], with the arguments of `imposed_tension`; `power` is what the
winch supplies [W] at efforts u of all joints.
"""

from math import sqrt
from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.models.effects import RopeSpring, add_spring, add_spring_energy
from crane_sim.models.rotating_frame import inertial_acceleration
from crane_sim.models.stops import WINCH
from crane_sim.models.supports.hoist import winch_acceleration
from crane_sim.multibody.vectors import Vector, add, dot, scale, subtract


class ForceRope(NamedTuple):
    """A winch without inertia, commanded by force."""

    spring: RopeSpring | None = None

    def tension(self, p, pose, rope_state, tau, force, reaction):
        """Return the tension; that of a rope of constant length where friction holds the winch."""
        if p.friction is None or pose.free[WINCH]:
            return winch_pull(self, tau, rope_state)
        return imposed_tension(p, pose, rope_state, tau, force, reaction, 0.0)

    def power(self, u, rope_state, tension):
        """Return the power of the effort."""
        return u[3] * rope_state.rate


class MotionRope(NamedTuple):
    """A winch that imposes the rope's acceleration [m/s²], or its velocity [m/s] with a lag."""

    time_constant: Positive | None = None  # s, of the lag; None: the input is the acceleration

    def tension(self, p, pose, rope_state, tau, force, reaction):
        """Return the tension of the imposed acceleration."""
        acceleration = winch_acceleration(self.time_constant, rope_state.rate, tau[3])
        return imposed_tension(p, pose, rope_state, tau, force, reaction, acceleration)

    def power(self, u, rope_state, tension):
        """Return the power of the motion against the tension."""
        return -tension * rope_state.rate


class LockedRope(NamedTuple):
    """A braked winch."""

    length: Positive  # m

    def tension(self, p, pose, rope_state, tau, force, reaction):
        """Return the tension of a length that stays."""
        return imposed_tension(p, pose, rope_state, tau, force, reaction, 0.0)

    def power(self, u, rope_state, tension):
        """Return that a brake supplies nothing."""
        return 0.0


class RopeKinematics(NamedTuple):
    """Direction, length and rates of the rope, from tip to payload, in the support's frame."""

    n: Vector  # unit vector
    length: float  # m
    rate: float  # m/s, of the length
    velocity: Vector  # m/s, of the payload's coordinates relative to the tip's


def rope_kinematics(pose, xc):
    """Return the RopeKinematics of payload state xc below a support in posture pose."""
    along, velocity = subtract(xc, pose.tip), subtract(xc[3:], pose.tip_velocity)
    length = sqrt(dot(along, along))
    n = scale(1.0 / length, along)
    return RopeKinematics(n, length, dot(n, velocity), velocity)


def swing_angles(rope_state):
    """Return (sin θ1, cos θ1, cos θ2, cos θ2 θ1', θ2') of a rope; θ1 = 0 where θ2 = ±90 deg."""
    nx, ny, nz = rope_state.n
    vx, vy, vz = rope_state.velocity
    c2 = sqrt(ny * ny + nz * nz)
    s1, c1 = (ny / c2, -nz / c2) if c2 > 0.0 else (0.0, 1.0)
    return (
        s1,
        c1,
        c2,
        (c1 * vy + s1 * vz) / rope_state.length,
        (c2 * vx + nx * (c1 * vz - s1 * vy)) / rope_state.length,
    )


def winch_pull(rope, tau, rope_state):
    """Return the tension [N] that balances the efforts on a winch without inertia.

    It is 0 where the winch takes no effort.
    """
    return (
        -add_spring(rope.spring, tau[3], rope_state.length) if isinstance(rope, ForceRope) else 0.0
    )


def imposed_tension(p, pose, rope_state, tau, force, reaction, length_acceleration):
    """Return the tension [N] that gives the rope this second derivative of its length.

    Args:
        p: the crane.
        pose, rope_state: posture of the support, RopeKinematics.
        tau: efforts of all joints; the winch's is the fourth.
        force: on the payload, the rope's left out (3,) [N].
        reaction: on the tip, the rope's left out (3,) [N].
        length_acceleration: m/s².
    """
    qdd = p.support.accelerations(pose, p.gravity, tau, reaction)
    relative, yaw_acceleration = p.support.tip_acceleration(pose, qdd)
    tip = inertial_acceleration(
        relative, pose.tip, pose.tip_velocity, pose.yaw_rate, yaw_acceleration
    )
    nx, ny, nz = rope_state.n
    m = p.load.mass
    pull = (
        nx * (force[0] / m - tip[0]) + ny * (force[1] / m - tip[1]) + nz * (force[2] / m - tip[2])
    )
    return (pull + centripetal(pose, rope_state) - length_acceleration) / (
        1.0 / m + p.support.tip_mobility(pose, rope_state.n)
    )


def centripetal(pose, rope_state):
    """Return length times |n'|², n' in inertial axes."""
    ex, ey = rope_state.n[0] * rope_state.length, rope_state.n[1] * rope_state.length
    vx, vy, vz = rope_state.velocity
    vx, vy = vx - pose.yaw_rate * ey, vy + pose.yaw_rate * ex
    return (vx * vx + vy * vy + vz * vz - rope_state.rate * rope_state.rate) / rope_state.length


def add_rope_energy(rope, energy, length):
    """Return energy plus what the rope stores at this length."""
    return add_spring_energy(rope.spring, energy, length) if isinstance(rope, ForceRope) else energy


def limit_winch(p, u):
    """Return the efforts u on crane p, the winch's limited to what a rope transmits: tension."""
    if not isinstance(p.cable, ForceRope) or (
        p.friction is not None and p.friction.rope is not None
    ):
        return u  # a winch with friction overcomes it to pay out, while the rope pulls
    return (u[0], u[1], u[2], min(u[3], 0.0))


def without_rate(rope_state, xc):
    """Return the payload state whose rope neither runs out nor in."""
    return (xc[0], xc[1], xc[2], *subtract(xc[3:], scale(rope_state.rate, rope_state.n)))


def project_to_rope(rope, pose, xc):
    """Return the payload state on the rope: no rounding where the drive holds exactly."""
    if not isinstance(rope, LockedRope):
        return xc
    rope_state = rope_kinematics(pose, xc)
    return without_rate(rope_state, (*add(pose.tip, scale(rope.length, rope_state.n)), *xc[3:]))
