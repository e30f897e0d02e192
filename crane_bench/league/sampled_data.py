"""The data beside the page over samples: its cells, joined with those of other cranes."""

import json
from collections.abc import Sequence
from math import inf, nan
from pathlib import Path
from typing import Any

from crane_bench.league.cases import GROUPS
from crane_bench.league.sampled_cells import SampledCell
from crane_sim.files.errors import SceneError
from crane_sim.study.statistics import IntervalEstimate, PairedDifference

FILE = "league_samples.json"


def read_cells(folder: Path) -> list[SampledCell]:
    """Return the cells of a folder's data, none without a file.

    Raises:
        SceneError: the file is not this league's.
    """
    try:
        return cells_in(json.loads((folder / FILE).read_text()))
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        line = (
            f"{folder / FILE}: cannot be read as the league's data: {error!r}; remove it, or save "
            "elsewhere"
        )
        raise SceneError(line) from None


def cells_in(document: dict[str, Any]) -> list[SampledCell]:
    """Return a document's cells; null is infinite in estimates, not a number in differences."""
    return [_read_cell(entry) for entry in document["cells"]]


def _read_cell(entry: dict[str, Any]) -> SampledCell:
    controlled, difference = entry["controlled"], entry["from_best"]
    parts = {
        "controlled": controlled and IntervalEstimate(**_filled(controlled, inf)),
        "metrics": {
            name: IntervalEstimate(**_filled(value, inf))
            for name, value in entry["metrics"].items()
        },
        "from_best": difference and PairedDifference(**_filled(difference, nan)),
        "better_than": tuple(entry["better_than"]),
    }
    return SampledCell(**entry | parts)


def _filled(entry: dict[str, Any], missing: float) -> dict[str, Any]:
    """Return an object of numbers with one in place of null."""
    return {name: missing if value is None else value for name, value in entry.items()}


def join_cells(kept: Sequence[SampledCell], cells: Sequence[SampledCell]) -> list[SampledCell]:
    """Return cells, and those that are kept of the league's other cranes, in the league's order."""
    order, new = {group.name: i for i, group in enumerate(GROUPS)}, {cell.crane for cell in cells}
    others = [cell for cell in kept if cell.crane in order and cell.crane not in new]
    return sorted([*others, *cells], key=lambda cell: order.get(cell.crane, len(order)))
