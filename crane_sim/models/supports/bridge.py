"""Bridge crane: a trolley along x on a bridge (or a portal) along y, both driven by force.

    m x'' = F_x + f_x,    (m + M) y'' = F_y + f_y

with the masses m of the trolley, M of the bridge, and the force f of the cable on the trolley, whose rail is at height
0. The bridge's centre of mass is at x = 0.
"""

from typing import NamedTuple

from crane_sim.files.types import Positive, Range
from crane_sim.models.supports.support import Mechanism
from crane_sim.multibody.tree import Body, Joint, Point, Tree, X, Y


class DrivenAxis(NamedTuple):
    """A trolley or a bridge that takes a force command."""

    mass: Positive  # kg, that moves with it, the trolley's apart from the bridge's
    limits: Range | None = None  # m, of its position; a run ends where one is reached


class Bridge(NamedTuple):
    """Parameters of the support."""

    trolley: DrivenAxis
    bridge: DrivenAxis

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("trolley", "trolley.limits"), ("bridge", "bridge.limits"))[i]

    def mechanism(self) -> Mechanism:
        """Return the joints and bodies: the bridge, and the trolley on it."""
        bridge = Joint(Y, ((1, 1),), slides=True, bodies=(Body(self.bridge.mass),))
        trolley = Joint(X, ((0, 1),), slides=True, parent=0, bodies=(Body(self.trolley.mass),))
        limits = self.trolley.limits, self.bridge.limits
        return Mechanism(Tree((bridge, trolley), Point(1)), limits, actuated=(0, 1), yaw=())
