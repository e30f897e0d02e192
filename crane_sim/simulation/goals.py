"""Where the payload should be, in the base frame: on the scene's path, or at rest at the target."""

from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.flexibility import DEFLECTION
from crane_sim.simulation.derived import in_base, world_points
from crane_sim.simulation.linearisation import equilibrium, hanging_positions, without_dry_friction

Array = npt.NDArray[np.float64]


def follows_path(scene: Scene) -> bool:
    """Return whether the scene has a path of the payload."""
    return scene.trajectory is not None and not scene.trajectory.of_joints


def target_position(scene: Scene) -> Array:
    """Return the payload's position (1, 3) [m] at rest at the joints' target, in the base frame.

    Of cranes that bend or have an elastic cable it is their rest under the means of what disturbs
    them, steady wind included; of all others the payload is straight below the tip, without wind.

    Raises:
        SceneError: the crane bends or its cable is elastic, and nothing holds it at rest there.
    """
    assert scene.reference is not None, "the caller has a scene with a target"
    # deflections and the lengths of an elastic cable are part of the solution
    bends = any(name.startswith("node_") or name.endswith(DEFLECTION) for name in scene.joint_names)
    q = (
        equilibrium(without_dry_friction(scene))[0]
        if bends
        else hanging_positions(scene, scene.reference)
    )
    nodes, _ = world_points(scene.model, 0.0, q, np.zeros_like(q))
    return express_in_base(scene.model, np.zeros(1), nodes[-1:])


def express_in_base(model: Any, t: Array, points: Array) -> Array:
    """Return points of the world (K, 3) [m] at times t (K,) [s] in the axes of the base."""
    base = getattr(model, "base", None)
    return points if base is None else in_base(base, t, points)
