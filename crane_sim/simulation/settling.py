"""Settling times of the actuated joints: when each came near its target for good."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
SETTLED = 0.02
"""A joint has settled when its error stays below this part of its initial error,"""
RESOLUTION = 1e-3
"""or below this [rad or m] where that is more: a joint that begins at its target settles, too,"""
STAY = 0.1
"""and has stayed there for at least this last part of the run."""


def nearness(target: Array, initial: Array) -> Array:
    """Return which distances (…, nu) from targets count as near, for starts at `initial`.

    `initial` is (…, nu).
    """
    return np.maximum(SETTLED * np.abs(target - initial), RESOLUTION)


def is_outside(target, near, q):
    """Return whether a joint at q is not near its target."""
    return not abs(target - q) <= near


def settling_times(
    target: Array, near: Array, outside: Array, t: Array, q: Array, period: float
) -> Array:
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
