"""The page of documentation on the results of the soak tests."""

from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from crane_bench.page import fill_page
from crane_bench.soak import plots
from crane_bench.soak.metrics import Metric
from crane_bench.speed.measurement import describe_machine
from crane_bench.tables import markdown_table


class Part(NamedTuple):
    """A section of the page."""

    title: str
    data_keys: tuple[str, ...] = ()  # keys of the data that the plot shows
    draw: Callable[[Any, dict[str, Any]], None] | None = None  # into a matplotlib figure
    series: bool = False  # they are samples over time, which may be thinned


PARTS = {
    "kill": Part("Nodes that are killed", ("back_s",), plots.draw_kill),
    "signals": Part(
        "Runs that are interrupted", ("at", "took", "fresh", "code"), plots.draw_signals
    ),
    "memory": Part(
        "Long runs over ROS",
        ("seconds", "steps_per_second", "memory_MB"),
        plots.draw_memory,
        series=True,
    ),
    "inprocess": Part(
        "Long runs without ROS", ("Plant.advance", "simulate"), plots.draw_inprocess, series=True
    ),
    "determinism": Part("One scene, one run"),
    "realtime": Part("Real time at 1 kHz"),
}
"""The soak tests; what each does is said in the page."""


def write_findings(documents: Mapping[str, Mapping[str, Any]], drawn: Collection[str]) -> str:
    """Return the page in Markdown.

    Args:
        documents: the document of each part that was run: command, machine, metrics, data.
        drawn: the parts that have a plot.
    """
    return fill_page(
        "soak",
        parts={part: None for part in PARTS}
        | {
            part: {
                "title": PARTS[part].title,
                "command": document["command"],
                "machine": describe_machine(document["machine"]),
                "picture": f"soak/{part}.png" if part in drawn else "",
                "table": markdown_table(
                    ("metric", "measured", "required", "passed"), map(_cells, document["metrics"])
                ),
            }
            for part, document in documents.items()
        },
    )


def _cells(metric: Metric) -> tuple[str, str, str, str]:
    verdict = ("yes" if metric.passed else "**no**") if metric.requirement else ""
    return metric.what, metric.format_value(), metric.requirement, verdict
