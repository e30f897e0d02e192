"""The figure of the benchmark: work against precision, a panel for each scene."""

from math import ceil, isfinite
from typing import Any

from crane_bench.speed.crane_sim_engine import NAME
from crane_bench.speed.results import read_points
from crane_bench.speed.sweep import WorkPrecisionPoint
from crane_sim.report.plotting import BLUE, GREEN, GREY, RED

COLUMNS = 3
COLOURS = {
    NAME: RED,
    "hand C": "#222222",
    "CasADi C": "#8a6bbf",
    "heyoka": "#1f9e9e",
    "Pinocchio": BLUE,
    "MuJoCo": GREEN,
    "scipy": "#8c8c8c",
}
MARKS = {
    "rk4": "o",
    "rk8": "s",
    "gauss": "^",
    "dopri5": "v",
    "dop853": "D",
    "gauss16": "*",
    "rodas": "P",
    "leapfrog": "X",
}
MIN_ERROR, MAX_ERROR = 1e-14, 3.0  # m, range of the axis of errors


def draw_benchmark(figure: Any, scenes: dict[str, Any]) -> None:
    """Draw the Pareto front of every engine, and of every method of this simulator."""
    columns, rows = min(COLUMNS, len(scenes)), ceil(len(scenes) / COLUMNS)
    figure.set_size_inches(4.6 * columns, 3.5 * rows + 0.9)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[len(scenes) :]:
        axes.set_axis_off()
    for (case, scene), axes in zip(scenes.items(), panels, strict=False):
        _draw_panel(axes, case, scene)
    lines = {
        label: line
        for axes in panels
        for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        lines.values(), lines.keys(), loc="outside upper center", ncols=7, fontsize=8, frameon=False
    )


def _draw_panel(axes: Any, case: str, scene: dict[str, Any]) -> None:
    points = [
        point for point in read_points(scene) if isfinite(point.error) and point.error < MAX_ERROR
    ]
    for engine in dict.fromkeys(point.engine for point in points):
        engine_points = [point for point in points if point.engine == engine]
        if engine == NAME:
            _draw_methods(axes, engine_points)
            continue
        front = _pareto_front(engine_points)
        axes.plot(*front, color=COLOURS.get(engine, GREY), linewidth=1.6, label=engine)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(f"{case}: {scene['title']}", fontsize=8.5)
    axes.set_xlabel("µs of wall time per simulated second", fontsize=7.5)
    axes.set_ylabel("error of the payload, m", fontsize=7.5)
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.25)


def _draw_methods(axes: Any, points: list[WorkPrecisionPoint]) -> None:
    """Draw the front of every method of this simulator."""
    line = {"color": COLOURS[NAME], "linewidth": 0.7, "linestyle": "-", "markersize": 3.2}
    for method in dict.fromkeys(point.method for point in points):
        front = _pareto_front([point for point in points if point.method == method])
        axes.plot(*front, MARKS[method], label=f"{NAME} {method}", **line)


def _pareto_front(points: list[WorkPrecisionPoint]) -> tuple[list[float], list[float]]:
    """Return (times, errors) of the non-dominated points."""
    times, errors, lowest_error = [], [], float("inf")
    for point in sorted(points, key=lambda point: point.us_per_s):
        if point.error < lowest_error:
            lowest_error = point.error
            times.append(point.us_per_s)
            errors.append(max(point.error, MIN_ERROR))
    return times, errors
