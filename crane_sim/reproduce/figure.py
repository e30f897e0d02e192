"""The figure of the hard cases: how far each error is below its bound, and what it cost."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crane_sim.explain import SceneError

HOLDS, FAILS, BOUND = "#2a78b8", "#c43d3d", "#555555"


def draw_cases(cases: Sequence[Any], file: Path) -> None:
    """Draw error and bound of every case on one logarithmic axis, with the evaluations beside them.

    Raises:
        SceneError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise SceneError("--save: the figure needs matplotlib, which is not installed") from None
    figure = Figure(figsize=(9.0, 0.27 * len(cases) + 1.2), layout="constrained")
    axes = figure.add_subplot()
    for i, case in enumerate(cases):
        colour = HOLDS if case.verdict == "holds" else FAILS
        axes.plot([case.error, case.bound], [i, i], color=colour, linewidth=1.0, alpha=0.4)
        axes.plot(case.error, i, "o", color=colour, markersize=5)
        axes.plot(case.bound, i, "|", color=BOUND, markersize=10)
    axes.set_xscale("log")
    axes.set_yticks(range(len(cases)), [case.case for case in cases], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("error (dot) and its bound (bar): nodes in metres, the last two relative")
    right = axes.secondary_yaxis("right")
    right.set_yticks(range(len(cases)), [f"{case.evaluations:,} evals" for case in cases], fontsize=7)
    axes.grid(axis="x", alpha=0.3)
    figure.savefig(file, dpi=120)
