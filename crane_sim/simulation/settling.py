"""Settling times of the actuated joints, gathered block by block: the same however long the blocks are."""

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.jit import LIGHT, entry_point, optimisation

Array = npt.NDArray[np.float64]
SETTLED = 0.02
"""A joint has settled when its error stays below this part of its initial error,"""
RESOLUTION = 1e-3
"""or below this [rad or m] where that is more: a joint that begins at its target settles, too,"""
STAY = 0.1
"""and has stayed there for at least this last part of the run."""


def nearness(target: Array, initial: Array) -> Array:
    """Return which distance (…, nu) from their targets counts as near, for joints that begin at `initial` (…, nu)."""
    return np.maximum(SETTLED * np.abs(target - initial), RESOLUTION)


def is_outside(target, near, q):
    """Return whether a joint at q is not near its target."""
    return not abs(target - q) <= near


@entry_point
@optimisation(LIGHT)
def note_outside(target, near, t, q, outside):
    """Note in `outside` (nu,) when joints were last not near their targets [s].

    Args:
        target, near: (nu,) of each joint.
        t: times (K,) [s].
        q: positions (K, nu).
        outside: to update.
    """
    for i in range(len(t)):
        for j in range(len(target)):
            if is_outside(target[j], near[j], q[i, j]):
                outside[j] = max(outside[j], t[i])


def settling_times(target: Array, near: Array, outside: Array, t: Array, q: Array, period: float) -> Array:
    """Return when the joints of n runs had settled (n, nu) [s], NaN for one that has not.

    A joint that was never away from its target has settled at 0.

    Args:
        target, near: of each joint (n, nu).
        outside: when each was last not near (n, nu) [s].
        t: when the runs end (n, 1) [s].
        q: positions of the joints there (n, nu).
        period: between instants [s].
    """
    inside, since = np.abs(target - q) <= near, np.maximum(outside + period, 0.0)
    lasting = (since <= (1.0 - STAY) * t) | (outside < 0.0)
    return np.where(inside & lasting, since, np.nan)


class Settling:
    """When each joint came near its target for good."""

    def __init__(self, target: Array, initial: Array) -> None:
        """Begin at positions `initial` (nu,) of joints that should end at `target` (nu,) [rad or m]."""
        self._target, self._near = target, nearness(target, initial)
        self.outside = np.full(len(target), -np.inf)  # s, when last

    def extend(self, t: Array, q: Array) -> None:
        """Take the positions q (K, nu) at times t (K,) [s]."""
        note_outside(self._target, self._near, np.ascontiguousarray(t), np.ascontiguousarray(q), self.outside)

    def times(self, t: float, q: Array, period: float) -> list[float | None]:
        """Return when each joint had settled [s], None for one that has not, in a run that ends at time t [s] and q.

        A joint that was never away from its target has settled at 0; `period` is the time [s] between instants.
        """
        target, near, outside = (part[None] for part in (self._target, self._near, self.outside))
        found = settling_times(target, near, outside, np.array([[t]]), q[None], period)[0]
        return [None if np.isnan(s) else float(s) for s in found]
