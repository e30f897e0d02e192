"""The command `crane sweep`: a study of many runs."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from crane_sim.cli import report
from crane_sim.cli.help_lines import IntAtLeast
from crane_sim.cli.package_groups import install_groups
from crane_sim.cli.scene_options import as_json_option
from crane_sim.cli.tables import make_table, print_line

if TYPE_CHECKING:
    from crane_sim.study.execution import Progress as OnProgress
    from crane_sim.study.result import StudyResult

WIDE = 200
"""Columns of a pipe, so that no row of a table breaks."""


@click.command()
@click.argument("study", type=click.Path(path_type=Path), metavar="STUDY.yaml")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Folder of the table (default: runs/NAME).",
)
@click.option("--workers", type=IntAtLeast(1), help="Processes (default: one for each core).")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Workers of a Dask scheduler (tcp://…); local: a cluster here.",
)
@click.option(
    "--copy-to",
    metavar="URL",
    help="Also copy the finished study there (fsspec: s3://…, file:///…).",
)
@as_json_option
def sweep(
    study: Path,
    output: Path | None,
    workers: int | None,
    scheduler: str | None,
    copy_to: str | None,
    as_json: bool,
) -> None:
    """Run a study, many runs of a scene that differ in parameters, laws or seeds, as one table.

    The table is a Parquet file.

    Interrupted at any moment, the same command runs what is missing.
    """
    from crane_sim import study as studies
    from crane_sim.study import object_store
    from crane_sim.study.sensitivity import COLUMN_HEADINGS

    checked = studies.load_study(study)
    if scheduler is not None or copy_to is not None or checked.design in COLUMN_HEADINGS:
        install_groups("study")
    if copy_to is not None:
        object_store.check_store(copy_to)
    folder = output or Path("runs") / (checked.name or study.stem)
    with show_progress("runs", quiet=as_json or not sys.stderr.isatty()) as on_progress:
        result = studies.run(checked, folder, workers, scheduler, on_progress)
    if copy_to is not None:
        object_store.copy_study(folder, copy_to)
    if as_json:
        from crane_sim.study.summary import summarise

        summary = summarise(result)
        # figures: deprecated name of metrics, for one release
        print(json.dumps(report.json_value(summary | {"figures": summary["metrics"]})))
    else:
        print_result(result, Console(width=None if sys.stdout.isatty() else WIDE))


@contextmanager
def show_progress(counted: str, quiet: bool) -> Iterator[OnProgress]:
    """Yield a function that updates a progress bar on stderr labelled `counted`; `quiet`: none.

    One line says that this process compiles.
    """
    from crane_sim.tracing.compile_time import watch_compiling

    columns = (
        TextColumn(counted),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), disable=quiet) as bar:
        line = partial(
            bar.console.print,
            f"crane: {report.COMPILING}",
            highlight=False,
            markup=False,
            soft_wrap=True,
        )
        task = bar.add_task(counted, total=None)
        with watch_compiling(cache(line)):
            yield lambda done, count: bar.update(task, completed=done, total=count)


def print_result(result: StudyResult, console: Console) -> None:
    """Print failures first, then the metrics of each variant and what they differ in."""
    from crane_sim.study.summary import first_errors, summarise

    summary = summarise(result)
    for variant, count in summary["failures"].items():
        if count:
            samples = summary["runs"] // len(summary["failures"])
            console.print(
                f"{escape(variant)}: {count} of {samples} runs failed",
                style="bold red",
                highlight=False,
            )
    for line in first_errors(result):
        print_line(console, line)
    for other, each in summary["failure_differences"].items():
        if each["first_only"] + each["second_only"]:
            console.print(
                _failure_difference(next(iter(summary["failures"])), other, each), highlight=False
            )
    console.print(_metrics_table(summary))
    if len(summary["failures"]) > 1:
        console.print(_differences(summary))
    for name, by_variant in summary["sensitivities"].items():
        console.print(_sensitivities(name, by_variant, result.study.design))
    print_line(console, summary["table"])


def _failure_difference(first: str, other: str, each: dict[str, Any]) -> str:
    """Return in how many samples only one of two variants fails, with McNemar's p, in one line."""
    counts = (
        f"only {first} in {each['first_only']}, only {other} in {each['second_only']}, both in "
        f"{each['both']}"
    )
    return escape(f"failures by sample: {counts}; McNemar's p {each['p_value']:.2g}")


def _metrics_table(summary: dict[str, Any]) -> Table:
    """Return the table of the spread of metrics, of the summary of a study."""
    keys = ("runs", "least", "median", "greatest")
    rows = (
        (name if not i else "", variant, *(format_cell(by_variant[variant][key]) for key in keys))
        for name, by_variant in summary["metrics"].items()
        for i, variant in enumerate(summary["failures"])
    )
    return make_table("metrics", ("metric", "variant"), rows, keys)


def _differences(summary: dict[str, Any]) -> Table:
    """Return the table of differences of variants on the same samples, from a study's summary."""
    first, *others = summary["failures"]  # variants
    rows = []
    for name, by_variant in summary["metrics"].items():
        for i, other in enumerate(others):
            each = by_variant[f"{other} - {first}"]
            numbers = (format_cell(each[key]) for key in ("pairs", "mean", "low", "high"))
            share = "" if np.isnan(each["share"]) else f"{each['share']:.0%}"
            p = "" if np.isnan(each["p_value"]) else f"{each['p_value']:.2g}"
            rows.append((name if not i else "", other, *numbers, share, p))
    title = (
        f"differences from {first} on the same samples: mean with its 95 % interval, Wilcoxon's p"
    )
    return make_table(
        title, ("metric", "variant"), rows, ("pairs", "mean", "from", "to", "smaller", "p")
    )


def _sensitivities(metric: str, by_variant: dict[str, list[dict[str, Any]]], design: str) -> Table:
    """Return the table of how a metric depends on the parameters."""
    from crane_sim.study.sensitivity import COLUMN_HEADINGS

    rows = [
        (
            variant,
            row["parameter"],
            *(format_cell(row[key]) for key in ("strength", "interval", "interaction")),
        )
        for variant, own in by_variant.items()
        for row in own
    ]
    title = f"sensitivity of {metric} ({design.capitalize()})"
    return make_table(title, ("variant", "parameter", *COLUMN_HEADINGS[design]), rows)


def format_cell(value: float | None) -> str:
    """Return a number as tables show it, a count with all its digits; empty where there is none."""
    if isinstance(value, int):
        return str(value)
    return "" if value is None or np.isnan(value) else f"{value:.4g}"
