"""The figure of the league: heat maps, a row for each law of each crane, a column for each trial."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from crane_sim.explain import SceneError
from crane_sim.league.cases import COLUMNS
from crane_sim.league.played import Cell, Figures

WORST = 30.0  # times the least of a crane in a column: the darkest colour
NOTHING, LOST = "#e4e4e4", "#d94a4a"
LEAST = 1e-2  # of what is coloured, in its unit: less is nothing, for every law alike
PANELS: dict[str, Callable[[Figures], float]] = {
    "mean error of the payload, m": lambda found: found.mae,
    "largest error of the payload, m": lambda found: found.peak_error,
    "residual swing, deg": lambda found: found.residual_swing,
    "largest acceleration of the tip, m/s²": lambda found: found.tip_acceleration,
}
"""What is shown, and of which figures."""


def draw(cells: Sequence[Cell], file: Path) -> None:
    """Draw the heat maps into a PNG file.

    Raises:
        SceneError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise SceneError("--save: the figure needs matplotlib, which is not installed") from None
    rows = list(dict.fromkeys((cell.crane, cell.law) for cell in cells))
    figure = Figure(figsize=(16.0, 0.58 * len(rows) + 4.0), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, (title, value) in zip(panels.ravel(), PANELS.items(), strict=True):
        _panel(axes, rows, cells, value)
        axes.set_title(title, fontsize=11)
    for axes in panels[:, 0]:
        axes.set_yticks(range(len(rows)), [law for _, law in rows], fontsize=9)
        _braced(axes, rows)
    for axes in panels[-1]:
        axes.set_xticks(range(len(COLUMNS)), COLUMNS, rotation=35, ha="right", fontsize=9)
    figure.savefig(file, dpi=100)


def _panel(
    axes: Any, rows: Sequence[tuple[str, str]], cells: Sequence[Cell], value: Callable[[Figures], float]
) -> None:
    """Draw one heat map."""
    places = {(cell.crane, cell.law, cell.trial): cell for cell in cells}
    colours = np.full((len(rows), len(COLUMNS)), np.nan)
    for i, (crane, law) in enumerate(rows):
        for j, column in enumerate(COLUMNS):
            cell = places.get((crane, law, column))
            if cell is None or cell.refused:
                continue
            if cell.figures is not None:
                colours[i, j] = np.log(_beside(cell, cells, value))
            _written(axes, i, j, cell, value)
    axes.set_facecolor(NOTHING)
    axes.imshow(colours, cmap="Blues", vmin=0.0, vmax=1.3 * np.log(WORST), aspect="auto")
    axes.set_xticks(np.arange(len(COLUMNS) - 1) + 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", linewidth=1.0)
    axes.tick_params(which="both", length=0)
    for i in range(1, len(rows)):
        if rows[i][0] != rows[i - 1][0]:
            axes.axhline(i - 0.5, color="#222222", linewidth=1.2)


def _beside(cell: Cell, cells: Sequence[Cell], value: Callable[[Figures], float]) -> float:
    """Return a cell's value by the least of its crane and column, from 1 to WORST."""
    rivals = [c for c in cells if (c.crane, c.trial) == (cell.crane, cell.trial)]
    least = min(value(c.figures) for c in rivals if c.figures is not None and not c.failed or c is cell)
    return float(np.clip(max(value(cell.figures), LEAST) / max(least, LEAST), 1.0, WORST))


def _written(axes: Any, i: int, j: int, cell: Cell, value: Callable[[Figures], float]) -> None:
    """Write the value of a cell into row i, column j."""
    text = "fails" if cell.figures is None else f"{value(cell.figures):.2g}"
    marked = {"boxstyle": "square,pad=0.25", "facecolor": LOST, "edgecolor": "none"} if cell.failed else None
    axes.text(j, i, text, ha="center", va="center", fontsize=8, bbox=marked)


def _braced(axes: Any, rows: Sequence[tuple[str, str]]) -> None:
    """Write the names of the cranes left of their laws."""
    for crane in dict.fromkeys(crane for crane, _ in rows):
        own = [i for i, (name, _) in enumerate(rows) if name == crane]
        words = crane.replace(", ", ",\n").replace(" and ", "\nand ")
        axes.text(
            -0.235, float(np.mean(own)), words, transform=axes.get_yaxis_transform(),
            ha="center", va="center", fontsize=9, fontweight="bold",
        )  # fmt: skip
