"""Metrics of a soak test, each with the requirement that it has to pass."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np


class Metric(NamedTuple):
    """One measured quantity."""

    what: str
    value: Any
    unit: str = ""
    requirement: str = ""  # in words; empty without one
    passed: bool = True

    def format_value(self) -> str:
        """Return the value with its unit, in a few digits."""
        if self.value is None:  # a non-finite number in a file
            return "—"
        value = f"{self.value:.4g}" if isinstance(self.value, float) else str(self.value)
        return f"{value} {self.unit}".strip()


def at_most(what: str, value: float, limit: float, unit: str = "") -> Metric:
    """Return a metric that must not exceed a limit."""
    return Metric(what, value, unit, f"at most {limit:g} {unit}".strip(), value <= limit)


def at_least(what: str, value: float, limit: float, unit: str = "") -> Metric:
    """Return a metric that must not fall below a limit."""
    return Metric(what, value, unit, f"at least {limit:g} {unit}".strip(), value >= limit)


def equal(what: str, value: Any, expected: Any, unit: str = "") -> Metric:
    """Return a metric that must be equal to `expected`."""
    return Metric(what, value, unit, f"{expected}", value == expected)


def quantiles(values: Sequence[float]) -> dict[str, float]:
    """Return median, 99 % quantile and largest of some numbers; nan where there are none."""
    if not len(values):
        return dict.fromkeys(("p50", "p99", "max"), float("nan"))
    array = np.asarray(values)
    return {
        "p50": float(np.median(array)),
        "p99": float(np.quantile(array, 0.99)),
        "max": float(array.max()),
    }
