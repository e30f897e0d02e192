"""The schema of a scene file with a payload below a driven suspension point, and the model that it describes."""

from math import inf, sqrt
from typing import Any, Literal

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive
from crane_sim.models.cables.rope import LockedRope
from crane_sim.models.loads import PointLoad
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.stops import Stops
from crane_sim.models.supports.driven_point import Box, DrivenPoint, Lift, Servo
from crane_sim.models.supports.support import Support
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.suspended.torsion import Torsion
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.reference import ReferenceGroup, target_of
from crane_sim.scenes.schema.rigged import RiggedFile
from crane_sim.scenes.schema.rigging import ATTITUDE, UNIT_TOLERANCE, RiggingStart, Vector, link_names, rigging_start
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.trajectories.inputs import Constant, Inputs


class Suspension(Group):
    """Drive of the suspension point, whose motion does not depend on the payload."""

    drive: Literal["acceleration", "servo"] = "acceleration"  # what the input is: the point's acceleration relative to
    # the base [m/s²], or with `servo` where the point should be [m]
    kp: Positive | None = None  # 1/s², of a servo, which needs one
    kd: NonNegative | None = None  # 1/s, of a servo, which needs one
    height: Literal["fixed", "driven"] = "fixed"  # whether z of the point is driven, too
    limits: Box | None = None  # m, by axis, of the point relative to the base; a run ends where one is reached

    def point(self) -> DrivenPoint:
        """Return the support.

        Raises:
            SceneError: gains are missing, or belong to another drive; or limits to a height that is fixed.
        """
        if self.limits is not None and self.limits.z is not None and self.height == "fixed":
            raise SceneError("suspension.limits.z: the height is fixed; take suspension.height: driven")
        lift = Lift() if self.height == "driven" else None
        for name, gain in (("kp", self.kp), ("kd", self.kd)):
            if self.drive == "servo" and gain is None:
                raise SceneError(f"suspension.{name}: is missing; a servo needs kp and kd")
            if self.drive != "servo" and gain is not None:
                raise SceneError(f"suspension.{name}: only a servo has one, this drive is {self.drive!r}")
        if self.kp is None or self.kd is None:
            return DrivenPoint(None, lift, self.limits)
        return DrivenPoint(Servo(self.kp, self.kd), lift, self.limits)


class Rope(Group):
    """The rope, which stays as long as it is."""

    length: Positive  # m, from the suspension point to the payload
    slack: Literal["allow", "stop"] = "allow"  # stop: a run ends where the rope, or a further link, would push
    torsion: Torsion | None = None  # what resists a twist between point and payload; left out: the payload turns freely


class TipStart(Group):
    """The suspension point at t = 0, relative to the base."""

    tip: Vector = (0.0, 0.0, 0.0)  # m, position of the suspension point
    tip_velocity: Vector = (0.0, 0.0, 0.0)  # m/s, its velocity


class Initial(TipStart):
    """The suspension point and the direction of the rope at t = 0, relative to the base."""

    direction: Vector = (0.0, 0.0, -1.0)  # -, unit vector from the point to the payload
    direction_rate: Vector = (0.0, 0.0, 0.0)  # 1/s, across the direction
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class InputGroup(Group):
    """Open-loop inputs of the suspension point; silent ones are zero."""

    tip_x: Channel = Constant(0.0)  # effort's unit, along x
    tip_y: Channel = Constant(0.0)  # effort's unit, along y
    tip_z: Channel | None = None  # effort's unit, along z, with `suspension.height: driven`


class PendulumGroups(SceneFile):
    """The groups of a driven suspension point."""

    suspension: Suspension = Suspension()  # the suspension point
    reference: ReferenceGroup | None = None  # where the crane should go
    inputs: InputGroup | None = None  # of the suspension point where there is no law

    @property
    def _point(self) -> tuple[Vector, Vector]:
        """(position [m], velocity [m/s]) of the suspension point at t = 0.

        Raises:
            SceneError: it leaves its fixed height.
        """
        start: TipStart = getattr(self, "initial")  # noqa: B009  (every schema declares its own)
        if self.suspension.height == "fixed" and start.tip_velocity[2] != 0.0:
            raise SceneError(f"initial.tip_velocity[2] = {start.tip_velocity[2]}: must be 0 where the height is fixed")
        return start.tip, start.tip_velocity

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands."""
        unit = "m" if self.suspension.drive == "servo" else "m/s²"
        return (unit,) * (3 if self.suspension.height == "driven" else 2)

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the suspension point.

        Raises:
            SceneError: it has another number of coordinates than are driven.
        """
        return target_of(self.reference, self.actuated)

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        box = self.suspension.limits or Box()
        return limits_of(
            ("tip_x", "suspension.limits.x", box.x),
            ("tip_y", "suspension.limits.y", box.y),
            ("tip_z", "suspension.limits.z", box.z),
        )

    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the open-loop inputs; where there are none, held efforts that leave the point where it is.

        Raises:
            SceneError: there is an input of a height that is fixed.
        """
        inputs, nu = self.inputs, len(self.actuated)
        if inputs is None:
            return self._point[0][:nu] if self.suspension.drive == "servo" else (0.0,) * nu
        if inputs.tip_z is not None and nu == 2:
            raise SceneError("inputs.tip_z: the height is fixed; take suspension.height: driven")
        height = (inputs.tip_z or Constant(0.0),) if nu == 3 else ()
        return Inputs((inputs.tip_x, inputs.tip_y, *height))


class PendulumFile(PendulumGroups, RiggedFile):
    """A scene with a payload on rope and links below a driven suspension point.

    One rope and a point mass have a closed form of their own. `links`, `payload.inertia`, `events` and `rope.torsion`
    choose the suspended cable of the other cranes.
    """

    crane: Literal["pendulum"]  # the kind of crane
    rope: Rope  # the rope, of fixed length
    initial: Initial = Initial()  # the state at t = 0

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: coordinates of the suspension point, unit vectors down rope and links, the payload's attitude."""
        body = ATTITUDE if self.payload.inertia is not None else ()
        return ("tip_x", "tip_y", "tip_z", *link_names(len(self.links) + 1, 1), *body)

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions."""
        return "m", "m", "m", *("1",) * (len(self.joint_names) - 3)

    @property
    def _direction(self) -> tuple[float, ...]:
        """Unit vector (3,) down the rope at t = 0."""
        start = self.initial
        length = sqrt(sum(x * x for x in start.direction))
        if not abs(length - 1.0) < UNIT_TOLERANCE:
            raise SceneError(f"initial.direction = {list(start.direction)}: must be a unit vector")
        return tuple(x / length for x in start.direction)

    def _rigging(self) -> tuple[Any, Any]:
        """Return (q, v) of further links and attitude."""
        rope = self._direction, self.initial.direction_rate
        start = self.initial.rigging or RiggingStart()
        start = start if self._torsion is None else start.nearest_to(0.0)
        return rigging_start(start, len(self.links), self.payload.inertia is not None, rope)

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0.

        Raises:
            SceneError: a direction is no unit vector.
        """
        return (*self.initial.tip, *self._direction, *self._rigging()[0])

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0.

        Raises:
            SceneError: a direction changes along itself, or the point leaves its fixed height.
        """
        start = self.initial
        along = sum(x * v for x, v in zip(start.direction, start.direction_rate, strict=True))
        if abs(along) > UNIT_TOLERANCE * (1.0 + max(map(abs, start.direction_rate))):
            raise SceneError(f"initial.direction_rate = {list(start.direction_rate)}: must be across the direction")
        return (*self._point[1], *start.direction_rate, *self._rigging()[1])

    @property
    def rope_length(self) -> float:
        """Length of rope and further links [m]."""
        return self.rope.length + sum(link.length for link in self.links)

    @property
    def payload_height(self) -> float:
        """Height of the payload's attachment above the base's origin at t = 0 [m]."""
        further = [self._rigging()[0][3 * k + 2] * link.length for k, link in enumerate(self.links)]
        return self.initial.tip[2] + self.rope.length * self._direction[2] + sum(further)

    @property
    def lowest_pressure(self) -> float:
        """Height [m] above the base's origin below which no wind presses on the payload."""
        rests = self.suspension.height == "fixed" and self.base_motion is None
        return self._lowest_below(self.initial.tip[2], self.rope.length) if rests else -inf

    @property
    def beyond_one_rope(self) -> list[str]:
        """Keys of the file that the equations of one rope and a point mass do not support."""
        body = {"payload.inertia": self.payload.inertia, "links": self.links, "events": self.events}
        return [key for key, value in (body | {"rope.torsion": self.rope.torsion}).items() if value]

    def method_requirements(self, sampled: bool) -> MethodRequirements:
        """Return the scene's requirements on its integration method."""
        smooth = not (sampled or self._stops() or self.has_quadratic_loss)
        stiffest = max(self._twist_frequency(0.0), self._swing_frequency(self.rope.length, np.zeros((4, 4))))
        return MethodRequirements(stiffest or None, 0.0, elastic=False, smooth=smooth, duration=self.duration)

    def _stops(self) -> Stops | None:
        """Return the conditions that end a run, None without any."""
        taut = self.rope.slack == "stop"
        switches = self.limits or self.events or self.rope.torsion or self.is_in_kinked_wind
        return Stops(taut=float(taut)) if taut or switches else None

    def model(self) -> Crane | SuspendedCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        point, load = self.suspension.point(), self.payload.load()
        if not self.beyond_one_rope:
            assert isinstance(load, PointLoad)
            return self._crane_with_one_rope(point, load)
        if self.rope.torsion is not None and self.payload.inertia is None:
            raise SceneError("rope.torsion: belongs to a payload that is a body; give payload.inertia, or leave it out")
        return self.suspended_crane(Support(point), self.rope.length, None, self._stops(), ())

    def _crane_with_one_rope(self, point: DrivenPoint, load: PointLoad) -> Crane:
        """Return the parameters of the crane with one rope and a point mass."""
        return Crane(
            point,
            LockedRope(self.rope.length),
            load,
            self.gravity,
            self.swing_friction,
            self.payload_drag,
            base=self.base(),
            force=self.force(),
            stops=self._stops(),
            wind=self.airflow(),
        )
