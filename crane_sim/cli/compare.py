"""The command `crane compare`: runs of one crane side by side."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.console import Console

from crane_sim.cli import report
from crane_sim.cli.scene_options import as_json_option, load_scene_with_options
from crane_sim.cli.tables import print_line, print_table
from crane_sim.cli.viewing import check_output, find_recording
from crane_sim.files.errors import SceneError
from crane_sim.recording.metric_units import metric_row, shown_unit

if TYPE_CHECKING:
    from crane_sim.recording.comparison import Comparison
    from crane_sim.simulation.rollout import Rollout


@click.command("compare")
@click.argument("runs", nargs=-1, required=True, metavar="RUN RUN ...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Write all runs in one scene: .html or .rrd.",
)
@click.option(
    "--laws",
    default="",
    metavar="A,B,...",
    help="Simulate the SCENE given as RUN with each law first.",
)
@as_json_option
def compare_runs(runs: tuple[str, ...], output: Path | None, laws: str, as_json: bool) -> None:
    """Compare runs of one crane with the first: recordings, or the laws of --laws on one scene."""
    from crane_sim.laws import LawError
    from crane_sim.recording.comparison import compare

    if output is not None:
        check_output(output, Path(runs[0]), ".html", ".rrd")
        _check_output_is_new(output, runs)
    failed: list[str] = []
    if laws:
        rollouts, failed = _simulate(runs[0], _law_names(laws, runs), quiet=as_json)
        comparison = compare(*rollouts.values(), names=list(rollouts))
    else:
        comparison = compare(*(find_recording(Path(run)) for run in runs))
    if output is not None:
        _save(comparison, output)
    if as_json:
        print(json.dumps(report.json_value(comparison.to_dict())))
    else:
        print_comparison(comparison)
        if output is not None:
            print(output)
    if failed:
        raise LawError("; ".join(failed))


def _check_output_is_new(output: Path, runs: Sequence[str]) -> None:
    for run in runs:
        if output.exists() and Path(run).exists() and output.samefile(run):
            raise SceneError(f"--output {output}: is one of the runs that are compared")


def _save(comparison: Comparison, output: Path) -> None:
    if output.suffix == ".rrd":
        from crane_sim.recording.rerun.comparison import record_comparison

        record_comparison(comparison, output)
    else:
        from crane_sim.report.page import save_comparison

        save_comparison(comparison, output)


def _law_names(laws: str, runs: Sequence[str]) -> list[str]:
    names = [name.strip() for name in laws.split(",") if name.strip()]
    if len(runs) != 1:
        raise SceneError(
            f"--laws = {laws!r}: takes one SCENE, here are {len(runs)}: {', '.join(runs)}"
        )
    if len(set(names)) < max(2, len(names)):
        raise SceneError(
            f"--laws = {laws!r}: must be two different laws or more, with commas between them"
        )
    return names


def _simulate(
    source: str, laws: Sequence[str], quiet: bool
) -> tuple[dict[str, Rollout], list[str]]:
    """Return a scene's runs by law, all validated first, and a line for each law that failed.

    A run whose integration failed ends at the failure; of one whose law failed nothing is left.

    Raises:
        LawError: laws failed, and fewer than two runs are left to compare; the message names them.
    """
    from crane_sim.laws import LawError
    from crane_sim.simulation.plant import SimulationError
    from crane_sim.simulation.rollout import simulate

    scenes = {law: load_scene_with_options(source, law=law) for law in laws}
    rollouts: dict[str, Rollout] = {}
    failed: list[str] = []
    for law, scene in scenes.items():
        with report.compiling(quiet=quiet):
            try:
                rollouts[law] = simulate(scene)
            except SimulationError as error:
                rollouts[law] = error.run
            except LawError as error:
                failed.append(f"law {law!r}: {error}")
    if len(rollouts) < 2:
        raise LawError("; ".join(failed))
    return rollouts, failed


def print_comparison(comparison: Comparison) -> None:
    """Print the metrics that differ or matter, and the largest differences of every quantity."""
    names, console = comparison.names, Console()
    first, *others = names
    _print_metrics(comparison, console)
    for name, run in zip(names, comparison.runs, strict=True):
        if not run.finished:
            print_line(console, f"{name}: {run.status}")
        if run.real_time_violation:
            print_line(console, f"{name}: {run.real_time_violation}")
    title = f"differences from {first}, {comparison.t[0]:g} .. {comparison.t[-1]:g} s"
    head = ("run", "quantity", "largest", "at [s]", "RMS", "unit")
    print_table(console, title, head, _difference_rows(comparison))
    for name, left_out in zip(others, comparison.not_compared, strict=True):
        if left_out:
            line = (
                f"{name}, not compared, has no finite values in one of the runs: "
                f"{', '.join(left_out)}"
            )
            print_line(console, line)


def _print_metrics(comparison: Comparison, console: Console) -> None:
    """Print the metrics of every run, and their differences from the first."""
    first, *others = comparison.names
    head = ("metric", *comparison.names, *(f"{name} − {first}" for name in others), "unit")
    metrics = (
        metric_row(key, comparison.runs, values) for key, values in comparison.metrics.items()
    )
    print_table(console, "metrics", head, ((label, *shown, unit) for label, unit, shown in metrics))


def _difference_rows(comparison: Comparison) -> Iterator[tuple[str, ...]]:
    """Yield the differences of every quantity of each run from the first."""
    for name, differences in zip(comparison.names[1:], comparison.differences, strict=True):
        for quantity, each in differences.items():
            unit, factor = shown_unit(each.unit)
            numbers = f"{factor * each.largest:.5g}", f"{each.at:g}", f"{factor * each.rms:.5g}"
            yield name, quantity, *numbers, unit
