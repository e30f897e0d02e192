"""The form of a scene file with a bridge crane whose load hangs on hook and sling, and the model that it describes."""

from typing import ClassVar, Literal

from crane_sim.files.types import Positive, Real, Tilt
from crane_sim.models.supports.bridge import Bridge, DrivenAxis
from crane_sim.scenes.schema.backlash import SupportJoints
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.rigging import RiggingStart
from crane_sim.scenes.schema.suspended import SuspendedFile
from crane_sim.trajectories.inputs import Constant


class Initial(Group):
    """Joint coordinates at t = 0, in joint order."""

    q: tuple[Real, Real, Positive, Tilt, Tilt]  # m, trolley, bridge, rope, swing_tangential [rad], swing_radial [rad]
    v: tuple[Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0)  # m/s, of the same joints; of swings [rad/s]
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class Reference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Real, Real, Positive] | None = None  # m, where trolley, bridge and rope should end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    trolley: Channel = Constant(0.0)  # N, force along x
    bridge: Channel = Constant(0.0)  # N, force along y
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class BridgeFile(SuspendedFile):
    """A scene with a bridge crane: a trolley on a bridge, a payload with a body on rope, hook and sling."""

    support_joints: ClassVar[SupportJoints] = (("trolley", "m", "N"), ("bridge", "m", "N"))
    crane: Literal["bridge"]  # which form the file has
    trolley: DrivenAxis  # along x
    bridge: DrivenAxis  # along y
    initial: Initial  # the state at t = 0
    reference: Reference | None = None  # where the crane should go
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        return limits_of(
            ("trolley", "trolley.limits", self.trolley.limits),
            ("bridge", "bridge.limits", self.bridge.limits),
            ("rope", "rope.limits", self.rope.limits),
        )

    def support(self) -> Bridge:
        """Return the parameters of the support."""
        return Bridge(self.trolley, self.bridge)
