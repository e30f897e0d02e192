"""Bridge crane: a trolley along x on a bridge (or a portal) along y.

    m x'' = F_x + f_x,    (m + M) y'' = F_y + f_y

with the masses m of the trolley, M of the bridge, and the force f of the cable on the trolley, whose rail is at height
0. The bridge's centre of mass is at x = 0. Each of the two takes a force command, moves as prescribed, or stays.
"""

from typing import Any, NamedTuple

from crane_sim.models.supports.support import Mechanism
from crane_sim.multibody.tree import Body, Joint, Point, Tree, X, Y
from crane_sim.trajectories.profiles import Motion, motion_acceleration


class Fixed(NamedTuple):
    """The presence of a brake that holds an axis where it is."""


class BridgeAxis(NamedTuple):
    """A trolley or a bridge."""

    mass: float  # kg, that moves with it, the trolley's apart from the bridge's
    limits: tuple[float, float] | None = None  # m, of its position; a run ends where one is reached
    motion: Motion | Fixed | None = None  # m, whatever pulls; None: it takes a force command

    def acceleration(self, t: Any) -> Any:
        """Return the acceleration [m/s²] of its motion at time t [s], 0 of one that is fixed, or not prescribed."""
        return motion_acceleration(self.motion, t) if isinstance(self.motion, Motion) else 0


class Bridge(NamedTuple):
    """Parameters of the support."""

    trolley: BridgeAxis
    bridge: BridgeAxis

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("trolley", "trolley.limits"), ("bridge", "bridge.limits"))[i]

    def mechanism(self) -> Mechanism:
        """Return the joints and bodies: the bridge, and the trolley on it."""
        bridge = Joint(Y, ((1, 1),), slides=True, bodies=(Body(self.bridge.mass),))
        trolley = Joint(X, ((0, 1),), slides=True, parent=0, bodies=(Body(self.trolley.mass),))
        limits, prescribed = tuple(axis.limits for axis in self), tuple(axis.motion is not None for axis in self)
        actuated = tuple(i for i in range(2) if not prescribed[i])
        return Mechanism(
            Tree((bridge, trolley), Point(1)),
            limits,
            actuated,
            yaw=(),
            prescribed=prescribed if any(prescribed) else (),
        )

    def prescribe(self, t: Any, efforts: tuple[Any, ...], q: tuple[Any, ...], v: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return the accelerations (2,) [m/s²] of prescribed motions at time t [s], 0 of others."""
        return self.trolley.acceleration(t), self.bridge.acceleration(t)

    def moves_by_itself(self) -> bool:
        """Return whether the motion of an axis is prescribed and not at rest."""
        return any(isinstance(axis.motion, Motion) for axis in self)
