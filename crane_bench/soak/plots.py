"""The plots of the soaks' page, a figure of one or two panels each."""

from typing import Any

import numpy as np

from crane_bench.soak.kill import MAX_LIMIT, MEDIAN_LIMIT
from crane_bench.soak.signals import LIMIT
from crane_sim.report.plotting import BLUE, GREEN, GREY, RED

COLOURS = (RED, BLUE, GREEN)
REQUIRED = GREY
_MINUTE, _MILLION = 60.0, 1e6


def draw_memory(figure: Any, data: dict[str, Any]) -> None:
    """Draw resident memory and rate over the minutes of a run."""
    minutes = np.array(data["seconds"]) / _MINUTE
    memory, rate = _add_panels(figure, 2, "minutes")
    for colour, (node, resident) in zip(COLOURS, data["memory_MB"].items(), strict=False):
        memory.plot(minutes, resident, color=colour, linewidth=1.2, label=node)
    rate.plot(minutes, data["steps_per_second"], color=COLOURS[0], linewidth=0.9)
    _finish_panels((memory, "resident memory, MB"), (rate, "steps/s"))


def draw_inprocess(figure: Any, data: dict[str, Any]) -> None:
    """Draw resident memory and rate over millions of steps."""
    memory, rate = _add_panels(figure, 2, "million steps")
    for colour, (way, series) in zip(COLOURS, data.items(), strict=False):
        steps = np.array(series["steps"]) / _MILLION
        memory.plot(steps, series["memory_MB"], color=colour, linewidth=1.2, label=way)
        rate.plot(steps, series["steps_per_second"], color=colour, linewidth=1.2)
    _finish_panels((memory, "resident memory, MB"), (rate, "steps/s"))


def draw_kill(figure: Any, data: dict[str, Any]) -> None:
    """Draw the share of kills by the time until control was back."""
    back = np.sort([np.inf if value is None else value for value in data["back_s"]])
    share = 100.0 * np.arange(1, len(back) + 1) / len(back)
    (axes,) = _add_panels(
        figure, 1, "s from the kill until the next controller's command is applied"
    )
    finite = np.isfinite(back)
    axes.step([0.0, *back[finite]], [0.0, *share[finite]], where="post", color=COLOURS[1])
    axes.axvline(
        MEDIAN_LIMIT,
        color=REQUIRED,
        linewidth=0.8,
        linestyle=":",
        label="required for half of them",
    )
    axes.axvline(MAX_LIMIT, color=REQUIRED, linewidth=0.8, linestyle="--", label="required for all")
    axes.set_xlim(left=0.0)
    _finish_panels((axes, "% of the controllers"))


def draw_signals(figure: Any, data: dict[str, Any]) -> None:
    """Draw the time until the end of each run over the instant of its interruption."""
    (axes,) = _add_panels(figure, 1, "s from the start of the command until the signal")
    at, took, fresh = (np.array(data[name]) for name in ("at", "took", "fresh"))
    late = np.array(data["code"]) == 0  # it had ended before
    for colour, selected, label in (
        (COLOURS[1], ~fresh & ~late, "interrupted"),
        (COLOURS[0], fresh & ~late, "nothing compiled yet"),
    ):
        if selected.any():
            axes.plot(at[selected], took[selected], "o", color=colour, markersize=3.5, label=label)
    axes.axhline(LIMIT, color=REQUIRED, linewidth=0.8, linestyle="--", label="required")
    _finish_panels((axes, "s until the end"))


def _add_panels(figure: Any, number: int, along: str) -> Any:
    """Add panels side by side, with the label of their horizontal axes; return them."""
    figure.set_size_inches(3.9 * number + 1.0, 2.6)
    panels = figure.subplots(1, number, squeeze=False)[0]
    for axes in panels:
        axes.set_xlabel(along, fontsize=8)
        axes.tick_params(labelsize=8)
        axes.grid(alpha=0.25)
    return panels


def _finish_panels(*panels: tuple[Any, str]) -> None:
    """Give each panel its vertical axis, from 0 on, with a label, and the first one its legend."""
    for axes, label in panels:
        axes.set_ylabel(label, fontsize=8)
        axes.set_ylim(bottom=0.0)
    panels[0][0].legend(fontsize=7, frameon=False)
