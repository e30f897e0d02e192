"""The supports of cranes in scene files: their groups, joints and structures."""

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, NamedTuple, Self

from pydantic import ValidationInfo, field_validator

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, Positive, Range, Real
from crane_sim.models.effects import BoomSpring, JibSpring, RopeSpring
from crane_sim.models.supports.bridge import Bridge, BridgeAxis, Fixed
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.supports.support import Support
from crane_sim.models.supports.telescopic_boom import (
    BaseSection,
    Superstructure,
    TelescopedSection,
    TelescopicBoom,
)
from crane_sim.models.supports.tower_crane import JibTrolley, LockedSlew, Slew, TowerCrane
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.actuated import with_friction_and_motors
from crane_sim.scenes.schema.axes import AxisGroup, check_finite, check_mass, check_shape, start_of
from crane_sim.scenes.schema.backlash import Backlash, JointDrives, add_backlash, check_joint_names
from crane_sim.scenes.schema.flexibility import (
    Bending,
    BoomFlexibility,
    JibFlexibility,
    deflections,
    flexible_boom,
    flexible_jib,
)
from crane_sim.scenes.schema.groups import Group, tagged_union_validator
from crane_sim.scenes.schema.mast import angles_at_rest
from crane_sim.scenes.schema.rods import check_rods
from crane_sim.scenes.schema.suspension import Suspension

# m, m/s; largest difference of an axis at t = 0 from the start of its motion
START_TOLERANCE = 1e-9


class SupportJoint(NamedTuple):
    """A joint of a support."""

    name: str
    kind: Any  # type of its position in a file: `Angle`, or a length
    effort_unit: str

    @property
    def unit(self) -> str:
        """Unit of its position."""
        return "rad" if self.kind is Angle else "m"


class SupportGroups(Group):
    """What groups of any support provide; coordinates are ordered as `joints`, then modes."""

    joints: ClassVar[tuple[SupportJoint, ...]]

    @property
    def support_joints(self) -> tuple[str, ...]:
        """Names of the support's joints."""
        return tuple(joint.name for joint in self.joints)

    @property
    def driven_joints(self) -> tuple[SupportJoint, ...]:
        """The joints that take commands: all of them, unless a support says otherwise."""
        return self.joints

    @property
    def modes(self) -> dict[str, Any]:
        """The structure's bending modes by the names of their joints, in the joints' order."""
        return {}

    @property
    def play(self) -> Backlash:
        """The drives that have play, by joint."""
        return {}

    @property
    def support_windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the support's bodies by key, None where a body has none."""
        return {}

    @abstractmethod
    def structure(self, q: Any) -> Any:
        """Return the structure, whose positions are q at t = 0.

        Raises:
            SceneError: groups contradict each other.
        """

    def check_start(self, start: Any, target: Any) -> None:
        """Raise SceneError for a start (q, v) or a target that the support cannot have."""

    def velocities_at_start(self, start: Any) -> tuple[float, ...]:
        """Return the velocities at t = 0 of the support's joints and of what hangs there."""
        return start.v

    def is_locked(self, joint: str) -> bool:
        """Return whether a joint that takes commands does not move."""
        return False

    def why_still(self, joint: str) -> str:
        """Return the key and value of a file by which no command moves a joint."""
        return f"{joint}.drive = {getattr(getattr(self, joint), 'drive', 'locked')!r}"

    def deflections(self, structure: Any, q: Any, gravity: float, hung: float) -> tuple[float, ...]:
        """Return the modes' angles [rad] at positions q, with a mass `hung` [kg] at the tip."""
        return ()

    def left_to_rest(self) -> Self:
        """Return the groups without deflections given for t = 0."""
        return self

    def carrier(self, structure: Any, file: Any) -> Support:
        """Return the structure with the drives of its joints; `file` is all of the scene's.

        Raises:
            SceneError: drives do not fit their joints.
        """
        return Support(structure)


class DrivenSupport(SupportGroups):
    """The groups of all supports whose joints are driven by force or torque."""

    friction_joints: ClassVar[tuple[str, ...]] = ()  # that can have friction beside the support's
    friction: dict[str, Friction] = {}  # by joint of the support: its dry friction; the winch of a
    # `rope` has `rope.friction`, that of a knuckle boom's rope with a point mass `rope` here
    lugre: dict[str, LuGre] = {}  # by joint of the support: dry friction by bristles; a joint has
    # this or `friction`
    backlash: dict[str, JointDrives] = {}  # by joint of the support: its drives, one or several
    # side by side, which have play; joints that are left out have none

    @field_validator("friction", "lugre", "backlash", mode="before")
    @classmethod
    def _check_names(cls, group: Any, info: ValidationInfo) -> Any:
        """Reject groups of joints that the support lacks, before their values are read."""
        names = tuple(joint.name for joint in cls.joints)
        has_winch = info.field_name != "backlash" and "rope" in cls.model_fields
        further = cls.friction_joints if has_winch else ()
        return check_joint_names(group, (*names, *further))

    @property
    def play(self) -> Backlash:
        """The drives that have play, by joint."""
        return self.backlash

    def carrier(self, structure: Any, file: Any) -> Support:
        """Return the structure with friction, motors and play of its joints in a scene `file`."""
        support = with_friction_and_motors(structure, file, self.support_joints)
        return add_backlash(support, self.backlash, self.support_joints)


class Springs(Group):
    """Springs on joints."""

    boom: BoomSpring | None = None  # on the boom's elevation
    jib: JibSpring | None = None  # on the jib's elevation, or its angle from the boom
    rope: RopeSpring | None = None  # along the rope; it can push, too; with `rope.drive: force`


class KnuckleGroups(DrivenSupport):
    """A tower that slews, a boom and a jib that luff."""

    joints: ClassVar = (
        SupportJoint("slew", Angle, "N m"),
        SupportJoint("boom", Angle, "N m"),
        SupportJoint("jib", Angle, "N m"),
    )
    friction_joints: ClassVar = ("rope",)
    boom: Rod  # the rod at the tower
    jib: Rod  # the rod at the boom's end
    tower: Tower  # what slews besides boom and jib
    springs: Springs = Springs()  # springs on joints

    @property
    def support_windages(self) -> dict[str, AnyWindage | None]:
        """Windages of boom and jib by key."""
        return {"boom.windage": self.boom.windage, "jib.windage": self.jib.windage}

    def structure(self, q: Any) -> Knuckle:
        """Return the structure; SceneError: see `check_rods`."""
        check_rods(self.boom, self.jib)
        return Knuckle(self.boom, self.jib, self.tower, self.springs.boom, self.springs.jib)


class FlexibleGroups(DrivenSupport):
    """The groups of a support whose structure may bend."""

    @property
    def bending(self) -> BoomFlexibility | None:
        """The group `flexibility`."""
        return getattr(self, "flexibility")  # noqa: B009  (each support declares its own)

    @property
    def modes(self) -> dict[str, Bending]:
        """The modes by the name of their joint, none of a rigid structure."""
        return self.bending.modes if self.bending is not None else {}

    def left_to_rest(self) -> Self:
        """Return the groups without deflections given for t = 0."""
        if self.bending is None:
            return self
        return self.model_copy(update={"flexibility": self.bending.left_to_rest()})


class TowerGroups(FlexibleGroups):
    """A jib that slews, and a trolley on the jib."""

    joints: ClassVar = (SupportJoint("slew", Angle, "N m"), SupportJoint("trolley", Real, "N"))
    slew: Annotated[
        Any, tagged_union_validator("drive", {"force": Slew, "locked": LockedSlew})
    ]  # jib and counter-jib
    trolley: JibTrolley  # on the jib
    flexibility: JibFlexibility | None = None  # how the jib bends; left out: it is rigid

    @property
    def support_windages(self) -> dict[str, AnyWindage | None]:
        """Windages of jib and counter-jib by key."""
        keys = ("jib_windage", "counter_jib_windage")
        return {f"slew.{key}": getattr(self.slew, key, None) for key in keys}

    def structure(self, q: Any) -> Any:
        """Return the structure; SceneError: nothing can bend, or jib and mast would both bend."""
        return flexible_jib(TowerCrane(self.slew, self.trolley), self.flexibility, q)

    def is_locked(self, joint: str) -> bool:
        """Return whether the joint is a slew that is locked."""
        return joint == "slew" and isinstance(self.slew, LockedSlew)

    def check_start(self, start: Any, target: Any) -> None:
        """Raise SceneError where a locked slew turns, or should."""
        if not self.is_locked("slew"):
            return
        if start.v[0] != 0.0:
            raise SceneError(f"initial.v[0] = {start.v[0]}: slew.drive: locked does not turn")
        if target is not None and target[0] != start.q[0]:
            raise SceneError(
                f"reference.q[0] = {target[0]}: slew.drive: locked stays at initial.q[0] = "
                f"{start.q[0]}"
            )

    def deflections(self, structure: Any, q: Any, gravity: float, hung: float) -> tuple[float, ...]:
        """Return the angles [rad] of jib or mast at joint positions q."""
        if self.flexibility is not None and self.flexibility.mast is not None:
            return angles_at_rest(structure, q[0], q[1], gravity, hung)
        return deflections(structure, self.flexibility, (0.0, q[1]), gravity, hung)


class MobileGroups(FlexibleGroups):
    """A boom that slews, luffs and telescopes."""

    joints: ClassVar = (
        SupportJoint("slew", Angle, "N m"),
        SupportJoint("boom", Angle, "N m"),
        SupportJoint("telescope", Positive, "N"),
    )
    superstructure: Superstructure  # what slews besides the boom
    boom: BaseSection  # the boom's base section
    telescope: TelescopedSection  # the section that is telescoped out
    flexibility: BoomFlexibility | None = None  # how the boom bends; left out: it is rigid

    @property
    def support_windages(self) -> dict[str, AnyWindage | None]:
        """The boom's windage by key."""
        return {"boom.windage": self.boom.windage}

    def structure(self, q: Any) -> Any:
        """Return the structure; SceneError: nothing can bend, or a boom too short."""
        self._check_shortest(q[2])
        rigid = TelescopicBoom(self.superstructure, self.boom, self.telescope)
        return flexible_boom(rigid, self.flexibility, q)

    def _check_shortest(self, start: float) -> None:
        """Raise SceneError where the telescoped section does not fit the shortest boom."""
        section = self.telescope
        shortest = start if section.limits is None else min(start, section.limits[0])
        if shortest < section.centre:
            raise SceneError(
                f"telescope.centre = {section.centre}: exceeds the shortest boom length, "
                f"{shortest:g} m at "
                "initial.q[2] or telescope.limits[0]: the section's centre of mass would lie "
                "behind the foot pin"
            )
        if self.flexibility is not None and section.inertia == 0.0 and shortest == section.centre:
            raise SceneError(
                "telescope.inertia = 0: must be greater than 0 below `flexibility` where "
                "telescope.centre is the "
                f"shortest boom length, {shortest:g} m: what bends would have no inertia about the "
                "foot pin"
            )

    def deflections(self, structure: Any, q: Any, gravity: float, hung: float) -> tuple[float, ...]:
        """Return the angles [rad] of the boom at joint positions q."""
        return deflections(structure, self.flexibility, (q[1], q[2]), gravity, hung)


class BridgeGroups(DrivenSupport):
    """A trolley on a bridge or portal."""

    joints: ClassVar = (SupportJoint("trolley", Real, "N"), SupportJoint("bridge", Real, "N"))
    trolley: AxisGroup  # along x
    bridge: AxisGroup  # along y

    @property
    def _axes(self) -> dict[str, AxisGroup]:
        return {"trolley": self.trolley, "bridge": self.bridge}

    @property
    def driven_joints(self) -> tuple[SupportJoint, ...]:
        """Those of trolley and bridge that a force drives."""
        return tuple(joint for joint in self.joints if self._axes[joint.name].drive == "force")

    def velocities_at_start(self, start: Any) -> tuple[float, ...]:
        """Return the velocities at t = 0, as prescribed where no force drives an axis."""
        rates = list(start.v)
        for i, (name, axis) in enumerate(self._axes.items()):
            if axis.motion is not None:
                place, rate = start_of(axis.motion)
                if abs(start.q[i] - place) > START_TOLERANCE:
                    raise SceneError(
                        f"initial: the {name} is at {start.q[i]:g} m, {name}.motion starts at "
                        f"{place:g} m"
                    )
                rates[i] = rate if "v" not in start.model_fields_set else rates[i]
                if abs(rates[i] - rate) > START_TOLERANCE:
                    raise SceneError(
                        f"initial.v[{i}] = {rates[i]:g}: {name}.motion starts at {rate:g} m/s"
                    )
            elif axis.drive == "fixed" and rates[i] != 0.0:
                raise SceneError(
                    f"initial.v[{i}] = {rates[i]:g}: a fixed {name} is at rest; must be 0"
                )
        return tuple(rates)

    def structure(self, q: Any) -> Bridge:
        """Return the structure; SceneError: mass, motion or friction do not fit the drive."""
        return Bridge(*(self._axis(name, axis) for name, axis in self._axes.items()))

    def _axis(self, name: str, axis: AxisGroup) -> BridgeAxis:
        check_shape(f"{name}.motion", axis.motion, axis.drive)
        check_finite(f"{name}.motion", axis.motion)
        check_mass(name, axis, carried=name == "trolley" and self.bridge.drive == "force")
        if axis.drive == "force":
            moved = (axis.mass or 0.0) + (0.0 if name == "trolley" else self.trolley.mass or 0.0)
            if axis.mass is None or not moved > 0.0:
                raise SceneError(
                    f"{name}.mass = {axis.mass}: a {name} driven by force has one, which must be "
                    "greater than 0"
                )
            return BridgeAxis(axis.mass, axis.limits)
        for key in ("friction", "lugre", "backlash"):
            if name in getattr(self, key):
                raise SceneError(
                    f"{key}.{name}: belongs to a drive by force, here it is {axis.drive!r}"
                )
        return BridgeAxis(
            axis.mass or 0.0, axis.limits, Fixed() if axis.motion is None else axis.motion.motion()
        )


class GantryGroups(BridgeGroups):
    """A trolley on a portal that travels along y, on a ship-to-shore crane with a boom."""

    legs: Range | None = None  # m, where its legs stand along the trolley's rail, which only its
    # picture shows; a rail that reaches further beyond them than they are apart is drawn as the
    # boom of a ship-to-shore crane


class PointGroups(SupportGroups):
    """A suspension point whose motion does not depend on what hangs on it."""

    suspension: Suspension = Suspension()  # the suspension point

    @property
    def joints(self) -> tuple[SupportJoint, ...]:  # type: ignore[override]
        """The point's coordinates."""
        return tuple(
            SupportJoint(f"tip_{axis}", Real, self.suspension.effort_unit) for axis in "xyz"
        )

    @property
    def driven_joints(self) -> tuple[SupportJoint, ...]:
        """Those coordinates that are driven."""
        return self.joints if self.suspension.height == "driven" else self.joints[:2]

    def why_still(self, joint: str) -> str:
        """Return the key and value of a file by which no command moves a coordinate."""
        return f"suspension.height = {self.suspension.height!r}"

    def structure(self, q: Any) -> DrivenPoint:
        """Return the structure; SceneError: gains or limits do not fit the drive."""
        return self.suspension.point()

    def velocities_at_start(self, start: Any) -> tuple[float, ...]:
        """Return the velocity at t = 0; SceneError: it leaves its fixed height."""
        rate = start.tip_velocity
        if self.suspension.height == "fixed" and rate[2] != 0.0:
            raise SceneError(
                f"initial.tip_velocity[2] = {rate[2]}: must be 0 where the height is fixed"
            )
        return rate
