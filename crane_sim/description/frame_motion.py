"""Motions of a crane's frames in the world, along its URDF: pose, velocity, angular velocity.

A child frame at the offset d in a parent frame with rotation matrix R, velocity v and angular
velocity w has

    v_c = v + w × R d + R d',    w_c = w + R w_rel,

where w_rel is its angular velocity relative to the parent, in the parent's axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crane_sim.description.rotations import rotation_matrices
from crane_sim.description.transforms import (
    BASE,
    WORLD,
    RelativeMotion,
    TransformTree,
    base_transform,
)
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.base_state import base_state

Array = NDArray[np.float64]

# s, of central differences: truncation errors are of its square, 1e-8, and rounding is 1e-11
DIFFERENCE_STEP = 1e-4


class FrameMotion(NamedTuple):
    """Motion of a frame in the axes of the world."""

    position: Array  # (3,) m
    rotation: Array  # (3, 3), takes vectors of the frame to the world
    velocity: Array  # (3,) m/s
    angular_velocity: Array  # (3,) rad/s


class FrameAcceleration(NamedTuple):
    """Acceleration of a frame in the axes of the world."""

    linear: Array  # (3,) m/s²
    angular: Array  # (3,) rad/s²


def frame_motions(
    scene: Scene, tree: TransformTree, t: float, q: Sequence[float], v: Sequence[float]
) -> dict[str, FrameMotion]:
    """Return all frames' motions but `world`'s at time t [s], positions q, velocities v (nq,)."""
    relative = tree.motions(q, v)
    if getattr(scene.model, "base", None) is not None:
        base = base_state(scene, t)
        rotation = base.rotation
        relative.append(
            RelativeMotion(
                base_transform(base), rotation @ base.velocity, rotation @ base.angular_velocity
            )
        )
    return _chain_motions(relative, WORLD)


def frame_accelerations(
    scene: Scene,
    tree: TransformTree,
    t: float,
    q: Sequence[float],
    v: Sequence[float],
    a: Sequence[float],
) -> dict[str, FrameAcceleration]:
    """Return the accelerations of all frames but `world`, by central differences of velocities.

    The differences are along the motion.

    Args:
        scene, tree: crane, and its URDF's tree of frames.
        t: s.
        q, v, a: joint positions, velocities and accelerations (nq,).
    """
    position, velocity, acceleration, s = np.array(q), np.array(v), np.array(a), DIFFERENCE_STEP

    def motions_after(h: float) -> dict[str, FrameMotion]:
        moved = position + h * (velocity + 0.5 * h * acceleration)
        return frame_motions(
            scene, tree, t + h, moved.tolist(), (velocity + h * acceleration).tolist()
        )

    before, after = motions_after(-s), motions_after(s)
    return {
        frame: FrameAcceleration(
            (after[frame].velocity - before[frame].velocity) / (2.0 * s),
            (after[frame].angular_velocity - before[frame].angular_velocity) / (2.0 * s),
        )
        for frame in before
    }


def frame_motions_in_base(
    tree: TransformTree, q: Sequence[float], v: Sequence[float]
) -> dict[str, FrameMotion]:
    """Return the motions of all frames relative to the base, in its axes.

    The joint positions q and velocities v are (nq,).
    """
    return _chain_motions(tree.motions(q, v), BASE)


def _chain_motions(relative: Sequence[RelativeMotion], root: str) -> dict[str, FrameMotion]:
    """Return the motions of all frames below `root`, relative to it and in its axes."""
    above = {
        motion.transform.child: motion for motion in relative if motion.transform.child != root
    }
    found = {root: FrameMotion(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))}

    for frame in above:
        path = []  # up to a frame that is known, in a loop: a cable has up to 500 links
        while frame not in found:
            path.append(frame)
            frame = above[frame].transform.parent
        for each in reversed(path):
            found[each] = _compose(found[above[each].transform.parent], above[each])
    del found[root]
    return found


def _compose(parent: FrameMotion, child: RelativeMotion) -> FrameMotion:
    rotation, offset = parent.rotation, parent.rotation @ np.array(child.transform.translation)
    return FrameMotion(
        parent.position + offset,
        rotation @ rotation_matrices(np.array([child.transform.rotation]))[0],
        parent.velocity + np.cross(parent.angular_velocity, offset) + rotation @ child.velocity,
        parent.angular_velocity + rotation @ child.angular_velocity,
    )
