"""The command `crane league`: evaluate laws, print a comparison, write page, figure and data."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from crane_bench.league.cases import GROUPS, Group
from crane_bench.league.cells import Cell, evaluate_all
from crane_bench.league.figure import draw_league
from crane_bench.league.sampled_cells import SampledCell, evaluate_samples
from crane_bench.league.sampled_data import FILE, cells_in, join_cells, read_cells
from crane_bench.league.sampled_table import format_samples, list_reasons, sampled_tables
from crane_bench.league.table import format_comparison, tables_by_crane
from crane_bench.speed.store import round_floats
from crane_bench.tables import print_tables
from crane_sim.cli.report import json_value
from crane_sim.cli.sweep import show_progress
from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_text
from crane_sim.report.plotting import save_figure


def league(as_json: bool, folder: str | None, groups: Sequence[Group] = GROUPS) -> None:
    """Evaluate these groups, print tables or one JSON object, and write files.

    Page, figure and data are written where a folder is given.

    Raises:
        SceneError: the folder cannot be written.
    """
    cells = list[Cell]()
    with Console(stderr=True).status("simulating (some minutes)") as status:
        for cell in evaluate_all(groups):
            cells.append(cell)
            status.update(f"simulating: {cell.crane}, {cell.law} is done")
    if as_json:
        print(json.dumps(json_data(cells)))
    else:
        print_tables(tables_by_crane(cells))
    if folder is not None:
        save_comparison(cells, Path(folder))


def sampled_league(
    as_json: bool, folder: str | None, samples: int, output: Path, groups: Sequence[Group] = GROUPS
) -> None:
    """Evaluate these groups over samples, whose rows are in `output`; print and write as `league`.

    Raises:
        SceneError: a folder cannot be written, or `output` or the data in `folder` are another
            league's.
    """
    if folder is not None:
        read_cells(Path(folder))  # an error comes before minutes of runs
    with show_progress("runs", quiet=as_json or not sys.stderr.isatty()) as on_progress:
        cells = list(evaluate_samples(samples, output, groups, on_progress=on_progress))
    if as_json:
        print(json.dumps(sampled_json_data(cells)))
    else:
        print_tables(sampled_tables(cells))
        for title, lines in list_reasons(cells).items():
            if lines:
                print("\n- ".join([title, *lines]))
    if folder is not None:
        save_samples(cells, Path(folder))


def sampled_json_data(cells: Sequence[SampledCell]) -> dict[str, Any]:
    """Return the cells as the data of league_samples.json.

    Digits are rounded; what is not finite is null.
    """
    return json_value({"cells": round_floats([_nested(cell) for cell in cells])})


def _nested(value: Any) -> Any:
    """Return NamedTuples as objects, at any depth."""
    if hasattr(value, "_asdict"):
        value = value._asdict()
    return {key: _nested(part) for key, part in value.items()} if isinstance(value, dict) else value


def save_samples(cells: Sequence[SampledCell], folder: Path) -> None:
    """Write league_samples.md and .json into the folder; cells of other cranes there are kept.

    Raises:
        SceneError: the folder cannot be written, or its data is not this league's.
    """
    data = sampled_json_data(join_cells(read_cells(folder), cells))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / FILE, json.dumps(data, indent=1, ensure_ascii=False) + "\n")
        write_text(folder / "league_samples.md", format_samples(cells_in(data)))
    except OSError as error:
        raise SceneError(f"--save {str(folder)!r}: {error.strerror}") from None


def json_data(cells: Sequence[Cell]) -> dict[str, Any]:
    """Return the cells as the data of league.json, with rounded digits."""
    rows = [cell._asdict() | {"metrics": cell.metrics and cell.metrics._asdict()} for cell in cells]
    return {"cells": round_floats(rows)}


def save_comparison(cells: Sequence[Cell], folder: Path) -> None:
    """Write league.md, league.png and league.json into the folder.

    Raises:
        SceneError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_text(
            folder / "league.json",
            json.dumps(json_data(cells), indent=1, ensure_ascii=False) + "\n",
        )
        drawn = save_figure(draw_league, cells, folder / "league.png", dpi=100)
        write_text(folder / "league.md", format_comparison(cells, drawn))
    except OSError as error:
        raise SceneError(f"--save {str(folder)!r}: {error.strerror}") from None
