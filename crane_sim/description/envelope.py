"""The room that an overhead crane needs, guessed before it moves: the length of its rail, the height of its gantry."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.cables.chain import PrescribedHoist
from crane_sim.motions import position_at
from crane_sim.sources import Inputs, value_at
from crane_sim.supports.trolley import ForceTrolley, PrescribedTrolley

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.overhead import OverheadCrane
    from crane_sim.scene import Scene

SAMPLES = 500
LONGEST = 8.0  # cable lengths: a rail that a run-away trolley would need is not drawn


class Envelope(NamedTuple):
    """World coordinates [m]; the model itself knows no rail ends and no ground."""

    left: float  # x of the rail's ends
    right: float
    reach: float  # length of the longest cable
    ground: float  # z

    @property
    def middle(self) -> float:
        """Return x of the rail's middle."""
        return 0.5 * (self.left + self.right)

    @property
    def span(self) -> float:
        """Return the rail's length."""
        return self.right - self.left


def envelope(scene: Scene, crane: OverheadCrane) -> Envelope:
    """Return the room for a scene's run."""
    times = np.linspace(0.0, scene.duration, SAMPLES)
    first = _ends(scene, "hoist") or [crane.cable.lengths[0]]
    if isinstance(crane.hoist, PrescribedHoist):
        first = [position_at(crane.hoist.profile, t)[0] for t in times]
    reach = float(max(first) + np.sum(crane.cable.lengths[1:]))
    places = np.clip(_places(scene, crane, times) - scene.initial_q[0], -LONGEST * reach, LONGEST * reach)
    left, right = scene.initial_q[0] + places.min(), scene.initial_q[0] + places.max()
    return Envelope(float(left - 0.4 * reach), float(right + 0.4 * reach), reach, -1.2 * reach)


def _places(scene: Scene, crane: OverheadCrane, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where the trolley will be about, in no order."""
    trolley = crane.trolley
    if isinstance(trolley, PrescribedTrolley):
        return np.array([position_at(trolley.motion, t)[0] for t in times])
    if not (isinstance(trolley, ForceTrolley) and isinstance(scene.source, Inputs)):
        return np.array(_ends(scene, "trolley"))
    # under an open-loop force the cable swings about where trolley and cable as one body would go
    force = np.array([value_at(scene.source.first, t) for t in times])
    rate = scene.initial_v[0] + np.cumsum(force) * times[1] / (trolley.mass + np.sum(crane.cable.masses))
    return scene.initial_q[0] + np.cumsum(rate) * times[1]


def _ends(scene: Scene, joint: str) -> list[float]:
    """Return where a joint starts and, if there is a reference for it, where it is to go; nothing for no joint."""
    if joint not in scene.joint_names:
        return []
    ends = [scene.initial_q[scene.joint_names.index(joint)]]
    if scene.reference is not None and joint in scene.actuated:
        ends.append(scene.reference[scene.actuated.index(joint)])
    return ends
