"""Between the world and a base that moves in it: solids of the crane move with the base.

Rotations of many instants at once are arrays: scipy's would take a seventh of a recorder's start to
import.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from crane_sim.description.rotations import quaternions_of, rotation_matrices, rotations_about_z
from crane_sim.models.falls.crane import Falls
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.trajectories.base_motion import AnyBase, rotations

Array = NDArray[np.float64]


def base_of(scene: Scene) -> AnyBase | None:
    """Return how the base of a scene's crane moves; not every model can stand on one that does."""
    return getattr(scene.model, "base", None)


def base_quaternions(base: Array) -> Array:
    """Return quaternions (K, 4), x y z w, of a base (K, 6).

    The base is surge, sway, heave [m], roll, pitch, yaw [rad].
    """
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


def fall_ends(falls: Falls, values: Mapping[str, Array], tip: Array) -> tuple[Array, Array]:
    """Return both ends (F, n, 3) of falls, relative to the base.

    Args:
        falls: the parameters.
        values: joint coordinates (F,) by name.
        tip: (F, 3) m, of the support, relative to the base.
    """
    yaw = sum(
        (values[name] for name in ("slew", "lateral_deflection") if name in values),
        np.zeros(len(tip)),
    )
    turns = rotations_about_z(yaw)
    load = np.column_stack([values[f"payload_{axis}"] for axis in "xyz"])
    attitude = np.column_stack([values[name] for name in ATTITUDE])
    rows = rotation_matrices(np.roll(attitude, -1, axis=1))
    tops = tip[:, None] + np.einsum("kij,nj->kni", turns, falls.top)
    return tops, load[:, None] + np.einsum("kij,nj->kni", rows, falls.bottom)
