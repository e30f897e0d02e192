"""The figure of a run, by matplotlib: every panel over one time axis, and the payload's path."""

from __future__ import annotations

import io
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.installation import import_optional
from crane_sim.files.output import write_output
from crane_sim.recording.quantities import PALETTE, TEXT_COLOR, moving_quantities
from crane_sim.recording.read import as_recorded
from crane_sim.recording.states import get_color, make_spans
from crane_sim.report.decimation import rows_with_peaks
from crane_sim.report.panels import AXIS_COLOR, RUN_COLORS, Panel, panels_of

if TYPE_CHECKING:
    from pathlib import Path

    from crane_sim.recording.comparison import Comparison
    from crane_sim.recording.run import RecordedRun
    from crane_sim.simulation.rollout import Rollout

COLUMNS, WIDTH, HEIGHT = 3, 5.0, 2.5  # panels side by side, inches of one
MAX_CURVE_POINTS = 4000
MAX_SPANS = 500  # of a timeline of states: spans shorter than the run by this number are merged
KINDS = (".png", ".pdf", ".svg")
STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 10,
    "svg.hashsalt": "crane_sim",
    "axes.edgecolor": AXIS_COLOR,
}
PLANES = (("from above", 0, 1), ("from the side", 0, 2))


def save_run_figure(run: RecordedRun, file: Path) -> None:
    """Write the figure of a run into a .png, .pdf or .svg file.

    Raises:
        SceneError: the kind of file is another one, matplotlib is missing, or the file cannot be
            written.
    """
    _check_kind(file)
    _save(run_figure(run), file)


def save_comparison_figure(comparison: Comparison, file: Path) -> None:
    """Write the figure of several runs into a .png, .pdf or .svg file.

    Raises:
        SceneError: as of `save_run_figure`.
    """
    _check_kind(file)
    _save(comparison_figure(comparison), file)


def _check_kind(file: Path) -> None:
    if file.suffix.lower() not in KINDS:
        raise SceneError(f"-o {file}: must end in {', '.join(KINDS)}")


def _save(figure: Any, file: Path) -> None:
    drawn = io.BytesIO()  # what a PDF raises on a full disk is no OSError
    with _matplotlib()[0](STYLE):  # for an SVG's identifiers, which are made here
        figure.savefig(drawn, format=file.suffix[1:].lower(), dpi=140)
    write_output("-o", file, lambda path: path.write_bytes(drawn.getvalue()))


def comparison_figure(comparison: Comparison) -> Any:
    """Return the `matplotlib.figure.Figure` of several runs.

    It has a panel for each quantity that all have and that moves.

    Each run has one colour in all panels, and one legend names them.
    """
    quantities = moving_quantities(comparison.runs)
    rows = max(1, ceil(len(quantities) / COLUMNS))
    rc_context, figure_class = _matplotlib()
    with rc_context(STYLE):
        figure, axes = _make_axes(figure_class, rows)
        for axis, ((title, unit), curves) in zip(axes, quantities.items(), strict=False):
            for i, (run, each) in enumerate(zip(comparison.runs, curves, strict=True)):
                kept = rows_with_peaks(each, MAX_CURVE_POINTS)
                axis.plot(
                    run.t[kept], each[kept], color=RUN_COLORS[i % len(RUN_COLORS)], linewidth=1.2
                )
            _label(axis, title[0].upper() + title[1:], unit)
        for axis in axes[len(quantities) :]:
            axis.set_axis_off()
        figure.legend(
            axes[0].lines, comparison.names, loc="outside upper center", ncols=6, frameon=False
        )
    return figure


def plot(run: RecordedRun | Rollout) -> Any:
    """Return the figure of a run, what its method `plot` returns."""
    return run_figure(as_recorded(run))


def run_figure(run: RecordedRun) -> Any:
    """Return the `matplotlib.figure.Figure` of a run: `panels_of`, then the payload's path."""
    panels = panels_of(run)
    planes = [plane for plane in PLANES if np.ptp(run.payload[:, plane[2]]) > 1e-9]
    rows = ceil((len(panels) + len(planes) + bool(run.states)) / COLUMNS)
    rc_context, figure_class = _matplotlib()
    with rc_context(STYLE):
        figure, axes = _make_axes(figure_class, rows)
        title = " · ".join(
            filter(None, (run.name, f"law {run.law}", run.status, run.real_time_violation))
        )
        figure.suptitle(title, color=TEXT_COLOR, wrap=True)
        for axis, panel in zip(axes, panels, strict=False):
            _draw(axis, run, panel)
        for axis, plane in zip(axes[len(panels) :], planes, strict=False):
            _draw_path(axis, run, *plane)
        others = axes[len(panels) + len(planes) :]
        if run.states:
            _draw_states(others[0], run)
        for axis in others[bool(run.states) :]:
            axis.set_axis_off()
    return figure


def _matplotlib() -> tuple[Any, Any]:
    """Return matplotlib's `rc_context` and `Figure`; SceneError where it is not installed."""
    rc_context = import_optional("matplotlib", "a figure").rc_context
    return rc_context, import_optional("matplotlib.figure", "a figure").Figure


def _make_axes(figure_class: Any, rows: int) -> tuple[Any, Any]:
    """Return a figure with so many rows of axes, and the axes (rows * COLUMNS,)."""
    figure = figure_class(figsize=(COLUMNS * WIDTH, rows * HEIGHT + 0.5), layout="constrained")
    return figure, figure.subplots(rows, COLUMNS, squeeze=False).ravel()


def _draw(axis: Any, run: RecordedRun, panel: Panel) -> None:
    for curve in panel.curves:
        rows = rows_with_peaks(curve.values, MAX_CURVE_POINTS)
        style = (
            {"linestyle": "--", "linewidth": 0.9, "alpha": 0.75}
            if curve.dashed
            else {"linewidth": 1.2}
        )
        style |= {"linestyle": ":", "linewidth": 1.0} if curve.dotted else {}
        axis.plot(run.t[rows], curve.values[rows], color=curve.color, label=curve.name, **style)
    for t, _ in run.events[:50]:
        axis.axvline(t, color=AXIS_COLOR, linewidth=0.5, linestyle=":")
    _label(axis, panel.title, panel.unit)
    axis.legend(loc="best", fontsize=7.5, frameon=False, ncols=2 if len(panel.curves) > 3 else 1)


def _label(axis: Any, title: str, unit: str) -> None:
    axis.set_title(title, loc="left", color=TEXT_COLOR)
    axis.set_xlabel("time [s]")
    axis.set_ylabel(f"[{unit}]")
    axis.margins(x=0.0)
    _style_axes(axis)


def _draw_path(axis: Any, run: RecordedRun, view: str, across: int, up: int) -> None:
    x, y = run.payload[:, across], run.payload[:, up]
    axis.plot(x, y, color=PALETTE[5], linewidth=1.1)
    axis.plot(x[:1], y[:1], "o", color=TEXT_COLOR, markersize=4, label="start")
    axis.plot(x[-1:], y[-1:], "s", color=PALETTE[5], markersize=4, label="end")
    axis.set_title(f"Path of the payload {view}", loc="left", color=TEXT_COLOR)
    axis.set_xlabel(f"{'xyz'[across]} [m]")
    axis.set_ylabel(f"{'xyz'[up]} [m]")
    axis.set_aspect("equal", adjustable="datalim")
    _style_axes(axis)
    axis.legend(loc="best", fontsize=7.5, frameon=False)


def _draw_states(axis: Any, run: RecordedRun) -> None:
    """Draw timelines of states as bands, one row each, with the names of states not normal."""
    end = float(run.t[-1]) + run.period
    for row, changes in enumerate(run.states.values()):
        for begin, until, state in make_spans(changes, 0.0, end, end / MAX_SPANS):
            width = max(until - begin, end / MAX_SPANS)
            axis.barh(row, width, left=begin, height=0.7, color=get_color(state))
            if until - begin > 0.02 * len(state) * end:
                style = {"va": "center", "fontsize": 6.5, "color": TEXT_COLOR, "clip_on": True}
                axis.text(begin + 0.01 * end, row, state, **style)
    axis.set_yticks(range(len(run.states)), list(run.states), fontsize=7.5)
    axis.invert_yaxis()
    axis.set_xlim(0.0, end)
    axis.set_title("States", loc="left", color=TEXT_COLOR)
    axis.set_xlabel("time [s]")
    axis.spines[["top", "right"]].set_visible(False)


def _style_axes(axis: Any) -> None:
    axis.grid(color="#e3e7eb", linewidth=0.6)
    axis.spines[["top", "right"]].set_visible(False)
