"""The schema of a scene file with a bridge crane whose load hangs on hook and sling, and the model it describes."""

from typing import Any, ClassVar, Literal

import numpy as np

from crane_sim.files.types import Positive, Range, Real, Tilt
from crane_sim.models.supports.bridge import Bridge, BridgeAxis
from crane_sim.scenes.schema.backlash import SupportJoints
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.rigging import RiggingStart
from crane_sim.scenes.schema.supported import JointMobility, SupportedFile, Tip
from crane_sim.scenes.schema.suspended import SuspendedFile
from crane_sim.trajectories.inputs import Constant


class DrivenAxis(Group):
    """A trolley or a bridge that takes a force command."""

    mass: Positive  # kg, that moves with it, the trolley's apart from the bridge's
    limits: Range | None = None  # m, of its position; a run ends where one is reached


class Initial(Group):
    """Joint coordinates at t = 0, in joint order."""

    q: tuple[Real, Real, Positive, Tilt, Tilt]  # m, trolley, bridge, rope, swing_tangential [rad], swing_radial [rad]
    v: tuple[Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0)  # m/s, of the same joints; of swings [rad/s]
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class BridgeReference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Real, Real, Positive] | None = None  # m, where trolley, bridge and rope should end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    trolley: Channel = Constant(0.0)  # N, force along x
    bridge: Channel = Constant(0.0)  # N, force along y
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class BridgeGroups(SupportedFile):
    """The groups of a trolley on a bridge or portal."""

    support_joints: ClassVar[SupportJoints] = (("trolley", "m", "N"), ("bridge", "m", "N"))
    trolley: DrivenAxis  # along x
    bridge: DrivenAxis  # along y

    @property
    def support_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the support's joints that have some."""
        return limits_of(
            ("trolley", "trolley.limits", self.trolley.limits), ("bridge", "bridge.limits", self.bridge.limits)
        )

    def _tip_radius_and_height(self, q: Any, bend: float) -> tuple[float, float]:
        """Raise NotImplementedError: the tip, a trolley on a bridge, has x and y, no radius about a slew."""
        raise NotImplementedError

    def tip(self, q: Any) -> Tip:
        """Return where the trolley is at joint positions q."""
        return Tip((q[0], q[1], 0.0))

    def joint_mobility(self) -> JointMobility:
        """Return the mobility of trolley and bridge."""
        masses = [self.trolley.mass, self.trolley.mass + self.bridge.mass]
        return JointMobility(jacobian_t=np.eye(2, 4), inverse_inertia=np.diag([1.0 / mass for mass in masses]))

    def support(self) -> Bridge:
        """Return the parameters of the support."""
        return Bridge(*(BridgeAxis(axis.mass, axis.limits) for axis in (self.trolley, self.bridge)))


class BridgeFile(BridgeGroups, SuspendedFile):
    """A scene with a bridge crane: a trolley on a bridge, a rigid-body payload on rope, hook and sling."""

    crane: Literal["bridge"]  # the kind of crane
    initial: Initial  # the state at t = 0
    reference: BridgeReference | None = None  # where the crane should go
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law
