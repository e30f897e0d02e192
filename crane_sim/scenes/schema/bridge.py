"""The schema of a scene file with a bridge crane whose load hangs on hook and sling, and the model it describes."""

from typing import Any, ClassVar, Literal

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Positive, Real, Tilt
from crane_sim.models.supports.bridge import Bridge, BridgeAxis, Fixed
from crane_sim.scenes.schema.backlash import SupportJoints
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.overhead_cable import initial_motion
from crane_sim.scenes.schema.overhead_checks import check_finite, check_mass
from crane_sim.scenes.schema.overhead_drives import check_shape
from crane_sim.scenes.schema.overhead_groups import AxisGroup
from crane_sim.scenes.schema.reference import ReferenceGroup, target_of
from crane_sim.scenes.schema.rigging import RiggingStart
from crane_sim.scenes.schema.supported import JointMobility, SupportedFile, Tip
from crane_sim.scenes.schema.suspended import SuspendedFile
from crane_sim.trajectories.inputs import Constant

START_TOLERANCE = 1e-9  # m, m/s; largest difference of an axis at t = 0 from the start of its motion


class Initial(Group):
    """Joint coordinates at t = 0, in joint order."""

    q: tuple[Real, Real, Positive, Tilt, Tilt]  # m, trolley, bridge, rope, swing_tangential [rad], swing_radial [rad]
    v: tuple[Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0)  # m/s, of the same joints; of swings [rad/s]
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    trolley: Channel = Constant(0.0)  # N, force along x
    bridge: Channel = Constant(0.0)  # N, force along y
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class BridgeGroups(SupportedFile):
    """The groups of a trolley on a bridge or portal."""

    support_joints: ClassVar[SupportJoints] = (("trolley", "m", "N"), ("bridge", "m", "N"))
    trolley: AxisGroup  # along x
    bridge: AxisGroup  # along y

    @property
    def _axes(self) -> dict[str, AxisGroup]:
        return {"trolley": self.trolley, "bridge": self.bridge}

    @property
    def driven_joints(self) -> SupportJoints:
        """Those of trolley and bridge that a force drives."""
        return tuple(joint for joint in self.support_joints if self._axes[joint[0]].drive == "force")

    @property
    def support_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the support's joints that have some."""
        return limits_of(*((name, f"{name}.limits", axis.limits) for name, axis in self._axes.items()))

    @property
    def _initial(self) -> Any:
        """The state at t = 0, where axes that are not driven by a force move as they say."""
        start = super()._initial
        rates = list(start.v)
        for i, (name, axis) in enumerate(self._axes.items()):
            if axis.motion is not None:
                place, rate = initial_motion(axis.motion)
                if abs(start.q[i] - place) > START_TOLERANCE:
                    raise SceneError(f"initial: the {name} is at {start.q[i]:g} m, {name}.motion starts at {place:g} m")
                rates[i] = rate if "v" not in start.model_fields_set else rates[i]
                if abs(rates[i] - rate) > START_TOLERANCE:
                    raise SceneError(f"initial.v[{i}] = {rates[i]:g}: {name}.motion starts at {rate:g} m/s")
            elif axis.drive == "fixed" and rates[i] != 0.0:
                raise SceneError(f"initial.v[{i}] = {rates[i]:g}: a fixed {name} is at rest; must be 0")
        return start.model_copy(update={"v": tuple(rates)})

    def _target(self, last: str) -> tuple[float, ...] | None:
        """Return the target of the actuated joints, after which one of a rope that keeps its length may stand.

        Raises:
            SceneError: it has another number of values, or the length of rope or falls is not greater than 0.
        """
        target = target_of(getattr(self, "reference", None), (*(name for name, _, _ in self.driven_joints), last))
        if target is not None and not target[-1] > 0.0:
            raise SceneError(f"reference.q[{len(target) - 1}] = {target[-1]:g}: is a length, must be greater than 0")
        return None if target is None else target[: len(self.actuated)]

    def _tip_radius_and_height(self, q: Any, bend: float) -> tuple[float, float]:
        """Raise NotImplementedError: the tip, a trolley on a bridge, has x and y, no radius about a slew."""
        raise NotImplementedError

    def tip(self, q: Any) -> Tip:
        """Return where the trolley is at joint positions q."""
        return Tip((q[0], q[1], 0.0))

    def joint_mobility(self) -> JointMobility:
        """Return the mobility of trolley and bridge."""
        inverse = [1.0 / self._moved_mass(name) if axis.drive == "force" else 0.0 for name, axis in self._axes.items()]
        return JointMobility(jacobian_t=np.eye(2, 4), inverse_inertia=np.diag(inverse))

    def _moved_mass(self, name: str) -> float:
        """Return the mass [kg] that the drive of an axis moves beside the load: that of a bridge moves the trolley."""
        own = self._axes[name].mass
        mass = (own or 0.0) + (0.0 if name == "trolley" else self.trolley.mass or 0.0)
        if own is None or not mass > 0.0:
            raise SceneError(f"{name}.mass = {own}: a {name} driven by force has one, which must be greater than 0")
        return mass

    def support(self) -> Bridge:
        """Return the parameters of the support.

        Raises:
            SceneError: groups contradict each other.
        """
        return Bridge(*(self._axis(name, axis) for name, axis in self._axes.items()))

    def _axis(self, name: str, axis: AxisGroup) -> BridgeAxis:
        check_shape(f"{name}.motion", axis.motion, axis.drive)
        check_finite(f"{name}.motion", axis.motion)
        check_mass(name, axis, carried=name == "trolley" and self.bridge.drive == "force")
        if axis.drive == "force":
            self._moved_mass(name)
            return BridgeAxis(axis.mass or 0.0, axis.limits)
        for key in ("friction", "lugre", "backlash"):
            if name in getattr(self, key):
                raise SceneError(f"{key}.{name}: belongs to a drive by force, here it is {axis.drive!r}")
        return BridgeAxis(axis.mass or 0.0, axis.limits, Fixed() if axis.motion is None else axis.motion.motion())


class BridgeFile(BridgeGroups, SuspendedFile):
    """A scene with a bridge crane: a trolley on a bridge, a rigid-body payload on rope, hook and sling."""

    crane: Literal["bridge"]  # the kind of crane
    initial: Initial  # the state at t = 0
    reference: ReferenceGroup | None = None  # where the crane should go: `q` without axes that are fixed or prescribed
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints."""
        return self._target("rope")
