"""One cell of the league: a law in a trial, its runs, and their metrics."""

import os
from collections.abc import Iterator, Sequence
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from crane_bench.league.cases import GROUPS, SEEDS, Entrant, Group, Trial
from crane_bench.league.scenes import trial_scene
from crane_sim.files.errors import SceneError
from crane_sim.laws import LawError
from crane_sim.numerics.jit import LIGHT, entry_point, optimisation
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.derived import tip_acceleration
from crane_sim.simulation.goals import express_in_base, target_position
from crane_sim.simulation.plant import SimulationError
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.simulation.settling import nearness, settling_times
from crane_sim.study.workers import WorkerProcesses
from crane_sim.system import efforts_from_row
from crane_sim.trajectories.trajectory import sample_trajectory

LEVEL = 90.0  # deg: a larger swing is not under control


class CellMetrics(NamedTuple):
    """Metrics of a run; of several runs, their medians."""

    mse: float  # m², mean of the payload's squared distance from its goal
    mae: float  # m, mean of the distance
    peak_error: float  # m, largest distance
    residual_error: float  # m, largest distance in the last quarter of the run
    peak_swing: float  # deg, of the rope from the vertical
    residual_swing: float  # deg, in the last quarter of the run
    settling: float | None  # s, from the end of the path, or from the start where there is none;
    # None: it does not
    tip_acceleration: float  # m/s², largest, relative to the base
    effort: dict[str, float]  # largest of each actuated joint
    effort_units: dict[str, str]  # of each actuated joint
    saturated: float  # part of the periods in which a demand was limited


class Cell(NamedTuple):
    """A law in a trial."""

    crane: str
    law: str
    trial: str
    runs: int
    metrics: CellMetrics | None  # None: there is nothing to measure
    refused: str  # why the law does not apply to the scene
    failed: str  # why it does not count as controlled


def evaluate_all(groups: Sequence[Group] = GROUPS) -> Iterator[Cell]:
    """Yield the cells of these groups, in order; entrants are evaluated in parallel.

    There is a process for each core.
    """
    entries = [(group, entrant) for group in groups for entrant in group.entrants]
    with WorkerProcesses(os.cpu_count() or 1) as pool:
        for cells in pool.map(evaluate_entrant, *zip(*entries, strict=True)):
            yield from cells


def evaluate_entrant(group: Group, entrant: Entrant) -> list[Cell]:
    """Return the cells of an entrant in all trials of its group."""
    return [evaluate(group, entrant, trial) for trial in group.trials]


def evaluate(group: Group, entrant: Entrant, trial: Trial) -> Cell:
    """Return the cell of an entrant in a trial."""
    seeds = SEEDS if trial.seeded else SEEDS[:1]
    name = group.name, entrant.name, trial.column, len(seeds)
    try:
        scenes = [load_scene(trial_scene(trial, entrant, seed)) for seed in seeds]
    except SceneError as error:
        return Cell(*name, None, reason_of(error, entrant), "")
    try:
        metrics = median_metrics(
            [compute_metrics(simulate(scene), group.goal == "path") for scene in scenes]
        )
    except (SimulationError, LawError) as error:
        return Cell(*name, None, "", str(error))
    out_of_control = metrics.peak_swing >= LEVEL
    return Cell(*name, metrics, "", "the rope swings past the horizontal" if out_of_control else "")


def reason_of(error: SceneError, entrant: Entrant) -> str:
    """Return an error of an entrant's scene without the scene's name, with the entrant's own."""
    reason = str(error).removeprefix("scene ").partition(": ")[2]
    return reason.replace(f"law {entrant.law!r}", f"law {entrant.name!r}")


@entry_point
@optimisation(LIGHT)
def tip_accelerations(p, t, q, v, u, out):
    """Write `tip_acceleration` into `out` (K,).

    The arguments are times t (K,), joints q, v (K, nq) and efforts u (K, nu).
    """
    for i in range(len(q)):
        out[i] = tip_acceleration(p, t[i], q[i], v[i], efforts_from_row(p, u[i]))


def compute_metrics(run: Rollout, on_path: bool) -> CellMetrics:
    """Return the metrics of a run with its payload's goal: the scene's path, or the target."""
    scene = run.scene
    path = scene.trajectory if on_path else None
    goal = target_position(scene) if path is None else sample_trajectory(path, run.t)[:, 0]
    position = express_in_base(scene.model, run.t, run.payload)[:, : goal.shape[1]]
    error = np.linalg.norm(position - goal, axis=1)
    distance = float(np.linalg.norm(goal[-1] - goal[0])) if on_path else error[0]
    start = 0.0 if path is None else path.starts[-1]
    near = nearness(np.zeros(1), np.array([distance]))
    outside = np.array([np.max(run.t[~(error <= near)], initial=-np.inf)])
    # with period 0 the last instant outside, not the one after it
    (settled,) = settling_times(np.zeros(1), near, outside, run.t[-1:], error[-1:], period=0.0)
    return CellMetrics(
        mse=float(np.mean(error**2)),
        mae=float(np.mean(error)),
        peak_error=float(np.max(error)),
        residual_error=float(np.max(error[3 * len(error) // 4 :])),
        peak_swing=run.summary["peak_swing_deg"],
        residual_swing=run.summary["residual_swing_deg"],
        settling=None if np.isnan(settled) else float(max(settled - start, 0.0)),
        tip_acceleration=_largest_tip_acceleration(run),
        effort=run.summary["peak_effort"],
        effort_units=dict(zip(scene.actuated, scene.effort_units, strict=True)),
        saturated=run.summary["saturated_steps"] / scene.steps,
    )


def _largest_tip_acceleration(run: Rollout) -> float:
    accelerations = np.empty(len(run.t))
    columns = map(np.ascontiguousarray, (run.q, run.v, run.u))
    tip_accelerations(run.scene.model, run.t, *columns, accelerations)
    return float(np.max(accelerations))


def metrics_on_path(run: Rollout) -> dict[str, float | None]:
    """Return the metrics of a run whose payload follows a path, by their names in a study."""
    return _study_metrics(compute_metrics(run, on_path=True))


def metrics_at_target(run: Rollout) -> dict[str, float | None]:
    """Return the metrics of a run that brings its payload to a target, by their study names."""
    return _study_metrics(compute_metrics(run, on_path=False))


def _study_metrics(metrics: CellMetrics) -> dict[str, float | None]:
    names = ("mse", "mae", "peak_error", "residual_error", "settling", "tip_acceleration")
    return {f"payload_{name}": getattr(metrics, name) for name in names}


def median_metrics(runs: Sequence[CellMetrics]) -> CellMetrics:
    """Return the median of each metric.

    That of settling is None where half of the runs or more do not settle.
    """
    settling = float(np.median([inf if run.settling is None else run.settling for run in runs]))
    effort = {
        joint: float(np.median([run.effort[joint] for run in runs])) for joint in runs[0].effort
    }
    medians: dict[str, Any] = {
        "settling": settling if isfinite(settling) else None,
        "effort": effort,
        "effort_units": runs[0].effort_units,
    }
    for name in set(CellMetrics._fields) - set(medians):
        medians[name] = float(np.median([getattr(run, name) for run in runs]))
    return CellMetrics(**medians)
