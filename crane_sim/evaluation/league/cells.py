"""One cell of the league: a contender in a trial, its runs, and their figures."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from math import inf, isfinite
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from crane_sim.evaluation.league.cases import GROUPS, SEEDS, Entrant, Group, Task
from crane_sim.evaluation.league.scenes import task_scene
from crane_sim.files.errors import SceneError
from crane_sim.laws import LawError
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.metrics import LOOK, in_base, polyline, tip_accelerations
from crane_sim.simulation.plant import SimulationError
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.simulation.settling import HELD, RESOLUTION, SETTLED
from crane_sim.trajectories.path import Array, sample_path

LEVEL = 90.0  # deg: a rope that swings so far is not under control


class Figures(NamedTuple):
    """What is measured of a run; of several runs, the median of each."""

    mse: float  # m², mean of the squared distance of the payload from where it should be
    mae: float  # m, mean of the distance
    peak_error: float  # m, largest distance
    residual_error: float  # m, largest distance in the last quarter of the run
    peak_swing: float  # deg, of the rope from the vertical
    residual_swing: float  # deg, in the last quarter of the run
    settling: float | None  # s, from the end of the path, or from the start where there is none; None: it does not
    tip_acceleration: float  # m/s², largest, relative to the base
    effort: dict[str, float]  # largest of each actuated joint, in its unit
    saturated: float  # part of the periods in which a demand was limited


class Cell(NamedTuple):
    """A contender in a trial."""

    crane: str
    law: str
    trial: str
    runs: int
    figures: Figures | None  # None: there is nothing to measure
    refused: str  # why the law does not apply to the scene
    failed: str  # why it does not count as controlled


def cells(groups: Sequence[Group] = GROUPS) -> Iterator[Cell]:
    """Yield the cells of these groups, in order; contenders play side by side, a process for each core."""
    entered = [(group, contender) for group in groups for contender in group.contenders]
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool:
        for found in pool.map(evaluate_law, *zip(*entered, strict=True)):
            yield from found


def evaluate_law(group: Group, contender: Entrant) -> list[Cell]:
    """Return the cells of a contender in all trials of its group."""
    return [evaluate(group, contender, trial) for trial in group.trials]


def evaluate(group: Group, contender: Entrant, trial: Task) -> Cell:
    """Return the cell of a contender in a trial."""
    seeds = SEEDS if trial.seeded else SEEDS[:1]
    name = group.name, contender.name, trial.column, len(seeds)
    try:
        scenes = [load_scene(task_scene(trial, contender, seed)) for seed in seeds]
    except SceneError as error:
        return Cell(*name, None, _reason(error), "")
    try:
        found = middle([measure_figures(simulate(scene), group.goal == "path") for scene in scenes])
    except (SimulationError, LawError) as error:
        return Cell(*name, None, "", _reason(error))
    over = found.peak_swing >= LEVEL
    return Cell(*name, found, "", "the rope swings past the horizontal" if over else "")


def _reason(error: Exception) -> str:
    return str(error).removeprefix("scene ").partition(": ")[2] if isinstance(error, SceneError) else str(error)


def measure_figures(run: Rollout, on_path: bool) -> Figures:
    """Return the figures of a run, whose payload should be on the scene's path, or else at the target."""
    scene, model = run.scene, run.scene.model
    goal = on_the_path(scene, run.t) if on_path else at_target(scene)
    error = np.linalg.norm(aboard(model, run.t, run.payload)[:, : goal.shape[1]] - goal, axis=1)
    way = np.linalg.norm(goal[-1] - goal[0]) if on_path else error[0]
    begin = scene.path.starts[-1] if on_path and scene.path is not None else 0.0
    outside = run.t[error > max(SETTLED * way, RESOLUTION)].max(initial=begin)
    accelerations = np.empty(len(run.t))
    tip_accelerations(model, run.t, *map(np.ascontiguousarray, (run.q, run.v, run.u)), LOOK, accelerations)
    return Figures(
        mse=float(np.mean(error**2)),
        mae=float(np.mean(error)),
        peak_error=float(np.max(error)),
        residual_error=float(np.max(error[3 * len(error) // 4 :])),
        peak_swing=run.summary["peak_swing_deg"],
        residual_swing=run.summary["residual_swing_deg"],
        settling=float(outside - begin) if outside <= (1.0 - HELD) * run.t[-1] else None,
        tip_acceleration=float(np.max(accelerations)),
        effort=run.summary["peak_effort"],
        saturated=run.summary["saturated_steps"] / scene.steps,
    )


def on_the_path(scene: Scene, t: Array) -> Array:
    """Return where the payload should be (K, n) [m] at times t (K,), in the axes of the base."""
    assert scene.path is not None, "trials with a path are scenes with one"
    return sample_path(scene.path, np.ascontiguousarray(t))[:, 0]


def at_target(scene: Scene) -> Array:
    """Return where the payload hangs (1, 3) [m] when the actuated joints are at the target, in the axes of the base."""
    assert scene.reference is not None, "trials without a path are scenes with a target"
    q = np.zeros(len(scene.joint_names))
    q[[scene.joint_names.index(name) for name in scene.actuated]] = scene.reference
    nodes, _ = polyline(scene.model, 0.0, q, np.zeros_like(q))
    return aboard(scene.model, np.zeros(1), nodes[-1:])


def aboard(model: Any, t: Array, points: Array) -> Array:
    """Return points of the world (K, 3) [m] at times t (K,) [s] in the axes of the base."""
    base = getattr(model, "base", None)
    return points if base is None else in_base(base, t, points)


def middle(runs: Sequence[Figures]) -> Figures:
    """Return the median of each figure; that of settling is None where half of the runs or more do not settle."""
    settling = float(np.median([inf if run.settling is None else run.settling for run in runs]))
    effort = {joint: float(np.median([run.effort[joint] for run in runs])) for joint in runs[0].effort}
    found: dict[str, Any] = {"settling": settling if isfinite(settling) else None, "effort": effort}
    for name in set(Figures._fields) - set(found):
        found[name] = float(np.median([getattr(run, name) for run in runs]))
    return Figures(**found)
