"""The group `falls` of a scene file: elastic ropes between trolley and spreader, and where the load hangs at rest."""

from math import cos, sin
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.models.contact.surface import CompliantContact
from crane_sim.models.falls.crane import Falls
from crane_sim.models.loads import RigidLoad
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.rigging import Vector

Ends = Annotated[tuple[Vector, ...], Field(min_length=1, max_length=100)]
TRIALS, CLOSE, DECIMALS = 50, 1e-12, 10
"""Steps of Newton's method for the load at rest, its relative residual, and the decimals [m, rad] of its result.

Rounded so that a run begins with the same bits on every machine: LAPACK's last digits differ by processor.
"""


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
            y = np.round(y, DECIMALS) + 0.0  # no negative zero
            return y[:3], _quaternion(y[3:])
        ahead = np.array([_loads(falls, load, gravity, y + h)[:free] for h in step * np.eye(6)[:free]])
        behind = np.array([_loads(falls, load, gravity, y - h)[:free] for h in step * np.eye(6)[:free]])
        move = np.linalg.lstsq((ahead - behind).T / (2.0 * step), -residual, rcond=1e-12)[0]
        y[:free] += np.clip(move, -0.5, 0.5)
    raise SceneError("falls: no position of rest was found; give initial.position and initial.orientation")


def _spread(falls: Falls, q: Any) -> tuple[Any, Any]:
    """Return (lower ends from the load's centre, vectors from lower to upper ends), each (n, 3), at joints q."""
    arms = falls.bottom @ _rotation(q[6:10]).T
    return arms, falls.top + (q[0], q[1], 0.0) - (q[3:6] + arms)


def check_ends(falls: Falls, q: Any) -> None:
    """Raise SceneError for a fall whose ends are at the same place at joints q: it would have no direction."""
    distances = np.linalg.norm(_spread(falls, q)[1], axis=1)
    i = int(distances.argmin())
    if distances[i] < CLOSE:
        raise SceneError(
            f"falls.top[{i}] = {falls.top[i].tolist()}: at t = 0 both ends of this fall are at the same place; lower "
            "the load, or take another end"
        )


def stiffest_frequency(falls: Falls, load: RigidLoad, masses: Any, q: Any, contact: Any) -> float:
    """Return the largest frequency [rad/s] of the load on all of its falls, and on springs of a contact, at joints q.

    Args:
        falls, load: parameters.
        masses: kg, that move with the trolley along x and along y, and of the winch, None where it has none.
        q: joint positions (10,).
        contact: of the load, None without.
    """
    arms, apart = _spread(falls, q)
    n, rotation = apart / np.maximum(np.linalg.norm(apart, axis=1), CLOSE)[:, None], _rotation(q[6:10])
    stiffness, rest = falls.axial_stiffness, q[2] + falls.offset
    winch = masses[2] if masses[2] is not None else np.inf
    rows = [np.hstack([n, np.cross(arms, n) @ rotation, n[:, :2], np.ones((len(n), 1))])]
    springs = [stiffness / rest]
    if isinstance(contact, CompliantContact):
        levers = contact.points @ rotation.T
        up = np.tile([0.0, 0.0, 1.0], (len(levers), 1))
        rows.append(np.hstack([up, np.cross(levers, up) @ rotation, np.zeros((len(levers), 3))]))
        springs.append(np.full(len(levers), contact.stiffness))
    weighted = np.vstack(rows) * np.sqrt(np.concatenate(springs))[:, None]
    mobility = np.zeros((9, 9))
    mobility[:3, :3], mobility[3:6, 3:6] = np.eye(3) / load.mass, np.array(load.inverse_inertia)
    mobility[6:, 6:] = np.diag(1.0 / np.array([masses[0], masses[1], winch]))
    with np.errstate(all="ignore"):  # the largest numbers overflow
        matrix = weighted @ mobility @ weighted.T
    return float(np.sqrt(np.linalg.eigvalsh(matrix).max())) if np.isfinite(matrix).all() else float("inf")


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
    half = (0.5 * angles).tolist()
    (sr, sp, sy), (cr, cp, cy) = map(sin, half), map(cos, half)
    vector = (cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr)
    return np.array([cy * cp * cr + sy * sp * sr, *vector])


def _rotation(q: Any) -> Any:
    """Return the rotation matrix (3, 3) of a unit quaternion."""
    w, x, y, z = q
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
