"""Tables 5, 7 and 9 of the offshore paper (Smith & Egeland): errors on a path, law by law.

Unprinted values are assumed once, in the scenes: one servo of the suspension point for all tables.
With random features or camera noise a number is the median over seeds, beside the extremes.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from crane_bench.tables import Shown
from crane_sim.files.yaml_text import parse_yaml
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.derived import in_base
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.trajectories.trajectory import sample_trajectory

SEEDS = 30


class Printed(NamedTuple):
    """A number of the paper, and the relative tolerance of ours, for unprinted values."""

    value: float
    tolerance: float


class Column(NamedTuple):
    """One column of a table."""

    mse: Printed  # m²
    mae: Printed  # m


class Experiment(NamedTuple):
    """A scene that should come to a column of a table."""

    table: str
    name: str  # of the column
    printed: Column
    assumption: str
    scene: str
    changes: dict[str, Any] = {}
    seeded: tuple[str, ...] = ()  # keys of the scene that take the seed


def _experiment(column: dict[str, Any]) -> Experiment:
    mse, mae = (Printed(*column["printed"][name]) for name in ("mse", "mae"))
    return Experiment(
        **column | {"printed": Column(mse, mae), "seeded": tuple(column.get("seeded", ()))}
    )


_TABLES = parse_yaml(Path(__file__).with_name("offshore.yaml").read_text(encoding="utf-8"))
PAIRS = [[_experiment(column) for column in pair] for pair in _TABLES["pairs"]]
"""The columns of each table: the law before, and the paper's."""
OTHERWISE = [_experiment(column) for column in _TABLES["otherwise"]]
"""The same columns, with other assumptions: the dependence of their numbers on them."""
PEAKS = "Figs. 4, 5: peak acceleration of the tip, Cartesian / angular"
LEARNT = "Figs. 11, 12: MSE along x, with / without learning"
SEEN = "Figs. 14, 15: MSE along x, with / without learning"
HARDEST = "Table 9, with learning: peak acceleration of the tip, m/s2"
SENTENCES = (PEAKS, LEARNT, SEEN, HARDEST)
"""The text's claims on its figures."""


class Measured(NamedTuple):
    """A number of the paper beside ours."""

    claim: str
    paper: Shown
    ours: float  # the median of all runs
    lowest: float
    highest: float
    runs: int  # seeds
    difference: float | None  # of the median, relative to the paper
    assumption: str
    verdict: str


def name_offshore_rows() -> list[str]:
    """Return the claims of all rows, without running any."""
    tables = [claim for pair in PAIRS for experiment in pair for claim in claims(experiment)]
    return [
        *tables,
        *SENTENCES,
        *(claim for experiment in OTHERWISE for claim in claims(experiment)),
    ]


def claims(experiment: Experiment) -> tuple[str, str]:
    """Return the claims of an experiment's rows, its MSE and its MAE."""
    head = f"{experiment.table}, {experiment.name}"
    return f"{head}: MSE, m2", f"{head}: MAE, m"


def measure_offshore_tables(seeds: int = SEEDS) -> list[Measured]:
    """Return the tables with this many seeds, then the text's sentences, other assumptions.

    Experiments without random numbers have no seeds.
    """
    tables = [
        row for pair in PAIRS for experiment in pair for row in measure_errors(experiment, seeds)
    ]
    return [
        *tables,
        *sentences(),
        *(row for experiment in OTHERWISE for row in measure_errors(experiment, seeds)),
    ]


def run_experiment(experiment: Experiment, seed: int = 0) -> Rollout:
    """Run an experiment with one seed of all that is drawn."""
    return simulate(
        load_scene(experiment.scene, experiment.changes | dict.fromkeys(experiment.seeded, seed))
    )


def measure_errors(experiment: Experiment, seeds: int) -> Iterator[Measured]:
    """Yield MSE [m²] and MAE [m] of an experiment."""
    summaries = [
        run_experiment(experiment, seed).summary
        for seed in range(seeds if experiment.seeded else 1)
    ]
    mse, mae = ([summary[key] for summary in summaries] for key in ("tracking_mse", "tracking_mae"))
    for claim, printed, values in zip(
        claims(experiment), experiment.printed, (mse, mae), strict=True
    ):
        yield compare_with_paper(claim, printed, values, experiment.assumption)


def compare_with_paper(
    claim: str, printed: Printed, values: list[float], assumption: str
) -> Measured:
    """Return a number of the paper beside ours for each seed; the verdict is on all of them."""
    low, high, median = min(values), max(values), float(np.median(values))
    worst = max(abs(value / printed.value - 1.0) for value in (low, high))
    verdict = f"{'within' if worst <= printed.tolerance else 'not within'} {printed.tolerance:.0%}"
    difference = median / printed.value - 1.0
    return Measured(
        claim, printed.value, median, low, high, len(values), difference, assumption, verdict
    )


def sentences() -> Iterator[Measured]:
    """Yield the text's claims on its figures, as ratios of our results: after to before."""
    obstacle, resonant, vision = (
        [run_experiment(experiment) for experiment in pair] for pair in PAIRS
    )
    hardest = [moved.summary["peak_tip_acceleration"] for moved in obstacle]
    yield _ratio(PEAKS, "comparable", hardest, (0.5, 2.0))
    yield _ratio(LEARNT, "less than 1", [_along_x(moved) for moved in resonant], (0.0, 1.0))
    yield _ratio(SEEN, "about 1", [_along_x(moved) for moved in vision], (0.8, 1.25))
    hardest = vision[1].summary["peak_tip_acceleration"]  # demands come as a staircase at 30 Hz
    yield Measured(
        HARDEST, "-", hardest, hardest, hardest, 1, None, "as in the table, seed 0", "not printed"
    )


def payload_and_path(run: Rollout) -> tuple[Any, Any]:
    """Return (payload, path), each (K, 2) [m], horizontal, relative to the base."""
    goal, base = sample_trajectory(run.scene.trajectory, run.t)[:, 0, :2], run.scene.model.base
    positions = run.payload if base is None else in_base(base, run.t, run.payload)
    return positions[:, :2], goal


def _along_x(run: Rollout) -> float:
    positions, goal = payload_and_path(run)
    return float(np.mean((positions - goal)[:, 0] ** 2))


def _ratio(claim: str, paper: str, values: list[float], between: tuple[float, float]) -> Measured:
    ratio = values[1] / values[0]
    verdict = "reproduced" if between[0] <= ratio < between[1] else "not reproduced"
    return Measured(claim, paper, ratio, ratio, ratio, 1, None, "as in the table, seed 0", verdict)
