"""The schema of a scene file with a gantry or ship-to-shore crane, and the model that it describes."""

from typing import Literal

from crane_sim.files.types import Positive, Range, Real
from crane_sim.scenes.schema.bridge import BridgeGroups
from crane_sim.scenes.schema.falls_file import LoadStart
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.hoisted import HoistedFile
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.trajectories.inputs import Constant


class Initial(LoadStart):
    """The state at t = 0; a load whose position is left out hangs at rest below the trolley."""

    trolley: Real = 0.0  # m, position of the trolley
    bridge: Real = 0.0  # m, position of bridge or portal
    length: Positive  # m, unstretched length of the falls
    v: tuple[Real, Real, Real] = (0.0, 0.0, 0.0)  # m/s, of trolley, bridge and length

    @property
    def q(self) -> tuple[float, float, float]:
        """Positions [m] of trolley, bridge and length."""
        return self.trolley, self.bridge, self.length


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    trolley: Channel = Constant(0.0)  # N, force along x
    bridge: Channel = Constant(0.0)  # N, force along y
    hoist: Channel = Constant(0.0)  # effort's unit, as `hoist.drive` says


class GantryFile(BridgeGroups, HoistedFile):
    """A scene with a gantry or ship-to-shore crane: a trolley on a travelling portal, a spreader on elastic falls."""

    crane: Literal["gantry"]  # the kind of crane
    legs: Range | None = None  # m, where its legs stand along the trolley's rail, which only its picture shows; a rail
    # that reaches further beyond them than they are apart is drawn as the boom of a ship-to-shore crane
    initial: Initial  # the state at t = 0
    reference: ReferenceGroup | None = None  # where the crane should go: `q` without axes that are fixed or prescribed
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints."""
        return self._target("hoist")
