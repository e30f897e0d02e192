"""The command `crane league`: evaluate every law, print the comparison, write page, figure and data."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from crane_sim.evaluation.bench.store import round_floats
from crane_sim.evaluation.league.cases import GROUPS, Group
from crane_sim.evaluation.league.cells import Cell, evaluate_all
from crane_sim.evaluation.league.figure import draw_league
from crane_sim.evaluation.league.table import format_comparison, tables_by_crane
from crane_sim.evaluation.plotting import save_figure
from crane_sim.evaluation.reproduce.table import print_tables
from crane_sim.files.errors import SceneError


def league(as_json: bool, folder: str | None, groups: Sequence[Group] = GROUPS) -> None:
    """Evaluate these groups, print tables or one JSON object, and write page, figure and data into a folder if given.

    Raises:
        SceneError: the folder cannot be written.
    """
    cells = list[Cell]()
    with Console(stderr=True).status("simulating (some minutes)") as status:
        for cell in evaluate_all(groups):
            cells.append(cell)
            status.update(f"simulating: {cell.crane}, {cell.law} is done")
    if as_json:
        print(json.dumps(document(cells)))
    else:
        print_tables(tables_by_crane(cells))
    if folder is not None:
        save_comparison(cells, Path(folder))


def document(cells: Sequence[Cell]) -> dict[str, Any]:
    """Return the cells as a document, with rounded digits."""
    rows = [cell._asdict() | {"figures": cell.figures and cell.figures._asdict()} for cell in cells]
    return {"cells": round_floats(rows)}


def save_comparison(cells: Sequence[Cell], folder: Path) -> None:
    """Write league.md, league.png and league.json into the folder.

    Raises:
        SceneError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "league.json").write_text(json.dumps(document(cells), indent=1, ensure_ascii=False) + "\n")
        drawn = save_figure(draw_league, cells, folder / "league.png", dpi=100)
        (folder / "league.md").write_text(format_comparison(cells, drawn))
    except OSError as error:
        raise SceneError(f"--save {str(folder)!r}: {error.strerror}") from None
