"""Columns that the table of every study has, and in which sense a metric is better."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

FIRST_COLUMNS = ("case", "sample", "variant", "law", "seed", "status", "error")
PARAMETER = "parameter."
"""What a column of a parameter begins with, before the parameter's dotted key."""
COLUMNS = (*FIRST_COLUMNS, PARAMETER, "events", "versions", "wall_time")
SIGNED = ("final_error",)
"""Metrics with a sign, whose magnitudes are compared: an overshoot is an error as large as what is
missing."""
LARGER_IS_BETTER = ("limit_margin", "min_rope_tension")
"""Metrics of which the least value is the worst one; of all others that is the largest."""


def is_better_larger(metric: str) -> bool:
    """Return whether larger values of a metric, or of its column of one joint, are better."""
    return metric.partition(".")[0] in LARGER_IS_BETTER


def worst_joint(metric: str, by_joint: Sequence[Any]) -> npt.NDArray[np.float64]:
    """Return a metric as studies compare it: of the worst joint, the magnitude if signed.

    Args:
        metric: its name, or that of its column of one joint.
        by_joint: its columns in the table, of shape (n,), or one run's values; NaN of one joint is
            NaN of all.
    """
    values = np.array(by_joint, dtype=float)
    if metric.partition(".")[0] in SIGNED:
        values = np.abs(values)
    return values.min(axis=0) if is_better_larger(metric) else values.max(axis=0)


class OwnMetric(list[Any]):
    """The column of a metric by a study's own function; the schema of the table marks it."""
