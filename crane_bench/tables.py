"""Rows as tables of a terminal or of Markdown, or as JSON."""

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.console import Console

from crane_sim.cli.tables import print_table

Shown = float | str
Tables = Mapping[str, Sequence[Any]]
"""Rows, NamedTuples of one kind, by the title of their table."""
_WIDE = 200  # columns of a pipe, so that each row is one line


def print_tables(tables: Tables) -> None:
    """Print the rows of each item as a table whose columns are the rows' fields."""
    console = Console(width=None if sys.stdout.isatty() else _WIDE)
    for item, rows in tables.items():
        head = rows[0]._fields if rows else ()
        print_table(console, item, head, ([*map(format_value, row)] for row in rows))


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown, of cells that may have vertical lines."""
    first, *others = [
        f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |\n" for cells in (head, *rows)
    ]
    return "".join([first, "|", "---|" * len(head), "\n", *others])


def print_json(tables: Tables) -> None:
    """Print one object: for each item, a list of objects with the rows' fields."""
    print(json.dumps({item: [row._asdict() for row in rows] for item, rows in tables.items()}))


def format_value(value: Shown | None) -> str:
    """Return a value as a short text."""
    if isinstance(value, int):
        return str(value)
    return "-" if value is None else value if isinstance(value, str) else f"{value + 0.0:.3g}"
