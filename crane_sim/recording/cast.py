"""What every crane on the stage has in common: frames, levers, the turn of a rope."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

if TYPE_CHECKING:
    import rerun as rr
    from numpy.typing import NDArray

    from crane_sim.recording.framing import Framing
    from crane_sim.recording.layout import Numbers

Vector = tuple[float, float, float]
WORLD = "world"  # the frame of everything that is not part of the crane
ROPE = (214, 219, 226)
STRAND = 0.0035  # radius of a rope, of the crane's size


class Lever(NamedTuple):
    """Where an effort pushes: origin, in sizes of the crane, and unit vector of a positive one, in a frame."""

    frame: str
    origin: Vector
    direction: Vector


class Cast(Protocol):
    """A crane that is drawn."""

    def lever(self, joint: str) -> Lever:
        """Return where the effort of an actuated joint pushes."""
        ...

    def dress(self, size: float) -> None:
        """Log what depends on the crane's size [m] and does not move."""

    def move(self, time: list[rr.TimeColumn], q: Numbers, nodes: Numbers) -> Framing | None:
        """Add frames with coordinates (F, nq) and, in the frame that the crane stands in, nodes (F, N, 3).

        Return a new framing where the old one is outgrown.
        """
        ...

    def settle(self) -> Framing | None:
        """Fit what stands still to the whole motion; return how to look at it, None if that is as before."""
        ...


def turn_from_z(direction: Numbers) -> NDArray[np.float64]:
    """Return unit quaternions (xyzw) that turn the z axis into the directions (n, 3); zero vectors give no turn."""
    unit = direction / np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-12)
    x, y, z = unit.T
    # half-way form of the shortest arc; straight down has no unique arc, the half turn about x is taken
    quaternion = np.column_stack([-y, x, np.zeros_like(z), 1.0 + z])
    quaternion[z < -1.0 + 1e-12] = (1.0, 0.0, 0.0, 0.0)
    return quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)
