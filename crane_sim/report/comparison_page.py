"""The content of a comparison's page: the first run's crane, the others' ghosts, curves of all."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from crane_sim.recording.metric_units import metric_row
from crane_sim.recording.quantities import common_quantities, drawn_unit
from crane_sim.report.page_data import (
    MAX_EVENTS,
    curve_points,
    frames_of,
    page_data,
    parse_robot,
    state_rows,
    used_coordinates,
)
from crane_sim.report.panels import RUN_COLORS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.recording.comparison import Comparison
    from crane_sim.recording.run import RecordedRun

MAX_TOTAL_POINTS = 40_000  # of all curves
MAX_CURVE_POINTS = 1000
MAX_FRAME_VALUES = 140_000  # of all frames of all runs


def _join_lines(names: Sequence[str], lines: Sequence[str]) -> str:
    """Return the lines that runs have, each with the name of its run, as one."""
    return "; ".join(f"{name}: {line}" for name, line in zip(names, lines, strict=True) if line)


def comparison_data(comparison: Comparison) -> dict[str, Any]:
    """Return the content of a comparison's page, in the form of `page_data`."""
    runs, names = comparison.runs, comparison.names
    colors = [RUN_COLORS[i % len(RUN_COLORS)] for i in range(len(runs))]
    ghosts = [
        _ghost(run, MAX_FRAME_VALUES // len(runs)) | {"name": name, "color": color}
        for run, name, color in zip(runs[1:], names[1:], colors[1:], strict=True)
    ]
    return page_data(runs[0], MAX_FRAME_VALUES // len(runs)) | {
        "name": " and ".join(names) if len(names) == 2 else ", ".join(names),
        "about": f"{runs[0].crane.kind} crane; {names[0]} in its own colours, the others as ghosts",
        "end": max(float(run.t[-1]) + run.period for run in runs),
        "finished": all(run.finished for run in runs),
        "error": _join_lines(names, [run.error for run in runs]),
        "real_time_violation": _join_lines(names, [run.real_time_violation for run in runs]),
        "failure_window_start": None,
        "failure_window_panels": None,
        "legend": list(zip(names, colors, strict=True)),
        "ghosts": ghosts,
        "panels": _panels(comparison, colors),
        "states": _states(comparison),
        "headlines": [],
        "events": _events(comparison)[:MAX_EVENTS],
        "event_count": sum(len(run.events) for run in runs),
        "headed_table": _metric_rows(comparison),
        "plain_table": _difference_rows(comparison),
    }


def _states(comparison: Comparison) -> list[dict[str, Any]]:
    """Return the timelines of states of all runs, each with the name of its run."""
    return [
        row | {"name": f"{name}: {row['name']}"}
        for run, name in zip(comparison.runs, comparison.names, strict=True)
        for row in state_rows(run, float(run.t[-1]) + run.period)
    ]


def _events(comparison: Comparison) -> list[tuple[float, str]]:
    """Return the events of all runs in the order of time, each with the name of its run."""
    named = zip(comparison.runs, comparison.names, strict=True)
    return sorted((t, f"{name}: {what}") for run, name in named for t, what in run.events)


def _ghost(run: RecordedRun, max_values: int) -> dict[str, Any]:
    robot = parse_robot(run.crane.urdf, run.crane.joint_names)
    return {"robot": robot, "frames": frames_of(run, used_coordinates(robot), max_values)}


def _panels(comparison: Comparison, colors: list[str]) -> list[dict[str, Any]]:
    """Return one panel for each quantity, with a curve of each run."""
    quantities = common_quantities(comparison.runs)
    points = min(MAX_CURVE_POINTS, MAX_TOTAL_POINTS // max(1, len(quantities) * len(colors)))
    rows = list(zip(comparison.runs, comparison.names, colors, strict=True))
    return [
        {
            "title": title,
            "unit": unit,
            "curves": [
                {"name": name, "color": color, "dashed": False} | curve_points(run.t, each, points)
                for (run, name, color), each in zip(rows, values, strict=True)
            ],
        }
        for (title, unit), values in quantities.items()
    ]


def _metric_rows(comparison: Comparison) -> list[list[str]]:
    """Return the table of metrics: values of every run, and differences from the first."""
    names = comparison.names
    head = ["metric", *names, *(f"{name} − {names[0]}" for name in names[1:])]
    rows: list[list[str]] = []
    for key, values in comparison.metrics.items():
        label, unit, shown = metric_row(key, comparison.runs, values)
        rows.append(
            [
                f"{label} [{unit.replace('deg', '°')}]" if unit else label,
                *(text or "–" for text in shown),
            ]
        )
    return [head, *rows]


def _difference_rows(comparison: Comparison) -> list[list[str]]:
    """Return rows of every quantity's largest differences, with names for more than two runs."""
    others = comparison.names[1:]
    return [
        [
            quantity if len(others) == 1 else f"{name}: {quantity}",
            f"largest {_angle(each.largest, each.unit)} at {each.at:g} s",
            f"RMS {_angle(each.rms, each.unit)}",
        ]
        for name, differences in zip(others, comparison.differences, strict=True)
        for quantity, each in differences.items()
    ]


def _angle(value: float, unit: str) -> str:
    """Return a value with its unit, angles in degrees."""
    unit, factor = drawn_unit(unit)
    return f"{factor * value:.4g} {unit}"
