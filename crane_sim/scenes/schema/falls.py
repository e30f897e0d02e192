"""The group `falls` of a scene file: elastic ropes between trolley and spreader, and where the load hangs at rest."""

from typing import Annotated, Any

import numpy as np
from pydantic import Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.models.falls.crane import Falls
from crane_sim.models.loads import RigidLoad
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.rigging import Vector

Ends = Annotated[tuple[Vector, ...], Field(min_length=1, max_length=100)]
TRIALS, CLOSE = 50, 1e-12
"""Steps of Newton's method for the load at rest, and its relative residual."""


class FallsGroup(Group):
    """Elastic falls, each from a point of the trolley to one of the spreader; they only pull."""

    top: Ends  # m, upper ends, from the trolley, in the axes of the base
    bottom: Ends  # m, lower ends, from the spreader's origin, in its axes
    offsets: tuple[Real, ...] | None = None  # m, added to the length of each fall: what skews, trims or lists the load
    axial_stiffness: Positive  # N, E A of one rope
    parts: Annotated[int, Field(ge=1, le=100)] = 1  # -, of the rope in one fall, which share its tension
    relaxation: NonNegative = 0.0  # s, damping: T = (E A / L) (e + relaxation × rate of e)

    def falls(self, length: float, load: RigidLoad) -> Falls:
        """Return the falls with an unstretched length [m], lower ends from the load's centre of mass.

        Raises:
            SceneError: numbers of falls disagree, or offsets leave a fall no length.
        """
        n = len(self.top)
        offsets = self.offsets if self.offsets is not None else (0.0,) * n
        for key, rows in (("bottom", self.bottom), ("offsets", offsets)):
            if len(rows) != n:
                raise SceneError(f"falls.{key}: has {len(rows)} entries, falls.top has {n}")
        if not length + min(offsets) > 0.0:
            raise SceneError(f"falls.offsets = {list(offsets)}: leave no length of {length:g} m")
        bottom = np.array(self.bottom, dtype=float) + np.array(load.attachment)
        stiffness, relaxation = np.full(n, self.axial_stiffness * self.parts), np.full(n, self.relaxation)
        return Falls(np.array(self.top, dtype=float), bottom, length, np.array(offsets), stiffness, relaxation)


def load_at_rest(falls: Falls, load: RigidLoad, gravity: float, yaw: float | None) -> Any:
    """Return (x, y, z) [m] of the load's centre from the trolley at rest and its attitude (w, x, y, z).

    Args:
        falls, load: the parameters; the falls' length is their unstretched one.
        gravity: m/s².
        yaw: angle [rad] about the vertical at which the load is held; None: it hangs free.

    Raises:
        SceneError: no position of rest was found.
    """
    depth = falls.length + float(np.mean(falls.offset) - np.mean(falls.top[:, 2]) + np.mean(falls.bottom[:, 2]))
    aside = (falls.top - falls.bottom).mean(axis=0)
    y = np.array([aside[0], aside[1], -depth, 0.0, 0.0, yaw or 0.0])
    free, step = 5 if yaw is not None else 6, 1e-6
    for _ in range(TRIALS):
        residual = _loads(falls, load, gravity, y)[:free]
        rounding = 1e-14 * float(falls.axial_stiffness.max())
        if np.abs(residual).max() <= CLOSE * load.mass * gravity * max(1.0, depth) + rounding:
            return y[:3], _quaternion(y[3:])
        ahead = np.array([_loads(falls, load, gravity, y + h)[:free] for h in step * np.eye(6)[:free]])
        behind = np.array([_loads(falls, load, gravity, y - h)[:free] for h in step * np.eye(6)[:free]])
        move = np.linalg.lstsq((ahead - behind).T / (2.0 * step), -residual, rcond=1e-12)[0]
        y[:free] += np.clip(move, -0.5, 0.5)
    raise SceneError("falls: no position of rest was found; give initial.position and initial.orientation")


def _loads(falls: Falls, load: RigidLoad, gravity: float, y: Any) -> Any:
    """Return force [N] and moment [N m] (6,) on a load at (x, y, z) with rotation angles (roll, pitch, yaw)."""
    rotation = _rotation(_quaternion(y[3:]))
    arms = falls.bottom @ rotation.T
    apart = falls.top - (y[:3] + arms)
    distance, rest = np.linalg.norm(apart, axis=1), falls.length + falls.offset
    tension = np.maximum(falls.axial_stiffness / rest * (distance - rest), 0.0)
    pulls = tension[:, None] * apart / distance[:, None]
    force = pulls.sum(0) - np.array([0.0, 0.0, load.mass * gravity])
    return np.concatenate([force, np.cross(arms, pulls).sum(0)])


def _quaternion(angles: Any) -> Any:
    """Return the unit quaternion (w, x, y, z) of Rz(yaw) Ry(pitch) Rx(roll)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(0.5 * angles), np.cos(0.5 * angles)
    vector = (cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr)
    return np.array([cy * cp * cr + sy * sp * sr, *vector])


def _rotation(q: Any) -> Any:
    """Return the rotation matrix (3, 3) of a unit quaternion."""
    w, x, y, z = q
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
