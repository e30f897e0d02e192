"""A suspension point that is driven, as a boom's tip or a gantry's would be, without own mass.

The drive is ideal, its inputs u (in `tau`'s place) are the point's accelerations; or it is a servo
whose inputs are positions: y₀'' = -kd y₀' - kp (y₀ - u), axis by axis. Both are relative to the
base, and what the cable pulls does not move the point. Joint coordinates are the point's position
and the unit vector from it to the payload: no angles, so no direction is singular.
"""

from typing import Any, NamedTuple

from crane_sim.files.types import NonNegative, Positive, Range
from crane_sim.models.guards import Guard, encode, travel_guard
from crane_sim.models.supports.support import Mechanism
from crane_sim.multibody.tree import Joint, Point, Tree, X, Y, Z
from crane_sim.multibody.vectors import dot

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


class PointPosture(NamedTuple):
    """Kinematics of a state."""

    tip: Vector  # m
    tip_velocity: Vector  # m/s
    yaw_rate: float


class DrivenPoint(NamedTuple):
    """Parameters of the support."""

    servo: Servo | None = None  # None: inputs are accelerations
    lift: Lift | None = None  # None: the point keeps its height
    limits: Box | None = None

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return f"suspension point along {'xyz'[i]}", f"suspension.limits.{'xyz'[i]}"

    def mechanism(self) -> Mechanism:
        """Return the joints: massless slides along x, y, z, whose accelerations are prescribed."""
        joints = (Joint(X, ((0, 1),), slides=True), Joint(Y, ((1, 1),), slides=True, parent=0))
        box = self.limits or Box()
        return Mechanism(
            Tree((*joints, Joint(Z, ((2, 1),), slides=True, parent=1)), Point(2)),
            limits=(box.x, box.y, box.z),
            actuated=(0, 1) if self.lift is None else (0, 1, 2),
            yaw=(),
            prescribed=(True, True, True),
        )

    def prescribe(
        self, t: Any, efforts: tuple[Any, ...], q: tuple[Any, ...], v: tuple[Any, ...]
    ) -> tuple[Any, ...]:
        """Return the accelerations (3,) [m/s²] at inputs (3,): none along z without a lift."""
        x, y, z = (
            servo_acceleration(self.servo, u, place, rate)
            for u, place, rate in zip(efforts, q, v, strict=True)
        )
        return x, y, z if self.lift is not None else 0

    def forward_kinematics(self, xs):
        """Return the PointPosture of state xs."""
        return PointPosture(xs[:3], xs[3:], 0.0)

    def accelerations(self, pose, gravity, tau, force):
        """Return the accelerations (3,) [m/s²] at inputs tau, whatever pulls."""
        parts = zip(self.driven_components(tau), pose.tip, pose.tip_velocity, strict=False)
        driven = [servo_acceleration(self.servo, u, place, rate) for u, place, rate in parts]
        return (*driven, 0.0)[:3]  # without a lift none along z

    def tip_acceleration(self, pose, qdd):
        """Return (the accelerations, 0 for the yaw)."""
        return qdd, 0.0

    def tip_mobility(self, pose, n):
        """Return that no force moves the point."""
        return 0.0

    def add_base_efforts(self, tau, base, pose):
        """Return tau: the point has no mass."""
        return tau

    def add_wind_efforts(self, tau, flow, base, pose):
        """Return tau: the point has no area."""
        return tau

    def add_yaw_moment(self, tau, couple):
        """Return tau: the point does not turn."""
        return tau

    def power(self, tau, pose, force):
        """Return the power [W] of the drive against a force (3,) [N] on the point."""
        return -dot(force, pose.tip_velocity)

    def guard(self, best, xs):
        """Return the smallest one of `best` and of the travel limits.

        See `crane_sim.models.guards`.
        """
        box = self.limits or Box()
        for i, limits in enumerate((box.x, box.y, box.z)):
            best = travel_guard(limits, best, xs[i], encode(Guard.TRAVEL, i))
        return best

    def yaw(self, xs):
        """Return that the frame does not turn."""
        return 0.0

    def polyline(self, xs):
        """Return the point alone, as a tuple of points."""
        return (xs[:3],)

    def polyline_size(self):
        """Return the number of points of the polyline."""
        return 1

    def kinetic(self, pose):
        """Return no energy."""
        return 0.0

    def potential(self, pose, gravity):
        """Return no energy."""
        return 0.0

    def base_energy(self, base, pose, gravity):
        """Return no (kinetic, potential) energy."""
        return 0.0, 0.0

    def driven_components(self, vector):
        """Return the driven components of a vector (3,) as a tuple: (x, y) without a lift."""
        return (vector[0], vector[1]) if self.lift is None else (vector[0], vector[1], vector[2])


def servo_acceleration(servo, u, q, v):
    """Return the acceleration [m/s²] of an axis at position q, velocity v; u without a servo.

    u is the input itself.
    """
    return u if servo is None else -servo.kd * v - servo.kp * (q - u)
