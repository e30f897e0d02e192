"""The page of documentation that is written from the benchmark's data file."""

from typing import Any

from crane_bench.page import fill_page
from crane_bench.speed import tables
from crane_bench.speed.measurement import describe_machine
from crane_bench.speed.suites import SUITES

FIGURES = {"scenes": "performance.png", "bodies": "performance_bodies.png"}
"""Files of the figures, by suite."""


def format_page(data: dict[str, Any], drawn: bool) -> str:
    """Return the page in Markdown; `drawn`: it has a figure."""
    scenes = {} if "scenes" not in data else _describe_scenes(data["scenes"])
    suites = [
        (suite.title, FIGURES.get(name) if drawn else None, "\n".join(suite.format(data[name])))
        for name, suite in SUITES.items()
        if name in data
    ]
    return fill_page(
        "performance", scenes=scenes, drawn=drawn, figure=FIGURES["scenes"], suites=suites
    )


def _describe_scenes(scenes: dict[str, Any]) -> dict[str, Any]:
    """Return what the page says of the scenes: machine, and tables."""
    makers = tables.cheapest_table, tables.target_table, tables.tension_table, tables.other_table
    return {"machine": _machine(scenes), "tables": [make(scenes) for make in makers]}


def _machine(scenes: dict[str, Any]) -> str:
    named = ", ".join(f"{name} {version}" for name, version in scenes["engines"].items())
    lines = [
        f"Measured on {scenes['date']}: {describe_machine(scenes['machine'])}. Engines: {named}."
    ]
    lines += [f"Not there: {name} ({why})." for name, why in scenes["missing"].items()]
    return "".join(lines)
