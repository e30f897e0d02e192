"""Tables of the terminal: cells are plain text; narrow ones break names, but no numbers."""

from collections.abc import Iterable, Sequence

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table


def make_table(
    title: str, head: Iterable[str], rows: Iterable[Sequence[str]], numbers: Sequence[str] = ()
) -> Table:
    """Return a table with a row of cells for each of `rows`; without a title where that is empty.

    `numbers`: headings of further columns, which have numbers.
    """
    columns = [Column(escape(name), overflow="fold") for name in head]
    columns += [Column(escape(name), no_wrap=True, justify="right") for name in numbers]
    style = {"box": box.SIMPLE_HEAD, "padding": (0, 1, 0, 0), "title_justify": "left"}
    table = Table(*columns, title=escape(title) if title else None, **style)
    for row in rows:
        table.add_row(*map(escape, row))
    return table


def print_table(
    console: Console, title: str, head: Iterable[str], rows: Iterable[Sequence[str]]
) -> None:
    """Print the table of `make_table`."""
    console.print(make_table(title, head, rows), highlight=False)


def print_line(console: Console, line: str, style: str | None = None) -> None:
    """Print a line of plain text, which only a terminal breaks."""
    console.print(line, style=style, highlight=False, markup=False, soft_wrap=True)
