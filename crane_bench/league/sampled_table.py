"""The league over samples as lines of tables, for a terminal and for a page of documentation."""

import shlex
from collections.abc import Iterable, Sequence
from math import isfinite, isnan
from typing import NamedTuple

from crane_bench.league.cases import GROUPS
from crane_bench.league.sampled_cells import METRICS, SIGNIFICANCE, SampledCell
from crane_bench.league.table import NONE, markdown_of
from crane_bench.page import fill_page
from crane_bench.tables import format_value
from crane_sim.study.statistics import CONFIDENCE, IntervalEstimate, PairedDifference


class SampledLine(NamedTuple):
    """A cell, as a line of a table."""

    law: str
    trial: str
    controlled: str
    MAE_m: str
    residual_error_m: str
    residual_swing_deg: str
    settling_s: str
    from_the_best_m: str
    better_than: str


def sampled_tables(cells: Iterable[SampledCell]) -> dict[str, list[SampledLine]]:
    """Return the lines of each crane; cells of laws that do not apply have none."""
    by_crane: dict[str, list[SampledLine]] = {}
    for cell in cells:
        if not cell.refused:
            by_crane.setdefault(cell.crane, []).append(_sampled_line(cell))
    return by_crane


def _sampled_line(cell: SampledCell) -> SampledLine:
    assert cell.controlled is not None, "a cell that is not refused has metrics"
    metrics = (format_estimate(cell.metrics[name]) for name in METRICS)
    better = "; ".join(cell.better_than) or NONE  # names of laws may have commas
    share = format_estimate(IntervalEstimate(*(100.0 * part for part in cell.controlled)), " %")
    return SampledLine._make(
        (
            cell.law,
            cell.trial,
            share,
            *metrics,
            _format_difference(cell.from_best, cell.samples),
            better,
        )
    )


def format_estimate(estimate: IntervalEstimate, unit: str = "") -> str:
    """Return a number with its interval; `-` in place of what is infinite."""
    value, low, high = (format_value(part) if isfinite(part) else NONE for part in estimate)
    return NONE if value == NONE and low == NONE else f"{value}{unit} ({low} … {high})"


def _format_difference(difference: PairedDifference | None, samples: int) -> str:
    if difference is None:
        return "best"
    if isnan(difference.mean):
        return NONE
    text = format_estimate(IntervalEstimate(difference.mean, difference.low, difference.high))
    return text if difference.pairs == samples else f"{text}, {difference.pairs} pairs"


def command_of(samples: int, cranes: Iterable[str] = ()) -> str:
    """Return the command that writes the page of these cranes (none: all), without `crane`."""
    named = "".join(f"--crane {shlex.quote(crane)} " for crane in cranes)
    return f"league --samples {samples} {named}--save docs"


def _list_commands(cells: Sequence[SampledCell]) -> str:
    """Return the commands that write the page of these cells: one for each number of samples."""
    cranes = dict[int, dict[str, None]]()
    for cell in cells:
        cranes.setdefault(cell.samples, {})[cell.crane] = None
    whole = (
        len(cranes) == 1
        and cells
        and {cell.crane for cell in cells} >= {group.name for group in GROUPS}
    )
    return " and ".join(
        f"`crane {command_of(n, () if whole else names)}`" for n, names in cranes.items()
    )


def describe_samples(samples: int, laws: int) -> str:
    """Return a line on a crane's numbers of samples, and on the limits of few samples."""
    text = f"{samples} samples of each trial."
    pairs = laws * (laws - 1) // 2
    if pairs and pairs * 2.0 ** (1 - samples) >= SIGNIFICANCE:
        text += f" With so few no difference among {laws} laws can be significant."
    if 2.0 ** (1 - samples) > 1.0 - CONFIDENCE:
        text += " The 95 % intervals of medians are too narrow with so few."
    return text


def format_samples(cells: Sequence[SampledCell]) -> str:
    """Return the page in Markdown."""
    samples = {cell.crane: cell.samples for cell in cells}
    tables = sampled_tables(cells)
    cranes = [
        (
            crane.capitalize(),
            describe_samples(samples[crane], len({line.law for line in lines})),
            markdown_of(lines),
        )
        for crane, lines in tables.items()
    ]
    return fill_page(
        "league_samples", commands=_list_commands(cells), cranes=cranes, reasons=list_reasons(cells)
    )


def list_reasons(cells: Sequence[SampledCell]) -> dict[str, list[str]]:
    """Return lines on why runs of cells failed, and why laws do not apply, by title."""
    reasons = {"Runs that failed": _failure, "Does not apply": lambda cell: cell.refused}
    return {
        title: [f"{c.crane}, {c.law}, {c.trial}: {reason_of(c)}" for c in cells if reason_of(c)]
        for title, reason_of in reasons.items()
    }


def _failure(cell: SampledCell) -> str:
    """Return why runs of a cell failed, empty where none did."""
    counts = {"scenes are infeasible": cell.refused_runs, "runs failed": cell.failed_runs}
    parts = "".join(
        f"{count} of {cell.samples} {what}; " for what, count in counts.items() if count
    )
    return cell.failed and f"{parts}the first reason: {cell.failed}"
