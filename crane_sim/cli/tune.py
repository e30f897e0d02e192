"""The command `crane tune`: gains searched over the samples of a study."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console

from crane_sim.cli.help_lines import IntAtLeast
from crane_sim.cli.package_groups import install_groups
from crane_sim.cli.report import json_value
from crane_sim.cli.run_options import ensure_writable_file
from crane_sim.cli.scene_options import as_json_option
from crane_sim.cli.sweep import format_cell, show_progress
from crane_sim.cli.tables import print_line, print_table
from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_output

if TYPE_CHECKING:
    from crane_sim.study.tuning import TuningResult


@click.command()
@click.argument("study", type=click.Path(path_type=Path), metavar="STUDY.yaml")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Folder of the search (default: runs/NAME).",
)
@click.option("--trials", type=IntAtLeast(1), help="Trials of the search (default: the file's).")
@click.option("--workers", type=IntAtLeast(1), help="Processes (default: one for each core).")
@click.option(
    "--save",
    type=click.Path(path_type=Path),
    metavar="FILE.json",
    help="Also add the result to this file.",
)
@as_json_option
def tune(
    study: Path,
    output: Path | None,
    trials: int | None,
    workers: int | None,
    save: Path | None,
    as_json: bool,
) -> None:
    """Tune gains of a law: search them over a study's samples, and evaluate the best on others.

    An interrupted search can be resumed with the same command; a larger --trials extends it.
    """
    from crane_sim.study import tuning
    from crane_sim.study.schema import load_study

    definition = load_study(study)
    if save is not None:  # before the search, which may take hours
        _read_summaries(save)
    install_groups("study")
    if trials is not None and definition.tune is not None:
        definition = definition.model_copy(
            update={"tune": definition.tune.model_copy(update={"trials": trials})}
        )
    folder = output or Path("runs") / (definition.name or study.stem)
    with show_progress("trials", quiet=as_json or not sys.stderr.isatty()) as on_progress:
        result = tuning.tune(definition, folder, workers, on_progress)
    summary = tuning.summarise(result)
    if save is not None:
        summaries = _read_summaries(save) | {summary["study"]: json_value(summary)}
        write_output("--save", save, lambda file: file.write_text(_json_lines(summaries)))
    if as_json:
        print(json.dumps(json_value(summary)))
    else:
        print_result(result, summary, folder, Console())


def _read_summaries(file: Path) -> dict[str, Any]:
    """Return the summaries in a file, none without one; raises SceneError if it can have none."""
    ensure_writable_file("--save", file)
    try:
        summaries = json.loads(file.read_text()) if file.exists() else {}
    except (OSError, ValueError) as error:
        raise SceneError(f"--save {file}: {error}") from None
    if not isinstance(summaries, dict):
        raise SceneError(
            f"--save {file}: holds no summaries of searches by the names of their studies"
        )
    return summaries


def _json_lines(summaries: dict[str, Any]) -> str:
    return json.dumps(dict(sorted(summaries.items())), indent=1) + "\n"


def print_result(
    result: TuningResult, summary: dict[str, Any], folder: Path, console: Console
) -> None:
    """Print the chosen gains, and their held-out objectives compared with the baseline's."""
    counts = (
        f"{summary['trials']} trials, {summary['infeasible']} of them infeasible; "
        f"{len(result.front)} Pareto-optimal"
    )
    console.print(counts, highlight=False)
    chosen = summary["chosen"]
    gains = [
        (key, *(format_cell(each["gains"][key]) for each in chosen.values()))
        for key in next(iter(result.chosen.values())).gains
    ]
    print_table(console, "gains", ("gain", *chosen), gains)
    for objective, rows in summary["held_out"].items():
        title = (
            f"{objective} on {summary['samples']} held-out samples, and the difference from "
            f"{summary['baseline']}"
        )
        head = ("gains", "runs", "mean", "difference", "from", "to", "")
        print_table(console, title, head, (_objective_row(*row) for row in rows.items()))
    print_line(console, f"{folder / 'gains.yaml'}: gains; {result.held_out.folder}: crane report")


def _objective_row(variant: str, row: dict[str, Any]) -> tuple[str, ...]:
    """Return an objective of gains: its mean, and the mean difference with its 95 % interval."""
    numbers = (row.get(key) for key in ("mean", "difference", "low", "high"))
    return variant, str(row["runs"]), *map(format_cell, numbers), row.get("verdict", "")
