"""The schema of a scene file with a mobile crane whose boom carries a load on elastic falls."""

from typing import Literal

from crane_sim.files.types import Angle, Positive, Real
from crane_sim.scenes.schema.falls_file import LoadStart
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.hoisted import HoistedFile
from crane_sim.scenes.schema.mobile import MobileGroups
from crane_sim.trajectories.inputs import Constant


class Initial(LoadStart):
    """The state at t = 0: joint coordinates, and the load, which hangs at rest where its position is left out."""

    q: tuple[Angle, Angle, Positive, Positive]  # rad, slew, boom, telescope [m], hoist [m]
    v: tuple[Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0)  # rad/s, of the same joints; of telescope and hoist [m/s]


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    slew: Channel = Constant(0.0)  # N m, torque about the vertical
    boom: Channel = Constant(0.0)  # N m, torque on the elevation
    telescope: Channel = Constant(0.0)  # N, force along the boom, outwards
    hoist: Channel = Constant(0.0)  # effort's unit, as `hoist.drive` says


class MobileFallsFile(MobileGroups, HoistedFile):
    """A scene with a mobile crane whose boom carries a load on elastic falls."""

    crane: Literal["mobile"]  # the kind of crane
    initial: Initial  # the state at t = 0
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law
