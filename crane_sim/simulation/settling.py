"""Settling times of the actuated joints, gathered block by block: the same however long the blocks are."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
SETTLED = 0.02
"""A joint has settled when its error stays below this part of its initial error,"""
RESOLUTION = 1e-3
"""or below this [rad or m] where that is more: a joint that begins at its target settles, too,"""
HELD = 0.1
"""and has stayed there for at least this last part of the run."""


class Settling:
    """When each joint came near its target for good."""

    def __init__(self, target: Array, initial: Array) -> None:
        """Begin at positions `initial` (nu,) of joints that should end at `target` (nu,) [rad or m]."""
        self._target = target
        self._near = np.maximum(SETTLED * np.abs(target - initial), RESOLUTION)
        self._outside = np.full(len(target), -np.inf)  # s, when last

    def extend(self, t: Array, q: Array) -> None:
        """Take the positions q (K, nu) at times t (K,) [s]."""
        outside = ~(np.abs(self._target - q) <= self._near)
        self._outside = np.maximum(self._outside, np.where(outside, t[:, None], -np.inf).max(axis=0))

    def times(self, t: float, q: Array, period: float) -> list[float | None]:
        """Return when each joint had settled [s], None for one that has not, in a run that ends at time t [s] and q.

        A joint that was never away from its target has settled at 0; `period` is the time [s] between instants.
        """
        inside, since = np.abs(self._target - q) <= self._near, np.maximum(self._outside + period, 0.0)
        held = (since <= (1.0 - HELD) * t) | (self._outside < 0.0)
        return [float(s) if ok else None for s, ok in zip(since, inside & held, strict=True)]
