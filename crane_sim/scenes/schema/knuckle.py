"""The schema of a scene file with a knuckle-boom crane, and the model that it describes."""

from math import cos, sin
from typing import Any, ClassVar, Literal

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, Positive, Real, Tilt
from crane_sim.models.cables.rope import ForceRope, LockedRope, MotionRope
from crane_sim.models.effects import BoomSpring, JibSpring, RopeSpring
from crane_sim.models.loads import PointLoad
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.single_rope.joint_friction import JointFriction
from crane_sim.models.stops import Stops
from crane_sim.models.supports.friction import Friction as DryFriction
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.backlash import SupportJoints
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.knuckle_checks import check_rods, validate_friction
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.motors import reflected_inertia
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.rigging import RiggingStart
from crane_sim.scenes.schema.supported import JointMobility, SupportedFile
from crane_sim.scenes.schema.suspended import SuspendedFile
from crane_sim.trajectories.inputs import Constant


class Springs(Group):
    """Springs on joints."""

    boom: BoomSpring | None = None  # on the boom's elevation
    jib: JibSpring | None = None  # on the jib's elevation, or its angle from the boom
    rope: RopeSpring | None = None  # along the rope; it can push, too; with `rope.drive: force`


class Initial(Group):
    """Joint coordinates at t = 0, in joint order; boom and jib are elevations from the horizontal."""

    q: tuple[Angle, Angle, Angle, Positive, Tilt, Tilt]  # rad, slew, boom, jib, rope [m], swing_tangential,
    # swing_radial; angles may be text such as `30 deg`
    v: tuple[Real, Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # rad/s, of the same joints; of the
    # rope [m/s]
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class KnuckleReference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Angle, Angle, Angle, Positive] | None = None  # rad, where slew, boom, jib and rope or falls [m]
    # should end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    slew: Channel = Constant(0.0)  # N m, torque about the vertical
    boom: Channel = Constant(0.0)  # N m, torque on the elevation
    jib: Channel = Constant(0.0)  # N m, torque on the elevation
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class KnuckleGroups(SupportedFile):
    """The groups of a knuckle-boom crane's support."""

    support_joints: ClassVar[SupportJoints] = (("slew", "rad", "N m"), ("boom", "rad", "N m"), ("jib", "rad", "N m"))
    boom: Rod  # the rod at the tower
    jib: Rod  # the rod at the boom's end
    tower: Tower  # what slews besides boom and jib
    springs: Springs = Springs()  # springs on joints
    reference: KnuckleReference | None = None  # where the crane should go

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        return super().windages | {"boom.windage": self.boom.windage, "jib.windage": self.jib.windage}

    @property
    def support_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the support's joints that have some."""
        return limits_of(
            ("slew", "tower.limits", self.tower.limits),
            ("boom", "boom.limits", self.boom.limits),
            ("jib", "jib.limits", self.jib.limits),
        )

    def _tip_radius_and_height(self, q: Any, bend: float) -> tuple[float, float]:
        """Return (radius, height) [m] of the jib's end at joint positions q; it does not bend."""
        rods = (self.boom.length, q[1]), (self.jib.length, q[2])
        return sum(a * cos(angle) for a, angle in rods), sum(a * sin(angle) for a, angle in rods)

    def joint_mobility(self) -> JointMobility:
        """Return the mobility of slew, boom and jib at t = 0."""
        (_, beta, gamma, *_), boom, jib = self._initial.q, self.boom, self.jib
        (a, b), radius = (boom.length, jib.length), self._tip_radius_and_height(self._initial.q, 0.0)[0]
        jacobian_t = np.array(
            [
                [0.0, radius, 0.0, 1.0],
                [-a * sin(beta), 0.0, a * cos(beta), 0.0],
                [-b * sin(gamma), 0.0, b * cos(gamma), 0.0],
            ]
        )
        turning = self.tower.inertia + boom.mass * (0.5 * a * cos(beta)) ** 2
        turning += jib.mass * (a * cos(beta) + 0.5 * b * cos(gamma)) ** 2
        luffing, mixed = (
            boom.inertia + a * a * (0.25 * boom.mass + jib.mass),
            0.5 * jib.mass * a * b * cos(beta - gamma),
        )
        masses = [[turning, 0.0, 0.0], [0.0, luffing, mixed], [0.0, mixed, jib.inertia + 0.25 * jib.mass * b * b]]
        return JointMobility(jacobian_t, np.linalg.inv(masses))

    def support(self) -> Knuckle:
        """Return the parameters of the support.

        Raises:
            SceneError: no rigid body has such an inertia, or nothing resists the joints' efforts.
        """
        check_rods(self.boom, self.jib)
        slew, boom, jib = motors = tuple(reflected_inertia(self, name) for name, _, _ in self.support_joints)
        springs, turned = self.springs, (slew, boom, jib) if any(motors) else None
        return Knuckle(self.boom, self.jib, self.tower, springs.boom, springs.jib, turned)


class KnuckleFile(KnuckleGroups, SuspendedFile):
    """A scene with a knuckle-boom crane: a tower that slews, a boom and a jib that luff, a payload on rope and links.

    One rope and a point mass have a closed form of their own. `links`, `payload.inertia`, `events`, `backlash` and
    `rope.reeving`, `rope.friction`, `rope.torsion` choose the suspended cable of the other cranes, beside which
    `springs.rope` and `friction.rope` are refused.
    """

    friction_joints: ClassVar[tuple[str, ...]] = ("slew", "boom", "jib", "rope")
    crane: Literal["knuckle"]  # the kind of crane
    initial: Initial  # the state at t = 0
    friction: dict[str, DryFriction] = {}  # by joint, slew, boom or jib, or rope with `rope.drive: force`: its dry
    # friction; below further links, or with a rigid-body payload, the winch has `rope.friction`
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    @property
    def beyond_one_rope(self) -> list[str]:
        """Keys of the file that the equations of one rope and a point mass do not support."""
        rope = {f"rope.{key}": getattr(self.rope, key) for key in ("reeving", "friction", "torsion")}
        body = {"payload.inertia": self.payload.inertia, "links": self.links, "events": self.events}
        return [key for key, value in (body | {"backlash": self.backlash} | rope).items() if value]

    @property
    def rope_only(self) -> list[str]:
        """Keys of the file that only the equations of one rope and a point mass support."""
        groups = {"springs.rope": self.springs.rope}
        groups |= {f"{key}.rope": getattr(self, key).get("rope") for key in ("friction", "lugre")}
        return [key for key, value in groups.items() if value is not None]

    def model(self) -> Crane | SuspendedCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        if not self.beyond_one_rope:
            return self._crane_with_one_rope()
        for key in self.rope_only:
            raise SceneError(
                f"{key}: belongs to one rope and a point mass, here is {self.beyond_one_rope[0]}; leave out one of both"
                + ("; the winch has rope.friction" if key == "friction.rope" else "")
            )
        return super().model()

    def _crane_with_one_rope(self) -> Crane:
        """Return the parameters of the crane with one rope and a point mass."""
        support, cable, load = self.support(), self._cable(), self.payload.load()
        assert isinstance(load, PointLoad)
        crane = Crane(support, cable, load, self.gravity, self.swing_friction, self.payload_drag)
        if reflected_inertia(self, "rope") > 0.0:
            raise SceneError("actuators.rope.motor.inertia: the winch of rope.drive: force has no inertia; must be 0")
        return crane._replace(
            base=self.base(),
            force=self.force(),
            stops=self._stops(),
            wind=self.airflow(),
            friction=self._joint_friction(),
        )

    def _joint_friction(self) -> JointFriction | None:
        """Return the friction of the joints above one rope and a point mass, None where none has any."""
        return validate_friction(self.friction, self.lugre, self.rope.drive)

    def _stops(self) -> Stops | None:
        """Return the conditions that end a run, None where nothing ends or switches it."""
        if self.beyond_one_rope:
            return super()._stops()
        stops = self.rope.stops(bool(self.limits or self._joint_friction()))
        return stops or (Stops() if self.is_in_kinked_wind else None)

    def _cable(self) -> ForceRope | MotionRope | LockedRope:
        drive = self.rope.drive
        self.rope.check(self.initial.q[3], self.initial.v[3], 3)
        if self.springs.rope is not None and drive != "force":
            raise SceneError(f"springs.rope: only a force drive can have one, this drive is {drive!r}")
        if drive == "locked":
            return LockedRope(self.initial.q[3])
        return MotionRope(self.rope.time_constant) if drive == "rate" else ForceRope(self.springs.rope)
