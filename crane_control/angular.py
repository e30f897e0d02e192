"""The law `angular`: swing damping and tip tracking (Smith & Egeland, section 5).

It damps the swing angles and tracks by the suspension point.

The paper does not print the damping law; this one was inferred from the gains that it prints. φx,
φy are the swing angles about the base's x and y, L the cable's length, yd the reference of the
payload:

    x0'' = (-L kd φy' - a sin φx sin φy) / cos φy + kpt (xd - x0) + kdt (xd' - x0')
    y0'' = a + kpt (yd - y0) + kdt (yd' - y0'),    a = L kd φx' cos φy / cos φx
"""

from collections.abc import Mapping
from math import cos, sqrt
from typing import Any, NamedTuple

from crane_control.tracking.suspension import make_tip_servo, nominal_pendulum
from crane_control.tracking.tip_servo import PositionServo
from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative
from crane_sim.laws import read_settings
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.trajectory import Trajectory, reference_at

MIN_HEIGHT_RATIO = 1e-6  # of the rope's length: least height difference of its ends at the start


class Settings(NamedTuple):
    """Gains, by default of the paper's tables 3 and 4; for the pendulum and the knuckle boom."""

    damping: NonNegative = 1.118  # 1/s, of the swing angles
    kp: NonNegative = 0.313  # 1/s², of the suspension point
    kd: NonNegative = 1.118  # 1/s, of the suspension point
    velocity: bool = True  # the reference's velocity is fed forward
    acceleration: bool = False  # the reference's acceleration is fed forward


SETTINGS = {"control": Settings}


class AngularLaw(NamedTuple):
    """The law and its nominal cable."""

    length: float  # m
    trajectory: Trajectory
    damping: float
    kp: float
    kd: float
    velocity: float  # 1: fed forward, 0: not
    acceleration: float
    servo: Any  # of the suspension point, a `tracking.tip_servo.TipServo`

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return effort commands (nu,) at t [s], joint positions q and velocities v (nq,)."""
        return system.compute_command(self, t, q, v)


def compute_damping(length, damping, n, dn):
    """Return the damping accelerations (2,) of the tip.

    n (3,) is the unit vector to the payload and dn (3,) its rate.

    Not finite where the cable lies along the base's x, or is horizontal: the angles are not defined
    there.
    """
    sy, cy = -n[0], sqrt(1.0 - n[0] * n[0])
    sx, cx = n[1] / cy, -n[2] / cy
    wy = -dn[0] / cy
    wx = (dn[1] + sx * sy * wy) / (cx * cy)
    ay = length * damping * wx * cy / cx
    return (-length * damping * wy - ay * sx * sy) / cy, ay


def compute_tracking(law, goal, tip, dtip, i):
    """Return the tracking acceleration of the tip along axis i."""
    x, v, a = goal
    return (
        law.kp * (x[i] - tip[i])
        + law.kd * (law.velocity * v[i] - dtip[i])
        + law.acceleration * a[i]
    )


@system.command.register(AngularLaw)
def angular_command(law, t, q, v):
    """Return the efforts (nu,) that damp the swing and move the tip along the reference.

    The tip is the suspension point.
    """
    goal, cable = reference_at(law.trajectory, t), law.servo.cable_state(law.length, q, v)
    ax, ay = compute_damping(law.length, law.damping, cable.n, cable.dn)
    a = (
        ax + compute_tracking(law, goal, cable.tip, cable.dtip, 0),
        ay + compute_tracking(law, goal, cable.tip, cable.dtip, 1),
    )
    return law.servo.acceleration_efforts(t, cable, a)


def _check_start(nominal: Scene) -> None:
    """Raise SceneError when the rope lies horizontally at the start, along the base's x for one."""
    boom, rope = nominal.crane == "knuckle", nominal.initial_q[3:6]
    down = cos(rope[1]) * cos(rope[2]) if boom else -rope[2]
    if abs(down) < MIN_HEIGHT_RATIO:
        where = f"initial.q[4:] = {list(rope[1:])}" if boom else f"initial.direction = {list(rope)}"
        raise SceneError(
            f"{where}: the rope is horizontal, where the angular law's swing angles are not defined"
        )


def build(settings: Mapping[str, Any], nominal: Scene) -> AngularLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    options = read_settings(Settings, settings)
    pendulum, trajectory = nominal_pendulum("angular", nominal)
    servo = make_tip_servo("angular", None, nominal, None)
    if isinstance(servo, PositionServo):
        raise SceneError(
            "suspension.drive = 'servo': the angular law commands accelerations; take drive: "
            "acceleration"
        )
    _check_start(nominal)
    forward = float(options.velocity), float(options.acceleration)
    return AngularLaw(
        pendulum.length, trajectory, options.damping, options.kp, options.kd, *forward, servo
    )
