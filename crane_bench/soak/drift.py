"""Drift of a rate over a run, robust against short disturbances of the machine.

The run is cut into segments of equal length, each with its median rate: a short disturbance drops
out, and neighbouring medians are nearly independent. The slope is the median of the slopes between
all pairs of segments (Theil and Sen), with the interval that holds it with a confidence of 95 %.

On rented machines the processor's clock varies by tens of percent within minutes, and rates with
it. So the rate that is judged is the one at constant speed of the processor, which is measured with
each sample.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import theilslopes

from crane_bench.soak.metrics import Metric, at_least

MAX_FALL = 5.0  # %, that a rate may have lost at the end of a run
_SEGMENTS = 30


class Drift(NamedTuple):
    """Change of a rate from the start of a run to its end, % of its median."""

    change: float
    low: float
    high: float


def drift(rates: Sequence[float]) -> Drift:
    """Return the change of a rate, sampled in regular intervals at least three times."""
    segments = [
        float(np.median(samples))
        for samples in np.array_split(np.asarray(rates), min(_SEGMENTS, len(rates)))
    ]
    slopes = theilslopes(segments, alpha=0.95)
    scale = 100.0 * (len(segments) - 1) / float(np.median(segments))
    return Drift(*(scale * np.array([slopes[0], slopes[2], slopes[3]], dtype=float)).tolist())


def at_constant_speed(rates: Sequence[float], speeds: Sequence[float]) -> list[float]:
    """Return the rates (N,) that a processor at the median of its speeds (N,) would have."""
    return (np.asarray(rates) * float(np.median(speeds)) / np.asarray(speeds)).tolist()


def drift_metrics(rates: Sequence[float], speeds: Sequence[float], of: str = "") -> list[Metric]:
    """Return the metrics of a rate (N,), required not to fall, and of the resolution.

    Args:
        rates: steps/s, in regular intervals.
        speeds: of the processor in the same intervals, see `measure_processor_speed`.
        of: begins the metrics' names.
    """
    trend = drift(at_constant_speed(rates, speeds))
    return [
        Metric(f"{of}rate, median", float(np.median(rates)), "steps/s"),
        Metric(f"{of}rate, change from begin to end", drift(rates).change, "%"),
        Metric(f"{of}processor's speed, change from begin to end", drift(speeds).change, "%"),
        at_least(
            f"{of}rate at constant speed, change from begin to end", trend.change, -MAX_FALL, "%"
        ),
        Metric(f"{of}half the change's 95 % interval", (trend.high - trend.low) / 2.0, "%"),
    ]
