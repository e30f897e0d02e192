"""The plots of the soaks' page, one PNG file each; they need matplotlib."""

from pathlib import Path
from typing import Any

import numpy as np

from crane_sim.evaluation.soak.kill import ALL, HALF
from crane_sim.evaluation.soak.signals import LIMIT

COLOURS = ("#c43d3d", "#2a78b8", "#2f9e62")
PROMISED = "#555555"
_MINUTE, _MILLION = 60.0, 1e6


def draw_memory(data: dict[str, Any], file: Path) -> None:
    """Draw resident memory and rate over the minutes of a run."""
    minutes = np.array(data["seconds"]) / _MINUTE
    figure, (memory, rate) = _panels(2, "minutes")
    for colour, (node, resident) in zip(COLOURS, data["memory_MB"].items(), strict=False):
        memory.plot(minutes, resident, color=colour, linewidth=1.2, label=node)
    rate.plot(minutes, data["steps_per_second"], color=COLOURS[0], linewidth=0.9)
    _finish_panels(figure, (memory, "resident memory, MB"), (rate, "steps/s"), file)


def draw_inprocess(data: dict[str, Any], file: Path) -> None:
    """Draw resident memory and rate over millions of steps."""
    figure, (memory, rate) = _panels(2, "million steps")
    for colour, (way, found) in zip(COLOURS, data.items(), strict=False):
        steps = np.array(found["steps"]) / _MILLION
        memory.plot(steps, found["memory_MB"], color=colour, linewidth=1.2, label=way)
        rate.plot(steps, found["steps_per_second"], color=colour, linewidth=1.2)
    _finish_panels(figure, (memory, "resident memory, MB"), (rate, "steps/s"), file)


def draw_kill(data: dict[str, Any], file: Path) -> None:
    """Draw the share of kills behind which control was back within so many seconds."""
    back = np.sort([np.inf if value is None else value for value in data["back_s"]])
    share = 100.0 * np.arange(1, len(back) + 1) / len(back)
    figure, (axes,) = _panels(1, "s from the kill until the next controller's command is applied")
    found = np.isfinite(back)
    axes.step([0.0, *back[found]], [0.0, *share[found]], where="post", color=COLOURS[1])
    axes.axvline(HALF, color=PROMISED, linewidth=0.8, linestyle=":", label="promised for half of them")
    axes.axvline(ALL, color=PROMISED, linewidth=0.8, linestyle="--", label="promised for all")
    axes.set_xlim(left=0.0)
    _finish_panels(figure, (axes, "% of the controllers"), None, file)


def draw_signals(data: dict[str, Any], file: Path) -> None:
    """Draw how long each run took to end over the instant at which it was interrupted."""
    figure, (axes,) = _panels(1, "s from the start of the command until the signal")
    at, took, fresh = (np.array(data[name]) for name in ("at", "took", "fresh"))
    late = np.array(data["code"]) == 0  # it had ended before
    for colour, chosen, label in (
        (COLOURS[1], ~fresh & ~late, "interrupted"),
        (COLOURS[0], fresh & ~late, "nothing compiled yet"),
    ):
        if chosen.any():
            axes.plot(at[chosen], took[chosen], "o", color=colour, markersize=3.5, label=label)
    axes.axhline(LIMIT, color=PROMISED, linewidth=0.8, linestyle="--", label="promised")
    _finish_panels(figure, (axes, "s until the end"), None, file)


def _panels(number: int, along: str) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.9 * number + 1.0, 2.6), layout="constrained")
    panels = figure.subplots(1, number, squeeze=False)[0]
    for axes in panels:
        axes.set_xlabel(along, fontsize=8)
        axes.tick_params(labelsize=8)
        axes.grid(alpha=0.25)
    return figure, panels


def _finish_panels(figure: Any, first: tuple[Any, str], second: tuple[Any, str] | None, file: Path) -> None:
    """Give the panels their vertical axes, the first one its legend, and write the file."""
    for axes, label in (first, second) if second else (first,):
        axes.set_ylabel(label, fontsize=8)
        axes.set_ylim(bottom=0.0)
    first[0].legend(fontsize=7, frameon=False)
    figure.savefig(file, dpi=100)
