"""The group `suspension` of a scene file: a driven point from which rope or falls hang."""

from typing import Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive
from crane_sim.models.supports.driven_point import Box, DrivenPoint, Lift, Servo
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.rigging import Vector


class Suspension(Group):
    """Drive of the suspension point, whose motion does not depend on the payload."""

    drive: Literal["acceleration", "servo"] = "acceleration"  # what the input is: the point's
    # acceleration relative to the base [m/s²], or with `servo` where the point should be [m]
    kp: Positive | None = None  # 1/s², of a servo, which needs one
    kd: NonNegative | None = None  # 1/s, of a servo, which needs one
    height: Literal["fixed", "driven"] = "fixed"  # whether z of the point is driven, too
    limits: Box | None = None  # m, by axis, of the point relative to the base; a run ends where one
    # is reached

    @property
    def effort_unit(self) -> str:
        """Unit of its inputs."""
        return "m" if self.drive == "servo" else "m/s²"

    def point(self) -> DrivenPoint:
        """Return the support.

        Raises:
            SceneError: gains are missing, or belong to another drive; or limits to a height that is
                fixed.
        """
        if self.limits is not None and self.limits.z is not None and self.height == "fixed":
            raise SceneError(
                "suspension.limits.z: the height is fixed; take suspension.height: driven"
            )
        lift = Lift() if self.height == "driven" else None
        for name, gain in (("kp", self.kp), ("kd", self.kd)):
            if self.drive == "servo" and gain is None:
                raise SceneError(f"suspension.{name}: is missing; a servo needs kp and kd")
            if self.drive != "servo" and gain is not None:
                raise SceneError(
                    f"suspension.{name}: only a servo has one, this drive is {self.drive!r}"
                )
        servo = None if self.kp is None or self.kd is None else Servo(self.kp, self.kd)
        return DrivenPoint(servo, lift, self.limits)


class TipStart(Group):
    """The suspension point at t = 0, relative to the base."""

    tip: Vector = (0.0, 0.0, 0.0)  # m, position of the suspension point
    tip_velocity: Vector = (0.0, 0.0, 0.0)  # m/s, its velocity

    @property
    def q(self) -> Vector:
        """Position (3,) of the point."""
        return self.tip

    @property
    def v(self) -> Vector:
        """Velocity (3,) of the point."""
        return self.tip_velocity
