"""Motions of a crane's frames in the world: pose, velocity and angular velocity, along the tree of its URDF.

A child at d with the turn R_c in its parent, which has the turn R and the velocities v, w, has

    v_c = v + w × R d + R d',    w_c = w + R w_rel.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.description.transforms import BASE, WORLD, RelativeMotion, Transform, TransformTree, base_transform
from crane_sim.simulation.base_state import base_state

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from crane_sim.scenes.scene import Scene

    Numbers = NDArray[np.float64]

DIFFERENCE_STEP = 1e-4  # s: rounding leaves 1e-11 of an acceleration, and the square of the step is 1e-8


class FrameMotion(NamedTuple):
    """Motion of a frame in the axes of the world."""

    position: Numbers  # (3,) m
    rotation: Numbers  # (3, 3), takes vectors of the frame to the world
    velocity: Numbers  # (3,) m/s
    angular_velocity: Numbers  # (3,) rad/s


class FrameAcceleration(NamedTuple):
    """Acceleration of a frame in the axes of the world."""

    linear: Numbers  # (3,) m/s²
    angular: Numbers  # (3,) rad/s²


def frame_motions(
    scene: Scene, tree: TransformTree, t: float, q: Sequence[float], v: Sequence[float]
) -> dict[str, FrameMotion]:
    """Return the motions of all frames but `world` at time t [s] and joint positions and rates (nq,)."""
    relative = tree.motions(q, v)
    if getattr(scene.model, "base", None) is not None:
        base = base_state(scene, t)
        turn = base.rotation
        relative.append(RelativeMotion(base_transform(base), turn @ base.velocity, turn @ base.angular_velocity))
    return _chain_motions(relative, WORLD)


def frame_accelerations(
    scene: Scene, tree: TransformTree, t: float, q: Sequence[float], v: Sequence[float], a: Sequence[float]
) -> dict[str, FrameAcceleration]:
    """Return the accelerations of all frames but `world` at time t [s]; q, v, a (nq,): joints, rates and their rates.

    Central differences of the velocities along the motion.
    """
    position, rate, change, s = np.array(q), np.array(v), np.array(a), DIFFERENCE_STEP

    def motions_after(h: float) -> dict[str, FrameMotion]:
        moved = position + h * (rate + 0.5 * h * change)
        return frame_motions(scene, tree, t + h, moved.tolist(), (rate + h * change).tolist())

    before, after = motions_after(-s), motions_after(s)
    return {
        frame: FrameAcceleration(
            (after[frame].velocity - before[frame].velocity) / (2.0 * s),
            (after[frame].angular_velocity - before[frame].angular_velocity) / (2.0 * s),
        )
        for frame in before
    }


def frame_motions_in_base(tree: TransformTree, q: Sequence[float], v: Sequence[float]) -> dict[str, FrameMotion]:
    """Return the motions of all frames relative to the base, in its axes, at joint positions and rates (nq,)."""
    return _chain_motions(tree.motions(q, v), BASE)


def _chain_motions(relative: Sequence[RelativeMotion], root: str) -> dict[str, FrameMotion]:
    """Return the motions in a frame of all that are below it."""
    above = {motion.transform.child: motion for motion in relative if motion.transform.child != root}
    found = {root: FrameMotion(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))}

    def motion_of(frame: str) -> FrameMotion:
        if frame not in found:
            found[frame] = _compose(motion_of(above[frame].transform.parent), above[frame])
        return found[frame]

    for frame in above:
        motion_of(frame)
    del found[root]
    return found


def _compose(parent: FrameMotion, child: RelativeMotion) -> FrameMotion:
    turn, lever = parent.rotation, parent.rotation @ np.array(child.transform.translation)
    return FrameMotion(
        parent.position + lever,
        turn @ _rotation(child.transform),
        parent.velocity + np.cross(parent.angular_velocity, lever) + turn @ child.velocity,
        parent.angular_velocity + turn @ child.angular_velocity,
    )


def _rotation(transform: Transform) -> Numbers:
    """Return the matrix (3, 3) of a transform's unit quaternion."""
    x, y, z, w = transform.rotation
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
