"""Between the world and a base that moves in it: solids of the crane move with the base."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from crane_sim.recording.rotations import quaternions_of
from crane_sim.trajectories.base_motion import rotations

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.scenes.scene import Scene
    from crane_sim.trajectories.base_motion import AnyBase

    Array = NDArray[np.float64]

WORLD = "world"  # the frame of everything that is not part of the crane


BASE = "base_link"  # the frame of a base that moves


def base_of(scene: Scene) -> AnyBase | None:
    """Return how the base of a scene's crane moves; not every model can stand on one that does."""
    return getattr(scene.model, "base", None)


def base_quaternions(base: Array) -> Array:
    """Return the quaternions (K, 4), x y z w, of a base (K, 6): surge, sway, heave [m], roll, pitch, yaw [rad]."""
    return quaternions_of(*base[:, 3:].T)


def base_rotations(base: Array) -> Array:
    """Return the rotation matrices (K, 3, 3) of a base (K, 6), from its axes to the world's."""
    return rotations(base[:, 3:])


def to_base(points: Array, base: Array | None) -> Array:
    """Return points (K, N, 3) of the world in the axes of the base (K, 6); None is a fixed base."""
    if base is None:
        return points
    return np.einsum("kji,knj->kni", base_rotations(base), points - base[:, None, :3])


def to_world(points: Array, base: Array | None) -> Array:
    """Return points (K, N, 3) of the base (K, 6) in the world; None is a fixed base."""
    if base is None:
        return points
    return np.einsum("kij,knj->kni", base_rotations(base), points) + base[:, None, :3]
