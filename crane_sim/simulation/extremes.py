"""Extreme values of a run's joints: margins to travel limits, tilt of a rigid load, deflections of the structure."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.jit import LIGHT, entry_point, optimisation
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.flexibility import DEFLECTION
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.simulation.flat_summary import one_run

Array = npt.NDArray[np.float64]


class Tilt(NamedTuple):
    """Angles of a load, (K,) each [rad], in the axes of the base."""

    tilt: Array  # of its z axis from the base's
    skew: Array  # about z
    trim: Array  # about y, after the skew
    list: Array  # about x, after both


def tilt_of(quaternions: Array) -> Tilt:
    """Return the angles of unit quaternions (K, 4), w first; R = Rz(skew) Ry(trim) Rx(list)."""
    w, x, y, z = quaternions.T
    upright = np.hypot(w, z)
    return Tilt(
        2.0 * np.arctan2(np.hypot(x, y), upright),
        np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0)),
        np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
    )


def note_range_at(row, low, high):
    """Update the least `low` (m,) and greatest `high` (m,) values with those of a row (m,)."""
    for j in range(len(row)):
        low[j], high[j] = min(low[j], row[j]), max(high[j], row[j])


@entry_point
@optimisation(LIGHT)
def note_range(rows, low, high):
    """Update the least `low` (m,) and greatest `high` (m,) values of each column of rows (K, m)."""
    for i in range(len(rows)):
        note_range_at(rows[i], low, high)


def joint_margins(limits: Mapping[str, Any], names: Sequence[str], ranges: Array) -> dict[str, Any]:
    """Return the least distances of n runs' joints to their travel limits: `limit_margin`, arrays (n,) by joint.

    Args:
        limits: lowest and highest position by joint, (n,) each.
        names: of the joints (nq,).
        ranges: least and greatest positions (n, 2, nq).
    """
    found = {}
    for joint, (low, high) in limits.items():
        i = names.index(joint)
        found[joint] = np.minimum(ranges[:, 0, i] - low, high - ranges[:, 1, i])
    return {"limit_margin": found} if found else {}


class Extremes:
    """Extremes of the joint positions, collected block by block; the division into blocks does not change a bit."""

    def __init__(self, scene: Scene) -> None:
        """Begin before the first positions of a scene's run."""
        names = scene.joint_names
        self._names, self._limits = names, {each.joint: (each.low, each.high) for each in scene.limits}
        self._low, self._high = np.full(len(names), np.inf), np.full(len(names), -np.inf)
        self._attitude = names.index(ATTITUDE[0]) if ATTITUDE[0] in names else None
        self._angles = ("tilt",) if "slew" in names else Tilt._fields  # a slewing crane turns the load on purpose
        self._peaks = np.zeros(len(self._angles))
        self._bending = {name: i for i, name in enumerate(names) if name.endswith(DEFLECTION)}
        self._peak_angles = np.zeros(len(self._bending))

    @property
    def has_angles(self) -> bool:
        """Whether it watches angles: those of a rigid load, or deflections."""
        return self._attitude is not None or bool(self._bending)

    def extend(self, q: Array) -> None:
        """Take joint positions (K, nq)."""
        note_range(np.ascontiguousarray(q), self._low, self._high)
        self._peak_angles = np.maximum(self._peak_angles, np.abs(q[:, [*self._bending.values()]]).max(axis=0))
        if self._attitude is not None:
            angles = tilt_of(q[:, self._attitude : self._attitude + 4])
            largest = [np.abs(getattr(angles, name)).max() for name in self._angles]
            self._peaks = np.maximum(self._peaks, largest)

    def summary(self, q: Array) -> dict[str, Any]:
        """Return the metrics of a run that ends at positions q (nq,); empty without limits, rigid load and deflections.

        `limit_margin` is the least distance of each joint to its travel limits, negative beyond them;
        `peak_tilt_deg` the largest angle of the load's z axis from the base's, and `peak_skew_deg`, `peak_trim_deg`,
        `peak_list_deg` its largest rotations about z, y and x of a support that does not slew;
        `peak_lateral_deflection_deg` and `peak_vertical_deflection_deg` the largest angles by which a structure bends.
        """
        self.extend(np.array([q]))
        margins = one_run(joint_margins(self._limits, self._names, np.array([[self._low, self._high]])))
        peaks = np.degrees(self._peaks) if self._attitude is not None else ()
        angles = {f"peak_{name}_deg": float(peak) for name, peak in zip(self._angles, peaks, strict=False)}
        angles |= {f"peak_{n}_deg": float(a) for n, a in zip(self._bending, np.degrees(self._peak_angles), strict=True)}
        return margins | angles
