"""The summary of a run inside its recording: a table for people and properties for programs."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from crane_sim.recording.metric_units import metric_label, plain_unit
from crane_sim.simulation.flat_summary import leaves

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

_UNITS = {"final_error": "rad, m", "peak_effort": "N m, N"}  # of metrics whose entries have different ones


def summary_properties(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the summary as flat recording properties, and once whole under `json`."""
    flat = {name: value for name, value in leaves(summary) if isinstance(value, str | bool | int | float)}
    return flat | {"json": json.dumps(summary, default=_plain_number)}


def summary_table(title: str, summary: Mapping[str, Any], path_unit: str) -> str:
    """Return the summary as a markdown document: plain values first, then what is given per joint or per kind.

    `path_unit` is the unit of the path's coordinates, empty where they have different ones.
    """
    plain = [key for key, value in summary.items() if not isinstance(value, dict)]
    rows = [[metric_label(key), _format_quantity(summary[key], _unit(key, path_unit))] for key in plain]
    parts = [f"# {title}", markdown_table(["quantity", "value"], rows)]
    groups: dict[tuple[str, ...], list[str]] = {}  # those with the same entries stand side by side
    for key, value in summary.items():
        if isinstance(value, dict) and value:
            groups.setdefault(tuple(value), []).append(key)
    for entries, keys in groups.items():
        units = [_unit(key, path_unit) for key in keys]
        heads = [
            f"{metric_label(key)} [{unit}]" if unit else metric_label(key)
            for key, unit in zip(keys, units, strict=True)
        ]
        rows = [[metric_label(entry), *(_format_quantity(summary[key][entry]) for key in keys)] for entry in entries]
        parts.append(markdown_table(["", *heads], rows))
    return "\n\n".join(parts) + "\n"


def _plain_number(value: Any) -> Any:
    """Return a number of numpy as one of Python."""
    return value.item()


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in markdown: columns of numbers behind one of words."""
    lines = [header, ["---"] + ["---:"] * (len(header) - 1), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _unit(key: str, path_unit: str) -> str:
    return _UNITS.get(key) or plain_unit(key, path_unit).replace("deg", "°")


def _format_quantity(value: Any, unit: str = "") -> str:
    if value is None:
        return "–"
    text = f"{value:.5g}" if isinstance(value, float) else str(value)
    return f"{text} {unit}".strip()
