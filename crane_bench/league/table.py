"""The league as lines of tables, for a terminal and for a page of documentation."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from crane_bench.league.cells import Cell, CellMetrics
from crane_bench.league.scenes import BEST, read_tuned_gains
from crane_bench.page import fill_page
from crane_bench.tables import Shown, format_value, markdown_table

NONE = "-"
NO_EFFORT = 1e-9  # m/s², m, N or N m: smaller ones are rounding, whose digits are the processor's


class CellLine(NamedTuple):
    """A cell, as a line of a table."""

    law: str
    trial: str
    runs: Shown
    MSE_m2: Shown
    MAE_m: Shown
    peak_error_m: Shown
    residual_error_m: Shown
    peak_swing_deg: Shown
    residual_swing_deg: Shown
    settling_s: Shown
    tip_acceleration_m_s2: Shown
    effort: str
    saturated: Shown


def tables_by_crane(cells: Iterable[Cell]) -> dict[str, list[CellLine]]:
    """Return the lines of each crane; cells of laws that do not apply have none."""
    by_crane: dict[str, list[CellLine]] = {}
    for cell in cells:
        if not cell.refused:
            by_crane.setdefault(cell.crane, []).append(_line(cell))
    return by_crane


def _line(cell: Cell) -> CellLine:
    name = cell.law, f"{cell.trial}: not controlled" if cell.failed else cell.trial, cell.runs
    metrics = cell.metrics
    if metrics is None:
        return CellLine._make((*name, *[NONE] * (len(CellLine._fields) - len(name))))
    settling = NONE if metrics.settling is None else metrics.settling
    numbers = metrics._asdict() | {"settling": settling, "effort": _efforts(metrics)}
    del numbers["effort_units"]
    return CellLine._make((*name, *numbers.values()))


def _efforts(metrics: CellMetrics) -> str:
    """Return the largest effort of each joint, with its unit."""
    peaks = {joint: peak if peak > NO_EFFORT else 0.0 for joint, peak in metrics.effort.items()}
    return ", ".join(
        f"{joint} {_with_unit(peak, metrics.effort_units[joint])}" for joint, peak in peaks.items()
    )


def _with_unit(value: float, unit: str) -> str:
    """Return a value with its unit; of forces and torques in kN and MN where they are large."""
    if unit.startswith("N"):
        for size, prefix in ((1e6, "M"), (1e3, "k")):
            if value >= size:
                return f"{format_value(value / size)} {prefix}{unit}"
    return f"{format_value(value)} {unit}"


def format_comparison(cells: Sequence[Cell], drawn: bool) -> str:
    """Return the page in Markdown; `drawn`: its figure is of these cells."""
    searches = read_tuned_gains()
    return fill_page(
        "league",
        drawn=drawn,
        tables={
            crane.capitalize(): markdown_of(rows) for crane, rows in tables_by_crane(cells).items()
        },
        reasons={
            title: [
                f"{c.crane}, {c.law}, {c.trial}: {getattr(c, reason)}"
                for c in cells
                if getattr(c, reason)
            ]
            for title, reason in (("Not controlled", "failed"), ("Does not apply", "refused"))
        },
        searches=[_describe_search(name, found) for name, found in searches.items()],
        outcomes=markdown_table(
            ("search", "objective", "own gains", "tuned", "difference", "from", "to", ""),
            [row for name, found in searches.items() for row in _outcomes(name, found)],
        ),
    )


def markdown_of(rows: Sequence[Any]) -> str:
    """Return NamedTuples of one kind as a Markdown table; field names end with units."""
    head = [
        name.replace("_m_s2", ", m/s²").replace("_m2", ", m²").replace("_deg", ", deg")
        for name in rows[0]._fields
    ]
    head = [name[:-2] + f", {name[-1]}" if name.endswith(("_m", "_s")) else name for name in head]
    return markdown_table(
        [name.replace("_", " ") for name in head], [[*map(format_value, row)] for row in rows]
    )


def _describe_search(name: str, found: Mapping[str, Any]) -> str:
    """Return a line on the gains that a search has found."""
    gains = ", ".join(
        f"`{key}` {format_value(value)}" for key, value in found["chosen"][BEST]["gains"].items()
    )
    return f"**{name}**, {found['trials']} trials, {found['samples']} held-out samples: {gains}."


def _outcomes(name: str, found: Mapping[str, Any]) -> Iterator[list[str]]:
    """Yield a row per objective on how the gains do on samples that the search did not use."""
    for objective, rows in found["held_out"].items():
        own, tuned = rows[found["baseline"]], rows[BEST]
        numbers = own["mean"], tuned["mean"], tuned["difference"], tuned["low"], tuned["high"]
        missing = found["samples"] - own["runs"]
        remark = f", {missing} of {found['samples']} without with own gains" if missing else ""
        yield [name, objective + remark, *map(format_value, numbers), tuned["verdict"]]
