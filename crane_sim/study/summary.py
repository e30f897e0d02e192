"""Summary of a study: failures, spread of metrics by variant, and what variants differ in."""

from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim.study.result import StudyResult
from crane_sim.study.schema import MORRIS, SALTELLI
from crane_sim.study.sensitivity import sensitivities

SHOWN = ("residual_swing_deg", "peak_swing_deg", "settling_time", "peak_effort", "tracking_mse")
"""Metrics of a run that people look at first, those of joints with all of their joints; the table
has all."""


def shown_metrics(result: StudyResult) -> list[str]:
    """Return the columns that a summary shows: those of SHOWN and the study's own metrics."""
    numbers = [name for name, kind in result.types.items() if kind in ("double", "int64")]
    shown = [
        name for start in SHOWN for name in numbers if name == start or name.startswith(f"{start}.")
    ]
    return list(dict.fromkeys([*shown, *(name for name in result.own_metrics if name in numbers)]))


def summarise(result: StudyResult) -> dict[str, Any]:
    """Return counts, medians and extremes of metrics by variant, and paired differences."""
    first, *_ = variants = list(result.study.variant_changes)
    metrics = {
        name: {variant: spread_of(result.metric(name, variant)) for variant in variants}
        | {f"{other} - {first}": each._asdict() for other, each in result.differences(name).items()}
        for name in shown_metrics(result)
    }
    return {
        "study": result.study.name,
        "runs": len(result),
        "failures": {variant: int(result.failed(variant).sum()) for variant in variants},
        "failure_differences": {
            other: each._asdict() for other, each in result.failure_differences().items()
        },
        "metrics": metrics,
        "sensitivities": find_sensitivities(result),
        "table": str(result.folder / "table.parquet"),
    }


def find_sensitivities(result: StudyResult) -> dict[str, dict[str, list[dict[str, Any]]]]:
    """Return the sensitivities by metric and variant.

    Only metrics that all runs have are included, and only in designs made for it.
    """
    if result.study.design not in (MORRIS, SALTELLI):
        return {}
    found: dict[str, dict[str, list[dict[str, Any]]]] = {}
    for name in shown_metrics(result):
        for variant in result.study.variant_changes:
            if np.isfinite(result.metric(name, variant)).all():
                rows = sensitivities(result, name, variant)
                found.setdefault(name, {})[variant] = [row._asdict() for row in rows]
    return found


def spread_of(values: npt.NDArray[np.float64]) -> dict[str, float | int | None]:
    """Return count, least, median and greatest of the finite numbers among values (n,)."""
    values = values[np.isfinite(values)]
    if not len(values):
        return {"runs": 0, "least": None, "median": None, "greatest": None}
    least, median, greatest = np.quantile(values, (0.0, 0.5, 1.0)).tolist()
    return {"runs": len(values), "least": least, "median": median, "greatest": greatest}


def first_errors(result: StudyResult, most: int = 5) -> list[str]:
    """Return lines on the first runs that failed."""
    errors = result.column("error")
    failed = [i for i, error in enumerate(errors) if error]
    case, variant = result.column("case"), result.column("variant")
    lines = [f"case {case[i]}, {variant[i]}: {errors[i]}" for i in failed[:most]]
    return [*lines, *[f"... and {len(failed) - most} more"] * (len(failed) > most)]
