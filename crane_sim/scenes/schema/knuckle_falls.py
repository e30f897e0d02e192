"""The schema of a scene file with a knuckle-boom crane whose jib carries a load on elastic falls."""

from typing import Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, Positive, Real
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.scenes.schema.falls_file import LoadStart
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.hoisted import HoistedFile
from crane_sim.scenes.schema.knuckle import KnuckleGroups
from crane_sim.trajectories.inputs import Constant


class Initial(LoadStart):
    """The state at t = 0: joint coordinates, and the load, which hangs at rest where its position is left out."""

    q: tuple[Angle, Angle, Angle, Positive]  # rad, slew, boom, jib, hoist [m]
    v: tuple[Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0)  # rad/s, of the same joints; of the hoist [m/s]


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    slew: Channel = Constant(0.0)  # N m, torque about the vertical
    boom: Channel = Constant(0.0)  # N m, torque on the elevation
    jib: Channel = Constant(0.0)  # N m, torque on the elevation
    hoist: Channel = Constant(0.0)  # effort's unit, as `hoist.drive` says


class KnuckleFallsFile(KnuckleGroups, HoistedFile):
    """A scene with a knuckle-boom crane whose jib carries a load on elastic falls."""

    crane: Literal["knuckle"]  # the kind of crane
    initial: Initial  # the state at t = 0
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    def model(self) -> FallsCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        if self.springs.rope is not None:
            raise SceneError("springs.rope: belongs to one rope and a point mass, here is falls; leave out one of both")
        return super().model()
