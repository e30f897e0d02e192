"""The command `crane soak`."""

import json
from collections.abc import Callable, Sequence
from typing import Any

import click
from rich.console import Console
from rich.table import Table

from crane_sim.soak.figures import Figure


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
def soak() -> None:
    """Let a run survive for a long time, and print what that did; exit code 1 where a promise was not kept."""


_as_json = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
_seed = click.option("--seed", type=int, default=0, help="Of the random instants.")


@soak.command()
@click.option("--count", type=click.IntRange(2), default=200, help="Kills.")
@_seed
@_as_json
def kill(count: int, seed: int, as_json: bool) -> None:
    """SIGKILL on controller and recorder in turn, at random instants of one run with --restart."""
    from crane_sim.soak.kill import soak as measure

    _tell("kill", as_json, lambda: measure(count, seed=seed))


@soak.command()
@click.option("--count", type=click.IntRange(1), default=50, help="Runs.")
@_seed
@_as_json
def signals(count: int, seed: int, as_json: bool) -> None:
    """SIGINT and SIGTERM at random instants of the start, the run and the shutdown of `crane run`."""
    from crane_sim.soak.signals import soak as measure

    _tell("signals", as_json, lambda: measure(count, seed=seed))


@soak.command()
@click.option("--minutes", type=click.FloatRange(0.01), default=30.0, help="Of wall time.")
@_as_json
def memory(minutes: float, as_json: bool) -> None:
    """Resident memory of the nodes, and their rate, over a long lockstep run."""
    from crane_sim.soak.memory import soak as measure

    _tell("memory", as_json, lambda: measure(minutes * 60.0))


@soak.command()
@click.option("--steps", type=click.FloatRange(1e4), default=1e7, help="Control periods.")
@_as_json
def inprocess(steps: float, as_json: bool) -> None:
    """Resident memory and rate of `Plant.advance` and `simulate`, without ROS."""
    from crane_sim.soak.inprocess import soak as measure

    _tell("inprocess", as_json, lambda: measure(int(steps)))


@soak.command()
@click.option("--seconds", type=click.FloatRange(1.0), default=60.0, help="Of real time.")
@_as_json
def realtime(seconds: float, as_json: bool) -> None:
    """1 kHz in real time: rate, overruns against a subscriber's count, punctuality against a loop that only sleeps."""
    from crane_sim.soak.realtime import soak as measure

    _tell("realtime", as_json, lambda: measure(seconds))


def _tell(part: str, as_json: bool, measure: Callable[[], tuple[Sequence[Figure], dict[str, Any]]]) -> None:
    """Print what a soak found; exit with 1 where a promise was not kept."""
    with Console(stderr=True, quiet=as_json).status(f"soaking: {part}"):
        figures, data = measure()
    if as_json:
        print(json.dumps({"part": part, "figures": [figure._asdict() for figure in figures], "data": data}))
    else:
        Console().print(_table(part, figures))
    if not all(figure.kept for figure in figures):
        raise SystemExit(1)


def _table(part: str, figures: Sequence[Figure]) -> Table:
    table = Table("figure", "", "promised", title=f"soak: {part}", title_justify="left")
    for figure in figures:
        value = f"{figure.value:.4g}" if isinstance(figure.value, float) else str(figure.value)
        broken = "" if figure.kept else "  not kept"
        table.add_row(figure.what, f"{value} {figure.unit}".strip(), figure.promise + broken)
    return table
