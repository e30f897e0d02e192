"""Figures of the papers' experiments, drawn from runs made for them: the same scenes and laws as their tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from crane_sim.reproduce import knuckle, offshore
from crane_sim.rollout import Rollout

FIRST, SECOND, GOAL = "#2a78b8", "#c43d3d", "#555555"
LAWS = ("energy law", FIRST), ("LQR", SECOND)


def draw_knuckle(figure: Any) -> None:
    """Draw joints, swing and efforts of both laws over time, as figures 3 to 10 of the knuckle paper."""
    runs = knuckle.pair()
    target = runs.energy.scene.reference
    assert target is not None
    panels = figure.subplots(5, 2, sharex=True).ravel()
    names = ("tower, deg", "boom, deg", "jib, deg", "rope, m", "theta1, deg", "theta2, deg")
    for i, name in enumerate(names):
        scale = 1.0 if i == 3 else 180.0 / np.pi
        panels[i].axhline(scale * (target[i] if i < 4 else 0.0), color=GOAL, linewidth=0.8, linestyle="--")
        _both(panels[i], runs, [scale * run.q[:, i] for run in runs[:2]], f"Fig. {3 + i}: {name}")
    for i in range(4):
        unit = "N" if i == 3 else "N m"
        _both(panels[6 + i], runs, [run.u[:, i] for run in runs[:2]], f"Fig. {9 + i // 2}: u{i + 1}, {unit}")
    panels[0].legend(fontsize=8)
    for panel in panels[-2:]:
        panel.set_xlabel("t, s")


def _both(axes: Any, runs: knuckle.Pair, values: Sequence[Any], title: str) -> None:
    for (label, colour), run, value in zip(LAWS, runs[:2], values, strict=True):
        axes.plot(run.t, value, color=colour, linewidth=1.0, label=label)
    axes.set_title(title, fontsize=9)
    axes.grid(alpha=0.3)


def draw_offshore(figure: Any) -> None:
    """Draw paths of the payload, left, and the size of its error over time, right; one row for each table."""
    panels = figure.subplots(3, 2, width_ratios=(1, 2))
    for (path, error), experiments in zip(panels, offshore.PAIRS, strict=True):
        for colour, experiment in zip((SECOND, FIRST), experiments, strict=True):
            run = offshore.run(experiment)
            _tracked(path, error, run, experiment.claim.partition(", ")[2], colour)
        error.set_title(f"{experiments[0].claim.partition(',')[0]}: error of the payload", fontsize=9)
        error.set_ylabel("m")
        error.legend(fontsize=8)
    panels[-1][0].set_xlabel("x, m")
    panels[-1][1].set_xlabel("t, s")


def _tracked(path: Any, error: Any, run: Rollout, label: str, colour: str) -> None:
    found, goal = offshore.followed(run)
    path.plot(*found.T, color=colour, linewidth=1.0)
    path.plot(*goal.T, color=GOAL, linewidth=0.8, linestyle="--")
    path.set_aspect("equal")
    path.set_ylabel("y, m")
    path.grid(alpha=0.3)
    error.semilogy(run.t, np.maximum(np.linalg.norm(found - goal, axis=1), 1e-6), color=colour, linewidth=1.0, label=label)
    error.grid(alpha=0.3)


def save_figure(draw: Any, size: tuple[float, float], file: Path) -> None:
    """Write what `draw` draws, on a figure of this size [inch]."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    draw(figure)
    figure.savefig(file, dpi=120)
