"""Workspace of an overhead crane: the bounding box of its rails and its cable."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crane_sim.numerics.jit import LIGHT, entry_point, optimisation
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.overhead import OverheadFile
from crane_sim.simulation.derived import world_points
from crane_sim.trajectories.profiles import Motion, evaluate_motion

Array = NDArray[np.float64]

SAMPLES = 200  # of a prescribed motion
RAIL_OVERHANG = 0.25  # of the depth: overhang of the rail beyond the last node


@entry_point
@optimisation(LIGHT)
def positions(motion, times):
    """Return the positions (n,) of a motion at times (n,) [s]."""
    out = np.empty(len(times))
    for i in range(len(times)):
        out[i] = evaluate_motion(motion, times[i])[0]
    return out


class BoundingBox(NamedTuple):
    """Bounding box in the world [m] of the trolley and all nodes of the cable."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    shortest: float  # m, smallest distance along the cable from trolley to payload
    spatial: bool  # there is a bridge, which moves along y

    @property
    def depth(self) -> float:
        """Return the depth of the box below the rail, to which all visuals are scaled."""
        # a payload above the rail would hang as deep as that
        return max(-self.low[2], self.shortest, 1e-3)

    @property
    def unit(self) -> float:
        """Return the unit length of visuals, which must not hide a payload hoisted up to them."""
        return max(min(self.depth / 6.0, self.shortest), self.depth / 15.0)

    @property
    def floor(self) -> float:
        """Return z of the visual ground; the model has none."""
        return -1.2 * self.depth

    def rail(self, axis: int) -> tuple[float, float]:
        """Return the visual ends of the rail of the trolley (axis 0) or the bridge (axis 1)."""
        overhang = RAIL_OVERHANG * self.depth
        return self.low[axis] - overhang, self.high[axis] + overhang

    def contains(self, low: Array, high: Array) -> bool:
        """Return whether another box is within this one, extended by its rails' overhang."""
        overhang = RAIL_OVERHANG * self.depth
        return bool(
            np.all(low > np.array(self.low) - overhang)
            and np.all(high < np.array(self.high) + overhang)
        )


def make_bounding_box(low: Array, high: Array, shortest: float, spatial: bool) -> BoundingBox:
    """Return the bounding box with corners (3,)."""
    return BoundingBox(_vector(low), _vector(high), shortest, spatial)


def validated_scene_file(scene: Scene) -> OverheadFile:
    """Return the validated file of a scene with an overhead crane, defaults included."""
    assert isinstance(scene.file, OverheadFile)
    return scene.file


def estimate_bounding_box(scene: Scene) -> BoundingBox:
    """Return the bounding box before a run: initial state, target, and the swing about both."""
    file = validated_scene_file(scene)
    nodes, tip_index = world_points(
        _at_rest(scene.model), 0.0, np.array(scene.initial_q), np.array(scene.initial_v)
    )
    links = np.linalg.norm(np.diff(nodes[tip_index:], axis=0), axis=1)
    hoist = file.hoist.profile if file.hoist else None
    first_lengths = [
        float(links[0]),
        *target_of_joint(scene, "hoist"),
        *_motion_positions(scene, hoist.motion() if hoist else None),
    ]
    lower_length = float(links[1:].sum())
    offsets = nodes - nodes[tip_index]
    offsets = np.vstack(
        [offsets, offsets * (-1.0, -1.0, 1.0), (0.0, 0.0, -max(first_lengths) - lower_length)]
    )
    trolleys = [nodes[tip_index]]
    for axis, joint in enumerate(("trolley", "bridge")[: 2 if is_spatial(scene) else 1]):
        for position in axis_positions(scene, joint):
            trolleys.append(np.where(np.arange(3) == axis, position, nodes[tip_index]))
    low, high = (
        np.min(trolleys, axis=0) + offsets.min(axis=0),
        np.max(trolleys, axis=0) + offsets.max(axis=0),
    )
    return make_bounding_box(low, high, min(first_lengths) + lower_length, is_spatial(scene))


def _at_rest(model: Any) -> Any:
    """Return the model on a base at rest, whose points are those relative to the base."""
    return model._replace(base=None) if getattr(model, "base", None) is not None else model


def is_spatial(scene: Scene) -> bool:
    """Return whether the crane has a bridge."""
    return "bridge" in scene.joint_names


def target_of_joint(scene: Scene, joint: str) -> list[float]:
    """Return the target of a joint as a list, empty for a joint without one."""
    if scene.reference is None or joint not in scene.actuated:
        return []
    return [scene.reference[scene.actuated.index(joint)]]


def axis_positions(scene: Scene, joint: str) -> list[float]:
    """Return where a joint begins, should go, and comes to as its drive prescribes [m]."""
    motion = getattr(getattr(scene.file, joint, None), "motion", None)
    moved = _motion_positions(scene, motion.motion() if motion is not None else None)
    return [scene.initial_q[scene.joint_names.index(joint)], *target_of_joint(scene, joint), *moved]


def _motion_positions(scene: Scene, motion: Motion | None) -> list[float]:
    """Return samples of a prescribed motion; empty without one."""
    if motion is None:
        return []
    return [float(x) for x in positions(motion, np.linspace(0.0, scene.duration, SAMPLES))]


def _vector(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
