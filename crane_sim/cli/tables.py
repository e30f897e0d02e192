"""Tables of the terminal: cells are plain text, and long names are broken, not cut."""

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table


def make_table(title: str, head: Iterable[str], rows: Iterable[Sequence[str]]) -> Table:
    """Return a table with a row of cells for each of `rows`; without a title where that is empty."""
    columns = [Column(escape(name), overflow="fold") for name in head]
    table = Table(*columns, title=escape(title) if title else None, title_justify="left")
    for row in rows:
        table.add_row(*map(escape, row))
    return table


def print_table(console: Console, title: str, head: Iterable[str], rows: Iterable[Sequence[str]]) -> None:
    """Print the table of `make_table`."""
    console.print(make_table(title, head, rows), highlight=False)
