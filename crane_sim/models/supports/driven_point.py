"""A suspension point that is driven, as a boom's tip or a laboratory's gantry would be, without a mass of its own.

The drive is ideal, its inputs u (in `tau`'s place) are the point's accelerations; or it is a servo whose inputs are
positions: y₀'' = -kd y₀' - kp (y₀ - u), axis by axis. Both are relative to the base, and what the cable pulls does not
move the point. Joint coordinates are the point's position and the unit vector from it to the payload: no angles, so no
direction is singular.
"""

from typing import Any, NamedTuple

from crane_sim.files.types import NonNegative, Positive, Range
from crane_sim.models.guards import Guard, encode, travel_guard
from crane_sim.models.supports import (
    actuated_joints,
    drive_power,
    efforts_from_row,
    forward_kinematics,
    support_acceleration,
    support_guard,
    support_kinetic,
    support_polyline,
    support_polyline_size,
    support_potential,
    tip_acceleration,
    tip_mobility,
    yaw,
)
from crane_sim.models.supports.support import Mechanism
from crane_sim.multibody.tree import Joint, Point, Tree, X, Y, Z
from crane_sim.numerics.jit import generic

Vector = tuple[float, float, float]


class Servo(NamedTuple):
    """A servo that follows positions."""

    kp: Positive  # 1/s²
    kd: NonNegative  # 1/s


class Lift(NamedTuple):
    """The presence of a vertical drive."""


class Box(NamedTuple):
    """Travel limits of the point relative to the base; a run ends where one is reached."""

    x: Range | None = None  # m, of `tip_x`
    y: Range | None = None  # m, of `tip_y`
    z: Range | None = None  # m, of `tip_z`, of a point with a vertical drive


class DrivenPoint(NamedTuple):
    """Parameters of the support."""

    servo: Servo | None = None  # None: inputs are accelerations
    lift: Lift | None = None  # None: the point keeps its height
    limits: Box | None = None

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return f"suspension point along {'xyz'[i]}", f"suspension.limits.{'xyz'[i]}"

    def mechanism(self) -> Mechanism:
        """Return the joints: slides along x, y and z without a mass, whose accelerations are prescribed."""
        joints = (Joint(X, ((0, 1),), slides=True), Joint(Y, ((1, 1),), slides=True, parent=0))
        box = self.limits or Box()
        return Mechanism(
            Tree((*joints, Joint(Z, ((2, 1),), slides=True, parent=1)), Point(2)),
            limits=(box.x, box.y, box.z),
            actuated=(0, 1) if self.lift is None else (0, 1, 2),
            yaw=(),
            prescribed=(True, True, True),
        )

    def prescribe(self, efforts: tuple[Any, ...], q: tuple[Any, ...], v: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return the accelerations (3,) [m/s²] at inputs (3,): none along z without a lift."""
        x, y, z = (servo_acceleration(self.servo, u, place, rate) for u, place, rate in zip(efforts, q, v, strict=True))
        return x, y, z if self.lift is not None else 0


class PointPosture(NamedTuple):
    """Kinematics of a state."""

    tip: Vector  # m
    tip_velocity: Vector  # m/s
    yaw_rate: float


@generic
def servo_acceleration(servo, u, q, v):
    """Return the acceleration [m/s²] of an axis at position q and velocity v: the input u itself without a servo."""
    return u


@servo_acceleration.register(Servo)
def _(servo, u, q, v):
    return -servo.kd * v - servo.kp * (q - u)


@generic
def vertical_acceleration(lift, servo, tau, pose):
    """Return the vertical acceleration [m/s²]: none without a lift."""
    return 0.0


@vertical_acceleration.register(Lift)
def _(lift, servo, tau, pose):
    return servo_acceleration(servo, tau[2], pose.tip[2], pose.tip_velocity[2])


@forward_kinematics.register(DrivenPoint)
def _(support, xs):
    return PointPosture(xs[:3], xs[3:], 0.0)


@support_acceleration.register(DrivenPoint)
def _(support, pose, gravity, tau, force):
    x = servo_acceleration(support.servo, tau[0], pose.tip[0], pose.tip_velocity[0])
    y = servo_acceleration(support.servo, tau[1], pose.tip[1], pose.tip_velocity[1])
    return x, y, vertical_acceleration(support.lift, support.servo, tau, pose)


@tip_acceleration.register(DrivenPoint)
def _(support, pose, qdd):
    return qdd, 0.0


@tip_mobility.register(DrivenPoint)
def _(support, pose, n):
    return 0.0


@drive_power.register(DrivenPoint)
def _(support, tau, pose, force):
    vx, vy, vz = pose.tip_velocity
    return -force[0] * vx - force[1] * vy - force[2] * vz


@support_guard.register(DrivenPoint)
def _(support, best, xs):
    return box_guard(support.limits, best, xs)


@generic
def box_guard(limits, best, xs):
    """Return the result of `support_guard` for a point with these limits."""
    return best


@box_guard.register(Box)
def _(limits, best, xs):
    best = travel_guard(limits.x, best, xs[0], encode(Guard.TRAVEL, 0))
    best = travel_guard(limits.y, best, xs[1], encode(Guard.TRAVEL, 1))
    return travel_guard(limits.z, best, xs[2], encode(Guard.TRAVEL, 2))


@yaw.register(DrivenPoint)
def _(support, xs):
    return 0.0


@support_polyline.register(DrivenPoint)
def _(support, xs):
    return (xs[:3],)


@support_polyline_size.register(DrivenPoint)
def _(support):
    return 1


@support_kinetic.register(DrivenPoint)
def _(support, pose):
    return 0.0


@support_potential.register(DrivenPoint)
def _(support, pose, gravity):
    return 0.0


@actuated_joints.register(DrivenPoint)
def _(support, p, x):
    return driven_components(support.lift, x[0][:3]), driven_components(support.lift, x[0][3:])


@efforts_from_row.register(DrivenPoint)
def _(support, p, row):
    return driven_components(support.lift, row)


@generic
def driven_components(lift, vector):
    """Return the components of a vector (3,) that are driven as a tuple: (x, y) without a lift."""
    return vector[0], vector[1]


@driven_components.register(Lift)
def _(lift, vector):
    return vector[0], vector[1], vector[2]
