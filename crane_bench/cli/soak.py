"""The command `crane soak`."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from crane_bench.soak.metrics import Metric
from crane_sim.cli.help_lines import HELP, CommandGroup, FiniteRange, IntAtLeast
from crane_sim.cli.package_groups import install_groups
from crane_sim.cli.report import json_value
from crane_sim.cli.run_options import ensure_writable_folder
from crane_sim.cli.tables import print_table

_OUTPUT = ("as_json", "folder")  # options of the output, which change no metric
_Command = Callable[..., None]
_Measure = Callable[[], tuple[Sequence[Metric], dict[str, Any]]]


@click.group(cls=CommandGroup, context_settings=HELP)
def soak() -> None:
    """Run a soak test and print its metrics; exit code 1 where one fails its requirement."""


_seed = click.option("--seed", type=int, default=0, help="Seed of the random instants.")


def _output(command: _Command) -> _Command:
    """Add the output options."""
    command = click.option(
        "--save", "folder", metavar="FOLDER", help="Also write page, plot and data here."
    )(command)
    return click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")(
        command
    )


@soak.command()
@click.option("--count", type=IntAtLeast(2), default=200, help="Number of kills.")
@_seed
@_output
def kill(count: int, seed: int, **output: Any) -> None:
    """Kill controller and recorder in turn at random instants of one run with --restart."""
    from crane_bench.soak.kill import soak_kills

    _report(lambda: soak_kills(count, seed=seed), **output)


@soak.command()
@click.option("--count", type=IntAtLeast(1), default=50, help="Number of runs.")
@_seed
@_output
def signals(count: int, seed: int, **output: Any) -> None:
    """Interrupt `crane run` by SIGINT and SIGTERM at random instants, from start to shutdown."""
    from crane_bench.soak.signals import soak_signals

    _report(lambda: soak_signals(count, seed=seed), **output)


@soak.command()
@click.option("--minutes", type=FiniteRange(0.1), default=30.0, help="Minutes of wall time.")
@_output
def memory(minutes: float, **output: Any) -> None:
    """Measure resident memory and step rate of the nodes in a long lockstep run."""
    from crane_bench.soak.memory import soak_memory

    _report(lambda: soak_memory(minutes * 60.0), **output)


@soak.command()
@click.option("--steps", type=FiniteRange(1e4), default=1e7, help="Number of control periods.")
@_output
def inprocess(steps: float, **output: Any) -> None:
    """Measure resident memory and step rate of `Plant.advance` and `simulate`, without ROS."""
    from crane_bench.soak.inprocess import soak_inprocess

    _report(lambda: soak_inprocess(int(steps)), **output)


@soak.command()
@click.option("--count", type=IntAtLeast(2), default=50, help="Number of runs.")
@_output
def determinism(count: int, **output: Any) -> None:
    """Run one scene with varied processes, executors and load; compare all state_sha256."""
    from crane_bench.soak.determinism import soak_determinism

    _report(lambda: soak_determinism(count), **output)


@soak.command()
@click.option(
    "--seconds",
    type=FiniteRange(1.0),
    default=60.0,
    help="Seconds of each: bare loop, run by itself, run with monitor.",
)
@_output
def realtime(seconds: float, **output: Any) -> None:
    """Run at 1 kHz in real time: rate, overruns, and period error next to a bare loop's.

    The bare loop only sleeps.
    """
    from crane_bench.soak.realtime import soak_real_time

    _report(lambda: soak_real_time(seconds), **output)


@soak.command("page")
@click.option("--save", "folder", metavar="FOLDER", required=True, help="Folder of the data.")
def rewrite_page(folder: str) -> None:
    """Write page and plots again from the saved data."""
    from crane_bench.soak.store import read_findings, write_page

    read_findings(Path(folder))
    install_groups("bench")
    write_page(Path(folder))


def _report(measure: _Measure, as_json: bool, folder: str | None) -> None:
    """Print and save the metrics of a soak; exit with 1 where one fails its requirement."""
    part = str(click.get_current_context().info_name)
    ensure_writable_folder(folder)
    if folder is not None:
        install_groups("bench")  # before the measurement, which would be lost
    with Console(stderr=True, quiet=as_json).status(f"soaking: {part}"):
        metrics, data = measure()
    if folder is not None:
        from crane_bench.soak.store import save_findings

        save_findings(part, _command_line(part), metrics, data, Path(folder))
    if as_json:
        fields = [metric._asdict() for metric in metrics]
        print(json.dumps(json_value({"part": part, "metrics": fields, "data": data})))
    else:
        columns = ("metric", "measured", "required")
        print_table(Console(), f"soak: {part}", columns, map(_cells, metrics))
    if not all(metric.passed for metric in metrics):
        raise SystemExit(1)


def _command_line(part: str) -> str:
    """Return the command line that repeats this soak."""
    options = {
        name: value
        for name, value in click.get_current_context().params.items()
        if name not in _OUTPUT
    }
    return " ".join(
        ["crane soak", part, *(f"--{name} {_shorten(value)}" for name, value in options.items())]
    )


def _shorten(value: float) -> str:
    """Return a number as it may be typed: integers with all their digits."""
    return str(value) if isinstance(value, int) else f"{value:.10g}"


def _cells(metric: Metric) -> tuple[str, str, str]:
    return (
        metric.what,
        metric.format_value(),
        metric.requirement + ("" if metric.passed else "  failed"),
    )
