"""The motion of a scene's base at one instant, and what an accelerometer on it measures."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.models.moving_base import base_kinematics_at, pose_at
from crane_sim.numerics.jit import NONE, entry_point, optimisation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.scenes.scene import Scene

    Array = NDArray[np.float64]


class BaseState(NamedTuple):
    """Motion of the base's origin; vectors but the position are in the axes of the base."""

    rotation: Array  # (3, 3), takes vectors of the base to the world
    position: Array  # (3,) m, in the world
    velocity: Array  # (3,) m/s
    angular_velocity: Array  # (3,) rad/s
    specific_force: Array  # (3,) m/s², acceleration less gravity: what an accelerometer shows
    angular_acceleration: Array  # (3,) rad/s²


@entry_point
@optimisation(NONE)
def fill_base_state(base, gravity, t, out):
    """Fill out (8, 3) with the fields of `BaseState`, in order, of a moving base at time t [s]."""
    pose, motion = pose_at(base, t), base_kinematics_at(base, gravity, t)
    out[:3], out[3], out[4] = pose.rows, pose.origin, motion.velocity
    out[5], out[7] = motion.angular_velocity, motion.angular_acceleration
    out[6] = tuple([-x for x in motion.imposed])
    out[6, 2] += gravity  # `imposed` is without it


def base_state(scene: Scene, t: float) -> BaseState:
    """Return the motion of a scene's base at time t [s]; a resting one is at the world's origin."""
    base, gravity = getattr(scene.model, "base", None), float(scene.model.gravity)
    rows = np.zeros((8, 3))
    if base is None:
        rows[:3], rows[6, 2] = np.eye(3), gravity
    else:
        fill_base_state(base, gravity, t, rows)
    return BaseState(rows[:3], *rows[3:])
