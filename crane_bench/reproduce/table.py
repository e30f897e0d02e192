"""Rows of a comparison, as a table or as JSON."""

import json
import sys
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rich.console import Console
from rich.markup import escape
from rich.table import Table

Shown = float | str
Tables = Mapping[str, Sequence[Any]]
"""Rows, NamedTuples of one kind, of every item."""
_WIDE = 200  # columns of a pipe, so that each row is one line


class ClaimRow(NamedTuple):
    """One claim of a paper beside what is measured here."""

    claim: str  # with its equation number
    printed: Shown  # in the paper
    ours: Shown
    difference: float | None  # largest, relative to ours or to the scale of the matrix; None without a meaning
    verdict: str


def make_claim(claim: str, printed: Shown, ours: Shown, holds: bool, difference: float | None = None) -> ClaimRow:
    """Return the row of a claim that holds or does not."""
    return ClaimRow(claim, printed, ours, difference, "holds" if holds else "does not hold")


def print_tables(tables: Tables) -> None:
    """Print the rows of each item as a table whose columns are the rows' fields."""
    console = Console(width=None if sys.stdout.isatty() else _WIDE)
    for item, rows in tables.items():
        table = Table(*(rows[0]._fields if rows else ()), title=item, title_justify="left")
        for row in rows:
            table.add_row(*(escape(format_value(value)) for value in row))
        console.print(table, highlight=False)


def print_json(tables: Tables) -> None:
    """Print one object: for each item, a list of objects with the rows' fields."""
    print(json.dumps({item: [row._asdict() for row in rows] for item, rows in tables.items()}))


def format_value(value: Shown | None) -> str:
    """Return a value as a short text."""
    if isinstance(value, int):
        return str(value)
    return "-" if value is None else value if isinstance(value, str) else f"{value + 0.0:.3g}"
