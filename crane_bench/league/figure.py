"""The figure of the league: heat maps, a row for each crane's law, a column for each trial."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from crane_bench.league.cases import COLUMNS
from crane_bench.league.cells import Cell, CellMetrics

WORST = 30.0  # times the least of a crane in a column: the darkest colour
NOTHING, LOST = "#e4e4e4", "#e8705f"
WORDS = (
    f"white: the least of a crane's laws in the column; darkest: {WORST:g} times that or more; "
    "grey: does not apply; red: not controlled"
)


class Panel(NamedTuple):
    """One heat map."""

    title: str
    value: Callable[[CellMetrics], float]
    least: float  # what is smaller has the colour of this


PANELS = (
    Panel("mean error of the payload, m", lambda metrics: metrics.mae, 1e-3),
    Panel(
        "largest error of the payload in the last quarter, m",
        lambda metrics: metrics.residual_error,
        1e-3,
    ),
    Panel("residual swing, deg", lambda metrics: metrics.residual_swing, 0.1),
    Panel("largest acceleration of the tip, m/s²", lambda metrics: metrics.tip_acceleration, 0.01),
)


def draw_league(figure: Any, cells: Sequence[Cell]) -> None:
    """Draw the heat maps."""
    rows = list(dict.fromkeys((cell.crane, cell.law) for cell in cells))
    figure.set_size_inches(16.0, 0.58 * len(rows) + 4.0)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, panel in zip(panels.ravel(), PANELS, strict=True):
        _draw_panel(axes, rows, cells, panel)
        axes.set_title(panel.title, fontsize=11)
    for axes in panels[:, 0]:
        axes.set_yticks(range(len(rows)), [law for _, law in rows], fontsize=9)
        _write_cranes(axes, rows)
    for axes in panels[-1]:
        axes.set_xticks(range(len(COLUMNS)), COLUMNS, rotation=35, ha="right", fontsize=9)
    figure.supxlabel(WORDS, fontsize=10)


def _draw_panel(
    axes: Any, rows: Sequence[tuple[str, str]], cells: Sequence[Cell], panel: Panel
) -> None:
    """Draw one heat map."""
    cells_by_name = {(cell.crane, cell.law, cell.trial): cell for cell in cells}
    colours = np.full((len(rows), len(COLUMNS)), np.nan)
    for i, (crane, law) in enumerate(rows):
        for j, column in enumerate(COLUMNS):
            cell = cells_by_name.get((crane, law, column))
            if cell is None or cell.refused:
                continue
            if cell.metrics is not None:
                colours[i, j] = np.log(_relative(cell.metrics, rivals(cell, cells), panel))
            _write_value(axes, i, j, cell, panel)
    axes.set_facecolor(NOTHING)
    axes.imshow(colours, cmap="Blues", vmin=0.0, vmax=1.6 * np.log(WORST), aspect="auto")
    axes.set_xticks(np.arange(len(COLUMNS) - 1) + 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", linewidth=1.0)
    axes.tick_params(which="both", length=0)
    for i in range(1, len(rows)):
        if rows[i][0] != rows[i - 1][0]:
            axes.axhline(i - 0.5, color="#222222", linewidth=1.2)


def rivals(cell: Cell, cells: Sequence[Cell]) -> list[CellMetrics]:
    """Return the metrics of all laws that keep the same crane under control in the same trial."""
    same = [other for other in cells if (other.crane, other.trial) == (cell.crane, cell.trial)]
    return [other.metrics for other in same if other.metrics is not None and not other.failed]


def _relative(cell_metrics: CellMetrics, others: Sequence[CellMetrics], panel: Panel) -> float:
    """Return a value divided by the least of the others, from 1 to WORST."""
    values = [max(panel.value(metrics), panel.least) for metrics in (cell_metrics, *others)]
    return min(values[0] / min(values), WORST)


def _write_value(axes: Any, i: int, j: int, cell: Cell, panel: Panel) -> None:
    """Write the value of a cell into row i, column j."""
    text = "fails" if cell.metrics is None else _short(panel.value(cell.metrics))
    marked = (
        {"boxstyle": "square,pad=0.25", "facecolor": LOST, "edgecolor": "none"}
        if cell.failed
        else None
    )
    axes.text(j, i, text, ha="center", va="center", fontsize=8, bbox=marked)


def _short(value: float) -> str:
    return "<1e-4" if value < 1e-4 else f"{value:.2g}" if value < 100.0 else f"{value:.0f}"


def _write_cranes(axes: Any, rows: Sequence[tuple[str, str]]) -> None:
    """Write the names of the cranes left of their laws."""
    for crane in dict.fromkeys(crane for crane, _ in rows):
        indices = [i for i, (name, _) in enumerate(rows) if name == crane]
        words = crane.replace(", ", ",\n").replace(" and ", "\nand ")
        axes.text(
            -0.27, float(np.mean(indices)), words, transform=axes.get_yaxis_transform(),
            ha="center", va="center", fontsize=9, fontweight="bold",
        )  # fmt: skip
