"""The schema of a scene file with a load on elastic falls below a driven suspension point."""

from typing import Any, Literal

import numpy as np

from crane_sim.files.types import Positive
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.supports.support import Support
from crane_sim.scenes.schema.falls_file import PLACE, FallsFile, LoadStart
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.pendulum import PendulumGroups, TipStart
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.scenes.schema.supported import Tip


class Initial(TipStart, LoadStart):
    """The suspension point and the load at t = 0, which hangs at rest where its position is left out."""

    length: Positive  # m, unstretched length of the falls, which stays


class PendulumFallsFile(PendulumGroups, FallsFile):
    """A scene with a load on elastic falls below a driven suspension point, whose axes are those of the base."""

    crane: Literal["pendulum"]  # the kind of crane
    initial: Initial  # the state at t = 0

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: coordinates of the suspension point, the load's position and attitude."""
        return "tip_x", "tip_y", "tip_z", *PLACE, *ATTITUDE

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions."""
        return (*("m",) * 6, *("1",) * 4)

    @property
    def _driven_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of the suspension point at t = 0."""
        return self._point

    @property
    def _length(self) -> float:
        """Unstretched length [m] of the falls."""
        return self.initial.length

    @property
    def _load_start(self) -> LoadStart:
        """The load at t = 0."""
        return self.initial

    def tip(self, q: Any) -> Tip:
        """Return where the suspension point is at its position q."""
        return Tip((q[0], q[1], q[2]))

    def tip_mobility(self) -> Any:
        """Return the tip's mobility (4, 4): none, since no force moves it."""
        return np.zeros((4, 4))

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return (*self._point[0], *self._load_q)

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return (*self._point[1], *self._load_v)

    def rest_positions(self, target: tuple[float, ...]) -> tuple[float, ...]:
        """Return the joint positions (nq,) of the crane at rest at a target of the actuated joints (nu,)."""
        at = (*target, *self.initial.tip[len(target) :])
        return (*at, *self._rest_pose(at, self._length, None))

    def method_requirements(self, sampled: bool) -> MethodRequirements:
        """Return the scene's requirements on its method."""
        return self._requirements(None, 0.0)

    def model(self) -> FallsCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        return self.falls_crane(Support(self.suspension.point()), None, None, ())
