"""The metrics of a run for people: headlines, a list of plain metrics, and a table of the joints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from crane_sim.recording.layout import label
from crane_sim.recording.metric_units import metric_label, plain_unit
from crane_sim.report.panels import PREFIXES, UNITS_WITH_PREFIX

if TYPE_CHECKING:
    from crane_sim.recording.run import RecordedRun

HEADLINES = {
    "sim_time": "simulated",
    "peak_swing_deg": "peak swing",
    "residual_swing_deg": "swing left at the end",
    "max_rope_tension": "largest tension",
    "min_rope_tension": "smallest tension",
    "saturated_steps": "saturated periods",
}
HIDDEN = tuple("scene law mode seed error real_time_violation state_sha256 recording mcap event_count".split())
JOINTS = {"final_error": "final error", "settling_time": "joint settled after", "peak_effort": "peak effort"}


def headlines(run: RecordedRun) -> list[tuple[str, str]]:
    """Return (name, value with its unit) of the metrics that are read first."""
    known = {key: run.summary[key] for key in HEADLINES if run.summary.get(key) is not None}
    return [(HEADLINES[key], _format(value, _unit(key, run))) for key, value in known.items()]


def plain_metrics(run: RecordedRun) -> list[tuple[str, str]]:
    """Return (name, value with its unit) of all single metrics of a run's summary."""
    single = {key: value for key, value in run.summary.items() if isinstance(value, str | int | float) or value is None}
    return [(metric_label(key), _format(value, _unit(key, run))) for key, value in single.items() if key not in HIDDEN]


def joint_table(run: RecordedRun) -> list[list[str]]:
    """Return the rows of the actuated joints below the names of the columns; empty where there is nothing to say."""
    crane, summary = run.crane, run.summary
    units = dict(zip(crane.joint_names, crane.joint_units, strict=True))
    efforts = dict(zip(crane.actuated, crane.effort_units, strict=True))
    kinds = [key for key in JOINTS if summary.get(key)]
    unit_of = {"final_error": units, "settling_time": dict.fromkeys(crane.actuated, "s"), "peak_effort": efforts}
    rows = [
        [label(name), *(_format(summary[key].get(name), unit_of[key][name]) for key in kinds)]
        for name in crane.actuated
    ]
    return [["joint", *(JOINTS[key] for key in kinds)], *rows] if kinds else []


def _unit(key: str, run: RecordedRun) -> str:
    return plain_unit(key, run.path_unit).replace("deg", "°")


def _format(value: Any, unit: str) -> str:
    if value is None:
        return "–"
    if not isinstance(value, float):
        return f"{value} {unit}".strip()
    prefixes = PREFIXES if unit in UNITS_WITH_PREFIX else ()
    factor, prefix = next(((f, p) for f, least, p in prefixes if abs(value) >= least), (1.0, ""))
    return f"{value / factor:.4g} {prefix}{unit}".strip()
