"""Pages of documentation that are written from the tables of `crane reproduce`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crane_bench.page import fill_page
from crane_bench.reproduce.figure import FIGURES
from crane_bench.reproduce.overhead_erratum import ROUNDING
from crane_bench.tables import Tables, format_value, markdown_table
from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_text
from crane_sim.report.plotting import save_figure

# columns of `Row`, where digits below ROUNDING are those of the processor
BY_ROUNDING = ("ours", "difference")
TITLES = {
    "overhead": "The overhead-crane paper: properties, numbers and misprints",
    "hardcases": "The hard cases of the overhead crane",
    "knuckle": "The knuckle paper's section 4: energy law against LQR",
    "offshore": "The offshore paper's tables 5, 7 and 9",
    "observer": "The harmonic observer on seas that it was not tuned to",
}


def save_pages(tables: Tables, folder: str) -> None:
    """Write one Markdown page for each item into the folder, with a figure where the item has one.

    Raises:
        SceneError: the folder cannot be written.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        for item, rows in tables.items():
            draw, picture = FIGURES.get(item), Path(folder) / f"{item}.png"
            drawn = draw is not None and save_figure(draw, rows, picture, dpi=120)
            write_text(Path(folder) / f"{item}.md", _write_item(item, list(rows), drawn))
    except OSError as error:
        raise SceneError(f"--save {folder!r}: {error.strerror}") from None


def _format_cell(column: str, value: Any, varies: Sequence[str]) -> str:
    """Return a value as text: one digit where it varies, and none of what only rounding makes."""
    if isinstance(value, float) and column in varies:
        return f"{value:.1g}"
    if isinstance(value, float) and column in BY_ROUNDING and 0.0 < abs(value) < ROUNDING:
        return f"< {ROUNDING:.0e}"
    return format_value(value)


def _write_item(item: str, rows: list[Any], drawn: bool) -> str:
    columns, varies = rows[0]._fields, getattr(rows[0], "VARIES", ())
    heads = [f"{name} \\*" if name in varies else name for name in columns]
    cells = [[*map(_format_cell, columns, row, [varies] * len(columns))] for row in rows]
    table = markdown_table(heads, cells)
    return fill_page(
        "reproduction",
        item=item,
        title=TITLES.get(item, item),
        drawn=drawn,
        varies=varies,
        table=table,
    )
