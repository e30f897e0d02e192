"""Bridge crane: a trolley along x on a bridge (or a portal) along y.

    m x'' = F_x + f_x,    (m + M) y'' = F_y + f_y

with the masses m of the trolley, M of the bridge, and the force f of the cable on the trolley,
whose rail is at height
0. The bridge's centre of mass is at x = 0. Each of the two takes a force command, moves as
prescribed, or stays. In the plane there is a trolley alone.
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
        """Return the prescribed acceleration [m/s²] at time t [s]; 0 if fixed or not prescribed."""
        return motion_acceleration(self.motion, t) if isinstance(self.motion, Motion) else 0


class Bridge(NamedTuple):
    """Parameters of the support."""

    trolley: BridgeAxis
    bridge: BridgeAxis | None = None

    @property
    def axes(self) -> tuple[BridgeAxis, ...]:
        """The trolley, and the bridge where there is one: in the order of coordinates."""
        return (self.trolley,) if self.bridge is None else (self.trolley, self.bridge)

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("trolley", "trolley.limits"), ("bridge", "bridge.limits"))[i]

    def mechanism(self) -> Mechanism:
        """Return the joints and bodies: the bridge, and the trolley on it."""
        carried, joints = Body(self.trolley.mass), ()
        if self.bridge is not None:
            joints = (Joint(Y, ((1, 1),), slides=True, bodies=(Body(self.bridge.mass),)),)
        trolley = Joint(X, ((0, 1),), slides=True, parent=len(joints) - 1, bodies=(carried,))
        prescribed = tuple(axis.motion is not None for axis in self.axes)
        return Mechanism(
            Tree((*joints, trolley), Point(len(joints))),
            limits=tuple(axis.limits for axis in self.axes),
            actuated=tuple(i for i, given in enumerate(prescribed) if not given),
            yaw=(),
            prescribed=prescribed if any(prescribed) else (),
        )

    def prescribe(
        self, t: Any, efforts: tuple[Any, ...], q: tuple[Any, ...], v: tuple[Any, ...]
    ) -> tuple[Any, ...]:
        """Return the accelerations (n,) [m/s²] of prescribed motions at time t [s], 0 of others."""
        return tuple(axis.acceleration(t) for axis in self.axes)

    def moves_by_itself(self) -> bool:
        """Return whether the motion of an axis is prescribed and not at rest."""
        return any(isinstance(axis.motion, Motion) for axis in self.axes)
