"""The figures of the items: hard cases' errors and bounds, papers' experiments over time.

An experiment is run again for its figure: a run is repeatable, so these are the runs of the table.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from crane_bench.reproduce import knuckle, offshore
from crane_sim.report.plotting import BLUE, GREY, RED

HOLDS, FAILS, BOUND = BLUE, RED, GREY
FIRST, SECOND, GOAL = HOLDS, FAILS, BOUND
LABELS = ("tower, deg", "boom, deg", "jib, deg", "rope, m", "theta1, deg", "theta2, deg")
EFFORTS = ("u1, N m", "u2, N m", "u3, N m", "u4, N")


def draw_cases(figure: Any, rows: Sequence[Any]) -> None:
    """Draw error and bound of every case on one logarithmic axis, and the evaluations beside."""
    figure.set_size_inches(9.0, 0.27 * len(rows) + 1.2)
    axes = figure.add_subplot()
    for i, case in enumerate(rows):
        colour = HOLDS if case.verdict == "holds" else FAILS
        axes.plot([case.error, case.bound], [i, i], color=colour, linewidth=1.0, alpha=0.4)
        axes.plot(case.error, i, "o", color=colour, markersize=5)
        axes.plot(case.bound, i, "|", color=BOUND, markersize=10)
    axes.set_xscale("log")
    axes.set_yticks(range(len(rows)), [case.case for case in rows], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("error (dot) and its bound (bar): nodes in metres, the last two relative")
    right = axes.secondary_yaxis("right")
    right.set_yticks(range(len(rows)), [f"{case.evaluations:,} evals" for case in rows], fontsize=7)
    axes.grid(axis="x", alpha=0.3)


def draw_knuckle(figure: Any, rows: Sequence[Any]) -> None:
    """Draw joints, swing and efforts of both laws over time, as figures 3 to 10 of the paper."""
    figure.set_size_inches(9.0, 10.0)
    runs, panels = knuckle.run_both_laws(), figure.subplots(5, 2, sharex=True).ravel()
    target = (*knuckle.target_position(runs.energy.scene), 0.0, 0.0)
    for i, (panel, label) in enumerate(zip(panels, (*LABELS, *EFFORTS), strict=True)):
        number, scale = (
            (3 + i if i < 6 else 6 + i // 2),
            np.degrees(1.0) if label.endswith("deg") else 1.0,
        )
        if i < 6:
            panel.axhline(
                scale * target[i], color=GOAL, linewidth=0.8, linestyle="--", label="target"
            )
        for law, run, colour in (("energy law", runs.energy, FIRST), ("LQR", runs.lqr, SECOND)):
            values = run.q[:, i] if i < 6 else run.u[:, i - 6]
            panel.plot(run.t, scale * values, color=colour, linewidth=1.0, label=law)
        panel.set_title(f"Fig. {number}: {label}", fontsize=9)
        panel.grid(alpha=0.3)
    panels[0].legend(fontsize=8)
    for panel in panels[-2:]:
        panel.set_xlabel("t, s")


def draw_offshore(figure: Any, rows: Sequence[Any]) -> None:
    """Draw payload paths, left, and error size over time, right; one row for each table."""
    figure.set_size_inches(10.0, 9.0)
    panels = figure.subplots(3, 2, width_ratios=(1, 2))
    for (path, error), experiments in zip(panels, offshore.PAIRS, strict=True):
        for colour, experiment in zip((SECOND, FIRST), experiments, strict=True):
            _plot_tracking(path, error, experiment, colour)
        path.set_aspect("equal")
        path.set_title(f"{experiments[0].table}: path of the payload, m", fontsize=9)
        error.set_title(
            f"{experiments[0].table}: distance from where it should be, m", fontsize=9, loc="left"
        )
        error.legend(
            fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 0.97), ncols=2, frameon=False
        )
        path.plot([], [], color=GOAL, linewidth=0.8, linestyle="--", label="path")
        path.legend(fontsize=7, loc="upper left", frameon=False)
    panels[-1][1].set_xlabel("t, s")


def _plot_tracking(path: Any, error: Any, experiment: offshore.Experiment, colour: str) -> None:
    run = offshore.run_experiment(experiment)
    payload, goal = offshore.payload_and_path(run)
    path.plot(payload[:, 0], payload[:, 1], color=colour, linewidth=1.0)
    path.plot(goal[:, 0], goal[:, 1], color=GOAL, linewidth=0.8, linestyle="--")
    error.plot(
        run.t,
        np.linalg.norm(payload - goal, axis=1),
        color=colour,
        linewidth=1.0,
        label=experiment.name,
    )
    for axes in (path, error):
        axes.grid(alpha=0.3)


FIGURES: dict[str, Callable[[Any, Sequence[Any]], None]] = {
    "hardcases": draw_cases,
    "knuckle": draw_knuckle,
    "offshore": draw_offshore,
}
"""The items that have a figure."""
