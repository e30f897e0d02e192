"""What `crane league` does: play, print, keep."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from crane_sim.evaluation.bench.store import round_floats
from crane_sim.evaluation.league.cases import GROUPS, Group
from crane_sim.evaluation.league.cells import Cell, cells
from crane_sim.evaluation.league.figure import draw
from crane_sim.evaluation.league.table import lines, write_comparison
from crane_sim.evaluation.reproduce.table import print_tables
from crane_sim.files.errors import SceneError


def league(as_json: bool, folder: str | None, groups: Sequence[Group] = GROUPS) -> None:
    """Play these groups, print tables or one JSON object, and write page, figure and data into a folder if given.

    Raises:
        SceneError: the folder cannot be written, or the figure not drawn.
    """
    found = list[Cell]()
    with Console(stderr=True).status("playing (some minutes)") as status:
        for cell in cells(groups):
            found.append(cell)
            status.update(f"playing: {cell.crane}, {cell.law} is done")
    if as_json:
        print(json.dumps(document(found)))
    else:
        print_tables(lines(found))
    if folder is not None:
        save_comparison(found, Path(folder))


def document(found: Sequence[Cell]) -> dict[str, Any]:
    """Return the cells as a document, digits rounded to what has a meaning."""
    told = [cell._asdict() | {"figures": cell.figures and cell.figures._asdict()} for cell in found]
    return {"cells": round_floats(told)}


def save_comparison(found: Sequence[Cell], folder: Path) -> None:
    """Write league.md, league.png and league.json into the folder.

    Raises:
        SceneError: the folder cannot be written, or matplotlib is not installed.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "league.json").write_text(json.dumps(document(found), indent=1, ensure_ascii=False) + "\n")
        draw(found, folder / "league.png")
        (folder / "league.md").write_text(write_comparison(found))
    except OSError as error:
        raise SceneError(f"--save {str(folder)!r}: {error.strerror}") from None
