"""Units of the metrics of a summary, in which people read them: angles in degrees."""

from __future__ import annotations

import json
from math import degrees
from typing import TYPE_CHECKING, Any, NamedTuple

from crane_sim.simulation.flat_summary import leaves

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from crane_sim.recording.run import RecordedRun


UNITS = {
    "sim_time": "s",
    "wall_time": "s",
    "compile_time": "s",
    "settling_time": "s",
    "min_rope_tension": "N",
    "max_rope_tension": "N",
    "max_lead_line_tension": "N",
    "max_drum_torque": "N m",
    "peak_contact_force": "N",
    "peak_tip_acceleration": "m/s²",
    "peak_base_acceleration": "m/s²",
    "peak_base_angular_acceleration": "rad/s²",
    "max_fall_tensions": "N",
    "braked_time": "s",
}
"""Units of plain metrics; names that end in `_deg` and `_us` contain theirs."""
_PATH_POWERS = {"tracking_mse": 2, "tracking_mae": 1, "tracking_peak": 1}
"""Metrics in the unit of the path's coordinates, and in which power of it."""
_POSITION_METRICS, _EFFORT_METRICS = ("final_error", "limit_margin", "overtravel"), ("peak_effort",)
_UNIT_SUFFIXES = {"_deg": "deg", "_us": "µs"}


class MetricUnit(NamedTuple):
    """A metric's displayed name, its unit, and the factor from the summary's number to it."""

    label: str
    unit: str
    factor: float


def metric_label(key: str) -> str:
    """Return what a metric is called where it is shown with its unit."""
    ending = next((each for each in _UNIT_SUFFIXES if key.endswith(each)), "")
    return key.removesuffix(ending).replace("_", " ")


def plain_unit(key: str, path: str) -> str:
    """Return the unit of a metric that is one number, empty: none.

    `path` is the unit of the path's coordinates.
    """
    if key in _PATH_POWERS:
        return _to_power(path, _PATH_POWERS[key])
    return next(
        (unit for ending, unit in _UNIT_SUFFIXES.items() if key.endswith(ending)),
        UNITS.get(key, ""),
    )


def _to_power(unit: str, power: int) -> str:
    return f"{unit}²" if unit and power == 2 else unit


def metric_unit(name: str, run: RecordedRun) -> MetricUnit:
    """Return how a metric is shown; its name is NAME, NAME.JOINT or NAME.QUANTILE.

    Of a joint that the run lacks, the number is bare.
    """
    crane = run.crane
    key, _, part = name.partition(".")
    label = " ".join([metric_label(key), *[part] * bool(part)])
    if key in _POSITION_METRICS:
        units = dict(zip(crane.joint_names, crane.joint_units, strict=True))
        return MetricUnit(label, *shown_unit(units.get(part, "")))
    if key in _EFFORT_METRICS:
        return MetricUnit(
            label, dict(zip(crane.actuated, crane.effort_units, strict=True)).get(part, ""), 1.0
        )
    if key in _PATH_POWERS:
        unit, factor = shown_unit(run.path_unit)
        return MetricUnit(label, _to_power(unit, _PATH_POWERS[key]), factor ** _PATH_POWERS[key])
    return MetricUnit(label, plain_unit(key, ""), 1.0)


def metric_row(
    name: str, runs: Sequence[RecordedRun], values: Sequence[float | None]
) -> tuple[str, str, list[str]]:
    """Return (label, unit, texts) of a metric: its values, and differences from the first run.

    A value in another unit than that of the row is shown with its unit, and has no difference.
    """
    units = [metric_unit(name, run) for run in runs]
    label, unit, _ = next(
        each for each, value in zip(units, values, strict=True) if value is not None
    )
    texts = [
        _format_scaled(value, own.factor)
        + (f" {own.unit}" if value is not None and own.unit != unit else "")
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


# of metrics whose entries have different ones
_UNITS = {"final_error": "rad, m", "peak_effort": "N m, N"}


def summary_properties(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the summary as flat recording properties, and once whole under `json`."""
    flat = {
        name: value
        for name, value in leaves(summary)
        if isinstance(value, str | bool | int | float)
    }
    return flat | {"json": json.dumps(summary, default=_plain_number)}


def summary_table(title: str, summary: Mapping[str, Any], path_unit: str) -> str:
    """Return the summary as markdown: plain values first, then those per joint or per kind.

    `path_unit` is the unit of the path's coordinates, empty where they have different ones.
    """
    plain = [key for key, value in summary.items() if not isinstance(value, dict)]
    rows = [
        [metric_label(key), _format_quantity(summary[key], _unit(key, path_unit))] for key in plain
    ]
    parts = [f"# {title}", markdown_table(["quantity", "value"], rows)]
    groups: dict[tuple[str, ...], list[str]] = {}  # those with the same entries stand side by side
    for key, value in summary.items():
        if isinstance(value, dict) and value:
            groups.setdefault(tuple(value), []).append(key)
    for entries, keys in groups.items():
        units = [_unit(key, path_unit) for key in keys]
        heads = [
            f"{metric_label(key)} [{unit}]" if unit else metric_label(key)
            for key, unit in zip(keys, units, strict=True)
        ]
        rows = [
            [metric_label(entry), *(_format_quantity(summary[key][entry]) for key in keys)]
            for entry in entries
        ]
        parts.append(markdown_table(["", *heads], rows))
    return "\n\n".join(parts) + "\n"


def _plain_number(value: Any) -> Any:
    """Return a number of numpy as one of Python."""
    return value.item()


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in markdown: columns of numbers behind one of words."""
    lines = [header, ["---"] + ["---:"] * (len(header) - 1), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _unit(key: str, path_unit: str) -> str:
    return _UNITS.get(key) or plain_unit(key, path_unit).replace("deg", "°")


def _format_quantity(value: Any, unit: str = "") -> str:
    if value is None:
        return "–"
    text = f"{value:.5g}" if isinstance(value, float) else str(value)
    return f"{text} {unit}".strip()
