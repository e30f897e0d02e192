"""Units of the metrics of a summary, in which people read them: angles in degrees."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.recording.run import Crane

UNITS = {
    "sim_time": "s",
    "wall_time": "s",
    "settling_time": "s",
    "min_rope_tension": "N",
    "max_rope_tension": "N",
    "max_lead_line_tension": "N",
    "max_drum_torque": "N m",
    "peak_contact_force": "N",
    "tracking_mse": "m²",
    "tracking_mae": "m",
    "tracking_peak": "m",
    "peak_tip_acceleration": "m/s²",
    "peak_base_acceleration": "m/s²",
    "peak_base_angular_acceleration": "rad/s²",
    "max_fall_tensions": "N",
    "braked_time": "s",
}
"""Units of plain metrics; names that end in `_deg` and `_us` contain theirs."""
_POSITION_METRICS, _EFFORT_METRICS = ("final_error", "limit_margin", "overtravel"), ("peak_effort",)
_UNIT_SUFFIXES = {"_deg": "deg", "_us": "µs"}


class MetricUnit(NamedTuple):
    """What a metric is called where it is shown, its unit, and the factor from the summary's number to it."""

    label: str
    unit: str
    factor: float


def plain_unit(key: str) -> str:
    """Return the unit of a metric, the same for all cranes: by the end of its name, else from UNITS; empty: none."""
    return next((unit for ending, unit in _UNIT_SUFFIXES.items() if key.endswith(ending)), UNITS.get(key, ""))


def metric_unit(name: str, crane: Crane) -> MetricUnit:
    """Return how a metric of a crane's summary is shown: NAME, NAME.JOINT (of one it lacks: bare) or NAME.QUANTILE."""
    key, _, part = name.partition(".")
    ending = next((each for each in _UNIT_SUFFIXES if key.endswith(each)), "")
    label = " ".join([key.removesuffix(ending).replace("_", " "), *[part] * bool(part)])
    if key in _POSITION_METRICS:
        units = dict(zip(crane.joint_names, crane.joint_units, strict=True))
        return MetricUnit(label, *shown_unit(units.get(part, "")))
    if key in _EFFORT_METRICS:
        return MetricUnit(label, dict(zip(crane.actuated, crane.effort_units, strict=True)).get(part, ""), 1.0)
    return MetricUnit(label, plain_unit(key), 1.0)


def metric_row(name: str, cranes: Sequence[Crane], values: Sequence[float | None]) -> tuple[str, str, list[str]]:
    """Return (label, unit, texts) of a metric of several runs: its values, and differences from the first run.

    A value in another unit than that of the row is shown with its unit, and has no difference.
    """
    units = [metric_unit(name, crane) for crane in cranes]
    label, unit, _ = next(each for each, value in zip(units, values, strict=True) if value is not None)
    texts = [
        _format_scaled(value, own.factor) + (f" {own.unit}" if value is not None and own.unit != unit else "")
        for own, value in zip(units, values, strict=True)
    ]
    for own, value in zip(units[1:], values[1:], strict=True):
        if value is None or values[0] is None or own != units[0]:
            texts.append("")
        else:
            texts.append(_format_scaled(value - values[0], own.factor))
    return label, unit, texts


def _format_scaled(value: float | None, factor: float) -> str:
    return "" if value is None else f"{factor * value:.5g}"


def shown_unit(unit: str) -> tuple[str, float]:
    """Return (unit in which people read a quantity, its factor): angles in degrees."""
    return (unit.replace("rad", "deg"), degrees(1.0)) if unit.startswith("rad") else (unit, 1.0)
