"""Between the world and a base that moves in it: what is drawn aboard turns and heaves with the base."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

if TYPE_CHECKING:
    from crane_sim.base_motions import Base, SplineBase
    from crane_sim.recording.layout import Numbers
    from crane_sim.scene import Scene

BASE = "base_link"  # the frame of a base that moves


def base_of(scene: Scene) -> Base | SplineBase | None:
    """Return how the base of a scene's crane moves; not every model can stand on one that does."""
    return getattr(scene.model, "base", None)


def turns(base: Numbers) -> Rotation:
    """Return the turns (K,) of a base whose axes (K, 6) are surge, sway, heave [m], roll, pitch, yaw [rad]."""
    return Rotation.from_euler("ZYX", base[:, :2:-1])


def aboard(points: Numbers, base: Numbers | None) -> Numbers:
    """Return points (K, N, 3) of the world as the base (K, 6) sees them; None is a base that rests."""
    if base is None:
        return points
    return np.einsum("kji,knj->kni", turns(base).as_matrix(), points - base[:, None, :3])


def ashore(points: Numbers, base: Numbers | None) -> Numbers:
    """Return points (K, N, 3) of the base (K, 6) in the world; None is a base that rests."""
    if base is None:
        return points
    return np.einsum("kij,knj->kni", turns(base).as_matrix(), points) + base[:, None, :3]
