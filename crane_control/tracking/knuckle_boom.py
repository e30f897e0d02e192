"""A knuckle boom that carries the suspension point, by the efforts of its joints (Smith & Egeland, eq. 50-61).

Partial feedback linearisation. The law demands the tip's horizontal acceleration, and a servo holds the tip's height;
J q'' + J' q' = a gives the joints' accelerations, and the nominal model the efforts. What the payload adds to the
boom's mass matrix M, once the rope's constraint has been used, is eq. 58; g = Jᵀn, n along the rope:

    tau = (M + m g gᵀ) (q'' - q0''),   q0'' the accelerations without efforts.

q0'' comes from the model itself, so gravity, turning, springs, the payload's pull and the rest of the nominal model are
in it. J cannot be inverted where boom and jib are in line, or the tip is above the tower. Scenes that begin near such
a posture, or whose path leads there, are refused (`crane_control.tracking.reach`). While running, a demanded position
beyond reach is held at its edge. Where the tip comes near such a posture nevertheless the inverse is damped (least
squares): the joints' accelerations stay bounded, the tip follows in the directions that are left, the joints brake in
the other.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_control.tracking.drives import (
    CableState,
    compute_drive_efforts,
    compute_tracking_acceleration,
    estimate_cable,
    suspension_effort,
)
from crane_control.tracking.tracker import Demand
from crane_sim.models.cables.rope import ForceRope, LockedRope, RateRope, span
from crane_sim.models.effects import add_spring
from crane_sim.models.moving_base import rotate_back
from crane_sim.models.rotating_frame import inertial_velocity
from crane_sim.models.single_rope.crane import Crane, solve_motion
from crane_sim.models.supports import forward_kinematics, state_from_joints, tip_acceleration
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic, kernel, routine

BENT = 0.1  # sine of the angle between boom and jib below which the inverse is damped
DAMPING_RADIUS = 0.1  # m from the tower's axis below which it is, too


class Boom(NamedTuple):
    """The nominal boom of the law."""

    kp: float  # 1/s², of the tip
    kd: float  # 1/s, of the tip
    height: float  # m, at which the tip is held
    reach: tuple[float, float]  # m, least and greatest distance from the tower's axis, at this height
    length: float  # m, at which the rope is held
    rope: Any  # the crane's
    crane: Crane  # with a rope whose acceleration is prescribed


@estimate_cable.register(Boom)
def _(drive, length, q, v):
    xs, xc = state_from_joints(drive.crane.support, drive.crane, q, v)
    pose = forward_kinematics(drive.crane.support, xs)
    line, (s, c), w = span(pose, xc), sincos(xs[0]), pose.yaw_rate
    tip, payload = rotate_back(pose.tip, -s, c), rotate_back(xc[:3], -s, c)
    dtip = rotate_back(inertial_velocity(pose.tip, pose.tip_velocity, w), -s, c)
    dy = rotate_back(inertial_velocity(xc[:3], xc[3:], w), -s, c)
    nx, ny, nz = rotate_back(line.n, -s, c)
    x, y, z = dy[0] - dtip[0] - line.rate * nx, dy[1] - dtip[1] - line.rate * ny, dy[2] - dtip[2] - line.rate * nz
    dn = (x / line.length, y / line.length, z / line.length)
    return CableState(tip[:2], dtip[:2], payload[:2], dy[:2], (nx, ny, nz), dn, (xs, xc))


@kernel
def joint_accelerations(support, pose, a, brake):
    """Return the accelerations (3,) of slew, boom and jib that give the tip the acceleration a (3,) [m/s²].

    a is relative to the base, in the axes of the slewing frame. Where the inverse is damped, as the module says,
    |J q'' - a|² + damping |q'' + brake q'|² is least.
    """
    r, w = pose.tip[0], pose.yaw_rate
    bias, _ = tip_acceleration(support, pose, (0.0, 0.0, 0.0))
    dr, dz = a[0] + w * w * r - bias[0], a[2] - bias[2]
    damping = max(0.0, DAMPING_RADIUS * DAMPING_RADIUS - r * r)
    slew = ((a[1] - 2.0 * w * pose.tip_velocity[0]) * r - damping * brake * w) / (r * r + damping)
    along, sine = pose.cb * pose.cg + pose.sb * pose.sg, pose.sb * pose.cg - pose.cb * pose.sg
    damping = max(0.0, BENT * BENT - sine * sine)
    first = pose.cb * dz - pose.sb * dr - damping * brake * support.boom.length * pose.beta_rate
    second = pose.cg * dz - pose.sg * dr - damping * brake * support.jib.length * pose.gamma_rate
    inverse = 1.0 / (sine * sine + damping * (2.0 + damping))
    luff = ((1.0 + damping) * first - along * second) * inverse / support.boom.length
    return slew, luff, ((1.0 + damping) * second - along * first) * inverse / support.jib.length


@kernel
def joint_efforts(crane, free, a):
    """Return (efforts (3,) [N m] of slew, boom and jib, tension [N]) that give the joints accelerations a (3,).

    `free` is the Motion of the crane without these efforts, whose rope's length accelerates as demanded.
    """
    pose, (nr, nt, nz) = free.pose, free.line.n
    slew, luff, fold = a[0] - free.support[0], a[1] - free.support[1], a[2] - free.support[2]
    g0 = pose.tip[0] * nt
    g1 = crane.support.boom.length * (pose.cb * nz - pose.sb * nr)
    g2 = crane.support.jib.length * (pose.cg * nz - pose.sg * nr)
    pull = crane.load.mass * (g0 * slew + g1 * luff + g2 * fold)
    first = pose.slew_inertia * slew + g0 * pull
    second = pose.boom_inertia * luff + pose.c * fold + g1 * pull
    return (first, second, pose.c * luff + pose.jib_inertia * fold + g2 * pull), free.tension - pull


@generic
def rope_acceleration(rope, drive, line):
    """Return the acceleration [m/s²] of the rope's length that holds the length."""
    return -drive.kd * line.rate - drive.kp * (line.length - drive.length)


@rope_acceleration.register(LockedRope)
def _(rope, drive, line):
    return 0.0


@generic
def with_winch(rope, efforts, line, acceleration, tension):
    """Return the joint efforts (3,) plus the winch's, for this acceleration [m/s²] of the rope's length."""
    return efforts


@with_winch.register(ForceRope)
def _(rope, efforts, line, acceleration, tension):
    return (*efforts, -tension - add_spring(rope.spring, 0.0, line.length))


@with_winch.register(RateRope)
def _(rope, efforts, line, acceleration, tension):
    return (*efforts, compute_winch_input(rope.time_constant, line, acceleration))


@generic
def compute_winch_input(time_constant, line, acceleration):
    """Return the input of a rate-driven winch that gives its rope's length this acceleration."""
    return acceleration


@compute_winch_input.register(float)
def _(time_constant, line, acceleration):
    return line.rate + time_constant * acceleration


@routine
def tip_efforts(drive, t, cable, a):
    """Return the efforts (nu,) that give the tip the horizontal acceleration a (2,) [m/s²] and hold height and rope."""
    crane, (xs, xc) = drive.crane, cable.state
    pose, (s, c) = forward_kinematics(crane.support, xs), sincos(xs[0])
    line = span(pose, xc)
    rise = -drive.kd * pose.tip_velocity[2] - drive.kp * (pose.tip[2] - drive.height)
    accelerations = joint_accelerations(crane.support, pose, rotate_back((a[0], a[1], rise), s, c), drive.kd)
    rope_acc = rope_acceleration(drive.rope, drive, line)
    efforts, tension = joint_efforts(crane, solve_motion(crane, t, xs, xc, (0.0, 0.0, 0.0, rope_acc)), accelerations)
    return with_winch(drive.rope, efforts, line, rope_acc, tension)


@compute_drive_efforts.register(Boom)
def _(drive, t, cable, a):
    return tip_efforts(drive, t, cable, a)


@kernel
def within(reach, demand):
    """Return the Demand where its position is within reach, else rest at the nearest place that is."""
    x, y = demand.x
    radius = sqrt(x * x + y * y)
    share = min(max(radius, reach[0]), reach[1]) / max(radius, 1e-9 * reach[1])
    if reach[0] <= radius <= reach[1]:
        return demand
    return Demand((share * x, share * y), (0.0, 0.0), (0.0, 0.0))


@suspension_effort.register(Boom)
def _(drive, t, demand, cable):
    return tip_efforts(drive, t, cable, compute_tracking_acceleration(drive, within(drive.reach, demand), cable))
