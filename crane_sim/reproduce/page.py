"""The tables of `crane reproduce` as pages of documentation."""

from pathlib import Path
from typing import Any

from crane_sim.explain import SceneError
from crane_sim.reproduce.table import Tables, shown

LEGENDS = {
    "overhead": "Differences are relative; an erratum is a printed form that differs from first principles where the "
    "corrected one agrees.",
    "hardcases": "Error: the largest distance of any node from its reference at any instant, in metres, unless the "
    "measure says otherwise. Events: the largest error of event times, in seconds. Time: wall time of the run in "
    "seconds, without compilation.",
}
TITLES = {
    "overhead": "The overhead-crane paper: properties, numbers and misprints",
    "hardcases": "The hard cases of the overhead crane",
}


def save(tables: Tables, folder: str) -> None:
    """Write one Markdown page for each item into the folder, with a figure where the item has one.

    Raises:
        SceneError: the folder cannot be written.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        for item, rows in tables.items():
            (Path(folder) / f"{item}.md").write_text(_page(item, list(rows), _figure(item, list(rows), Path(folder))))
    except OSError as error:
        raise SceneError(f"--save {folder!r}: {error.strerror}") from None


def _page(item: str, rows: list[Any], figure: str) -> str:
    columns = rows[0]._fields
    lines = [f"# {TITLES.get(item, item)}", "", f"Written by `crane reproduce {item} --save docs`.", ""]
    lines += [LEGENDS.get(item, ""), ""]
    if figure:
        lines += [f"![{item}]({figure})", ""]
    lines += [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]
    lines += [f"| {' | '.join(shown(value).replace('|', '/') for value in row)} |" for row in rows]
    return "\n".join(lines) + "\n"


def _figure(item: str, rows: list[Any], folder: Path) -> str:
    if item != "hardcases":
        return ""
    from crane_sim.reproduce.figure import draw_cases

    draw_cases(rows, folder / f"{item}.png")
    return f"{item}.png"
