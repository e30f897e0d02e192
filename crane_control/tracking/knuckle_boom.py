"""A knuckle boom that carries the suspension point by its joints' efforts.

It is by Smith & Egeland, eq. 50-61.

Partial feedback linearisation. The law commands the tip's horizontal acceleration, and a servo
holds the tip's height; J q'' + J' q' = a gives the joints' accelerations, and the nominal model the
efforts. What the payload adds to the boom's mass matrix M, once the rope's constraint has been
used, is eq. 58; g = Jᵀn, n along the rope:

    tau = (M + m g gᵀ) (q'' - q0''),   q0'' the accelerations without efforts.

q0'' comes from the model itself, so gravity, turning, springs, the payload's pull and the rest of
the nominal model are in it. J is singular where boom and jib are in line, or the tip is above the
tower. Scenes that begin near such a posture, or whose trajectory leads there, are rejected
(`make_boom_servo`). While running, a setpoint outside the workspace is held at its edge. Where the
tip comes near a singular posture nevertheless, the inverse is damped (least squares): the joints'
accelerations stay bounded, the tip follows in the regular directions, and the joints brake in the
singular one.
"""

from collections.abc import Iterator
from math import cos, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_control.tracking.tip_servo import CableState, Servo, compute_tracking_acceleration
from crane_control.tracking.tracker import TipSetpoint
from crane_sim.files.errors import SceneError
from crane_sim.models.cables.rope import ForceRope, LockedRope, MotionRope, rope_kinematics
from crane_sim.models.effects import add_spring
from crane_sim.models.rotating_frame import inertial_velocity
from crane_sim.models.single_rope.crane import Crane, solve_motion
from crane_sim.models.single_rope.joint_coordinates import state_from_joints
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.supports.support import structure_of
from crane_sim.multibody.vectors import to_turned_axes
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.polynomials import evaluate
from crane_sim.trajectories.replanning import to_piecewise_polynomial
from crane_sim.trajectories.trajectory import Trajectory

SINGULAR_SINE = 0.1  # sine of the angle between boom and jib below which the inverse is damped
DAMPING_RADIUS = 0.1  # m from the tower's axis below which it is, too


class BoomServo(NamedTuple):
    """A tip servo by the joints of a nominal knuckle boom."""

    kp: float  # 1/s², gain on the tip's position
    kd: float  # 1/s, gain on the tip's velocity
    height: float  # m, setpoint of the tip's height
    radius_range: tuple[float, float]  # m, workspace: least and greatest distance from the tower's
    # axis at this height
    length: float  # m, setpoint of the rope's length
    rope: Any  # the rope of the crane
    crane: Crane  # nominal, with a rope whose acceleration is prescribed

    def cable_state(self, length, q, v):
        """Return the CableState below the boom, see `TipServo`."""
        return boom_cable_state(self.crane, q, v)

    def suspension_efforts(self, t, setpoint, cable):
        """Return the joints' efforts that move the boom's tip to a setpoint.

        The setpoint is in its workspace, see `TipServo`.
        """
        reachable = clamp_to_workspace(self.radius_range, setpoint)
        return tip_efforts(self, t, cable, compute_tracking_acceleration(self, reachable, cable))

    def acceleration_efforts(self, t, cable, a):
        """Return the efforts of the joints, see `TipServo`."""
        return tip_efforts(self, t, cable, a)


def boom_cable_state(crane, q, v):
    """Return the CableState below the tip of a nominal crane."""
    xs, xc = state_from_joints(crane, q, v)
    pose = crane.support.forward_kinematics(xs)
    rope_state, (s, c), w = rope_kinematics(pose, xc), sincos(xs[0]), pose.yaw_rate
    tip, payload = to_turned_axes(pose.tip, -s, c), to_turned_axes(xc[:3], -s, c)
    dtip = to_turned_axes(inertial_velocity(pose.tip, pose.tip_velocity, w), -s, c)
    dpayload = to_turned_axes(inertial_velocity(xc[:3], xc[3:], w), -s, c)
    nx, ny, nz = to_turned_axes(rope_state.n, -s, c)
    length, rate = rope_state.length, rope_state.rate
    x, y, z = (
        dpayload[0] - dtip[0] - rate * nx,
        dpayload[1] - dtip[1] - rate * ny,
        dpayload[2] - dtip[2] - rate * nz,
    )
    dn = (x / length, y / length, z / length)
    return CableState(tip[:2], dtip[:2], payload[:2], dpayload[:2], (nx, ny, nz), dn, (xs, xc))


def joint_accelerations(support, pose, a, damping_rate):
    """Return the accelerations (3,) of slew, boom and jib for the tip's acceleration a (3,).

    a is in m/s².

    a is relative to the base, in the axes of the slewing frame. Where the inverse is damped, as the
    module says,
    |J q'' - a|² + damping |q'' + damping_rate q'|² is least, damping_rate in 1/s.
    """
    r, w = pose.tip[0], pose.yaw_rate
    bias, _ = support.tip_acceleration(pose, (0.0, 0.0, 0.0))
    dr, dz = a[0] + w * w * r - bias[0], a[2] - bias[2]
    damping = max(0.0, DAMPING_RADIUS * DAMPING_RADIUS - r * r)
    slew = ((a[1] - 2.0 * w * pose.tip_velocity[0]) * r - damping * damping_rate * w) / (
        r * r + damping
    )
    # of boom against jib
    cosine, sine = pose.cb * pose.cg + pose.sb * pose.sg, pose.sb * pose.cg - pose.cb * pose.sg
    damping = max(0.0, SINGULAR_SINE * SINGULAR_SINE - sine * sine)
    boom_rhs = (
        pose.cb * dz - pose.sb * dr - damping * damping_rate * support.boom.length * pose.beta_rate
    )
    jib_rhs = (
        pose.cg * dz - pose.sg * dr - damping * damping_rate * support.jib.length * pose.gamma_rate
    )
    inverse = 1.0 / (sine * sine + damping * (2.0 + damping))
    boom = ((1.0 + damping) * boom_rhs - cosine * jib_rhs) * inverse / support.boom.length
    return (
        slew,
        boom,
        ((1.0 + damping) * jib_rhs - cosine * boom_rhs) * inverse / support.jib.length,
    )


def joint_efforts(crane, unforced, a):
    """Return (efforts (3,) [N m], tension [N]) that give the joints accelerations a (3,).

    The joints are slew, boom and jib.

    `unforced` is the Motion of the crane without these efforts, whose rope's length accelerates as
    commanded.
    """
    pose, (nr, nt, nz) = unforced.pose, unforced.rope_state.n
    qdd0 = unforced.support_acceleration
    slew, boom, jib = a[0] - qdd0[0], a[1] - qdd0[1], a[2] - qdd0[2]
    g0 = pose.tip[0] * nt
    g1 = crane.support.boom.length * (pose.cb * nz - pose.sb * nr)
    g2 = crane.support.jib.length * (pose.cg * nz - pose.sg * nr)
    tension_change = crane.load.mass * (g0 * slew + g1 * boom + g2 * jib)
    slew_effort = pose.slew_inertia * slew + g0 * tension_change
    boom_effort = pose.boom_inertia * boom + pose.c * jib + g1 * tension_change
    jib_effort = pose.c * boom + pose.jib_inertia * jib + g2 * tension_change
    return (slew_effort, boom_effort, jib_effort), unforced.tension - tension_change


def rope_acceleration(servo, rope_state):
    """Return the acceleration [m/s²] of the rope's length that holds the length."""
    if isinstance(servo.rope, LockedRope):
        return 0.0
    return -servo.kd * rope_state.rate - servo.kp * (rope_state.length - servo.length)


def winch_efforts(rope, rope_state, acceleration, tension):
    """Return the winch's effort as a tuple for the length's acceleration [m/s²]; () if locked."""
    if isinstance(rope, ForceRope):
        return (-tension - add_spring(rope.spring, 0.0, rope_state.length),)
    if not isinstance(rope, MotionRope):
        return ()
    lag = rope.time_constant
    return (acceleration if lag is None else rope_state.rate + lag * acceleration,)


@routine
def tip_efforts(servo, t, cable, a):
    """Return the efforts (nu,) for a tip's horizontal acceleration a (2,) [m/s²].

    They hold its height and the rope.
    """
    crane, (xs, xc) = servo.crane, cable.crane_state
    pose, (s, c) = crane.support.forward_kinematics(xs), sincos(xs[0])
    rope_state = rope_kinematics(pose, xc)
    vertical_acceleration = -servo.kd * pose.tip_velocity[2] - servo.kp * (
        pose.tip[2] - servo.height
    )
    tip_acc = to_turned_axes((a[0], a[1], vertical_acceleration), s, c)
    accelerations = joint_accelerations(crane.support, pose, tip_acc, servo.kd)
    rope_acc = rope_acceleration(servo, rope_state)
    efforts, tension = joint_efforts(
        crane, solve_motion(crane, t, cable.crane_state, (0.0, 0.0, 0.0, rope_acc)), accelerations
    )
    return *efforts, *winch_efforts(servo.rope, rope_state, rope_acc, tension)


def clamp_to_workspace(radius_range, setpoint):
    """Return the TipSetpoint if in the workspace, else rest at the nearest position in it."""
    x, y = setpoint.x
    radius = sqrt(x * x + y * y)
    if radius_range[0] <= radius <= radius_range[1]:
        return setpoint
    if radius == 0.0:  # on the axis, from which all directions are alike
        return TipSetpoint((radius_range[0], 0.0), (0.0, 0.0), (0.0, 0.0))
    scale = min(max(radius, radius_range[0]), radius_range[1]) / radius
    return TipSetpoint((scale * x, scale * y), (0.0, 0.0), (0.0, 0.0))


# of the angle between boom and jib, singular at 0: 17 degrees, 2 cm below a full reach of 2 m
MIN_ELBOW_SINE = 0.3
MIN_RADIUS = 0.2  # m, distance from the tower's axis
PATH_SAMPLES = 2001  # instants of a trajectory at which its distance is checked


def make_boom_servo(name: str, servo: Servo, nominal: Scene, base: AnyBase | None) -> BoomServo:
    """Return the tip servo by a knuckle boom for the law called `name`.

    Setpoints of the tip's height and the rope's length are those at the start of the nominal scene.
    The nominal model has neither wind nor a force on the payload, and the base's motion only if
    that is measured.

    Args:
        name, nominal: of the law, its nominal scene, with a trajectory of the payload.
        servo: gains of the tip, also used for the length of a rope that is not locked.
        base: the base's motion, if that is measured.

    Raises:
        SceneError: the start or the trajectory needs a posture in which the tip cannot be moved in
            every direction.
    """
    model, (_, beta, gamma, length) = nominal.model, nominal.initial_q[:4]
    structure = structure_of(model.support)
    boom, jib = structure.boom.length, structure.jib.length
    height = boom * sin(beta) + jib * sin(gamma)
    min_radius, max_radius = radius_range(structure, height)
    start = ("initial.q: the tip begins", boom * cos(beta) + jib * cos(gamma))
    for what, radius in (start, *trajectory_radii(nominal.trajectory)):
        if not min_radius <= radius <= max_radius:
            raise SceneError(
                f"{what} {radius:.4g} m from the tower's axis; control.law = {name!r} drives the "
                "tip "
                f"{min_radius:.4g} to {max_radius:.4g} m from it, at the height of {height:.4g} m "
                "at which it begins"
            )
    boom_model = model._replace(
        cable=MotionRope(), energy_meter=None, base=base, force=None, wind=None, friction=None
    )
    return BoomServo(
        servo.kp, servo.kd, height, (min_radius, max_radius), length, model.cable, boom_model
    )


def radius_range(support: Knuckle, height: float) -> tuple[float, float]:
    """Return the range of distances [m] of a tip from the tower's axis.

    They are the least and the greatest at which it can move in every direction.

    At this height [m], in the base frame; without any such distance the greatest is smaller than
    the least.
    """
    boom, jib = support.boom.length, support.jib.length
    # cosine of the angle between boom and jib
    max_cosine = sqrt(1.0 - MIN_ELBOW_SINE * MIN_ELBOW_SINE)
    folded, straight = (
        boom * boom + jib * jib + 2.0 * boom * jib * k - height * height
        for k in (-max_cosine, max_cosine)
    )
    return max(MIN_RADIUS, sqrt(max(folded, 0.0))), sqrt(max(straight, 0.0))


def trajectory_radii(trajectory: Trajectory) -> Iterator[tuple[str, float]]:
    """Yield (description, distance from the tower's axis [m]) of points of a trajectory."""
    t = np.linspace(trajectory.starts[0], trajectory.starts[-1], PATH_SAMPLES)
    for time, position in zip(t, evaluate(to_piecewise_polynomial(trajectory), t), strict=True):
        yield f"reference.path: is at t = {time:.4g} s", float(np.hypot(position[0], position[1]))
