"""Whether a rate changes over a run, asked so that a busy moment of the machine does not answer.

The run is cut into stretches of equal length, of which each counts with its median rate: a short disturbance drops out,
and what is left of neighbouring ones is nearly independent. The slope is the median of the slopes between all pairs of
stretches (Theil and Sen), with the interval that holds it with a confidence of 95 %.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import theilslopes

from crane_sim.evaluation.soak.figures import Figure, at_least

FALL = 5.0  # %, that a rate may have lost at the end of a run
_STRETCHES = 30


class Drift(NamedTuple):
    """How a rate changed from the begin of a run to its end, % of its median."""

    change: float
    low: float
    high: float


def drift(rates: Sequence[float]) -> Drift:
    """Return the change of a rate that was looked at in regular intervals, at least three times."""
    stretches = [float(np.median(part)) for part in np.array_split(np.asarray(rates), min(_STRETCHES, len(rates)))]
    slopes = theilslopes(stretches, alpha=0.95)
    scale = 100.0 * (len(stretches) - 1) / float(np.median(stretches))
    return Drift(*(scale * np.array([slopes[0], slopes[2], slopes[3]], dtype=float)).tolist())


def drift_figures(rates: Sequence[float], of: str = "") -> list[Figure]:
    """Return what was promised of a rate, that it does not fall, and the resolution of the measurement."""
    trend = drift(rates)
    return [
        Figure(f"{of}rate, median", float(np.median(rates)), "steps/s"),
        at_least(f"{of}rate, change from begin to end", trend.change, -FALL, "%"),
        Figure(f"{of}half the change's 95 % interval", (trend.high - trend.low) / 2.0, "%"),
    ]
