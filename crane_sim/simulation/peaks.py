"""Largest and least values of a run's instants, gathered by compiled loops for one run or many."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.numerics.jit import LIGHT, entry_point, optimisation

Array = npt.NDArray[np.float64]

LAST = 0.25
"""The residual swing is the largest one in this last part of the run."""


PUSHED = -1e-6
"""N, the tension below which a link pushes: above it is the rounding of nothing."""


def swing_angles(tips: Array, payloads: Array) -> Array:
    """Return the angles (K,) [rad] of the ropes between tips and payloads (K, 3) from the vertical of the world."""
    x, y, z = (payloads - tips).T
    return np.arctan2(np.hypot(x, y), -z)


@entry_point
@optimisation(LIGHT)
def fill_watched(p, t, q, v, energies, ends):
    """Fill energies (K, 2) [J], kinetic and potential relative to the base, and ends (K, 6) [m], tip and payload."""
    points, tip = np.empty((system.point_count(p), 3)), system.tip_index(p)
    for i in range(len(q)):
        x = system.state(p, t[i], q[i], v[i])
        energies[i, 0], energies[i, 1] = system.kinetic(p, x), system.potential(p, x)
        system.points(p, t[i], x, points)
        ends[i, :3], ends[i, 3:] = points[tip], points[-1]


class Peaks(NamedTuple):
    """Largest and least values of one run; of many runs, each array is a column."""

    swing: Any  # (2, 3) m, from tip to payload at the largest swing of the run, and of its last part
    effort: Any  # (nu,), largest magnitudes
    tension: Any  # (2,) N, the least and the greatest of all links
    pushed: Any  # (1,) instants at which a link pushed


def no_peaks(nu: int, *runs: int) -> Peaks:
    """Return the peaks before the first instant, of nu actuated joints."""
    swing, tension = np.zeros((*runs, 2, 3)), np.full((*runs, 2), np.inf)
    swing[..., 2], tension[..., 1] = -1.0, -np.inf
    return Peaks(swing, np.zeros((*runs, nu)), tension, np.zeros((*runs, 1), np.int64))


def swings_further(x, y, z, largest):
    """Return whether a rope (x, y, z) is further from the vertical than `largest` (3,): the sine of the difference."""
    h, greatest = np.sqrt(x * x + y * y), np.sqrt(largest[0] * largest[0] + largest[1] * largest[1])
    return greatest * z - h * largest[2] > 0.0


def watch_swing(peaks, t, late, rope):
    """Take the rope (3,) [m], from tip to payload, at time t [s] into the peaks; the last part begins at `late`."""
    x, y, z = rope
    for part in range(2 if t >= late else 1):
        if swings_further(x, y, z, peaks.swing[part]):
            peaks.swing[part, 0], peaks.swing[part, 1], peaks.swing[part, 2] = x, y, z


def watch_efforts(peaks, u):
    """Take the efforts applied (nu,) at an instant into the peaks."""
    for j in range(len(u)):
        peaks.effort[j] = max(peaks.effort[j], abs(u[j]))


def watch_tension(peaks, least, greatest):
    """Take the least and the greatest tension [N] of the links at an instant into the peaks."""
    peaks.tension[0], peaks.tension[1] = min(peaks.tension[0], least), max(peaks.tension[1], greatest)
    peaks.pushed[0] += least < PUSHED


@entry_point
@optimisation(LIGHT)
def watch_instants(peaks, t, late, u, tensions, ends):
    """Take K instants into the peaks of one run.

    Args:
        peaks: `Peaks`.
        t: times (K,) [s].
        late: when the last part of the run begins [s].
        u: efforts applied (K, nu).
        tensions: of the links (K, L) [N].
        ends: tip and payload (K, 6) [m].
    """
    for i in range(len(t)):
        rope = ends[i, 3] - ends[i, 0], ends[i, 4] - ends[i, 1], ends[i, 5] - ends[i, 2]
        watch_swing(peaks, t[i], late, rope)
        watch_efforts(peaks, u[i])
        least, greatest = np.inf, -np.inf
        for j in range(tensions.shape[1]):
            least, greatest = min(least, tensions[i, j]), max(greatest, tensions[i, j])
        watch_tension(peaks, least, greatest)
