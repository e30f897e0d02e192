"""Whole runs of many cranes with the metrics of `simulate`, in one compiled call for all cranes of a kind.

Every crane's metrics, its hash included, are those of `Metrics`, which gathers them by the same compiled functions.
"""

import hashlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.integrators import Integration
from crane_sim.laws import LawError
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.columns import group_indices, kind_of, make_driven, stack_columns
from crane_sim.simulation.energy_balance import empty_balance
from crane_sim.simulation.extremes import Extremes, joint_margins
from crane_sim.simulation.flat_summary import flatten, leaves
from crane_sim.simulation.metric_lanes import lane_buffers
from crane_sim.simulation.metric_loops import (
    AT_ONCE,
    Clock,
    RunColumns,
    RunScratch,
    run_cranes_with_metrics,
)
from crane_sim.simulation.metrics import RunTotals, name_metrics
from crane_sim.simulation.peaks import LAST, no_peaks, swing_angles
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.simulation.settling import nearness
from crane_sim.simulation.status import SimulationError, check_status
from crane_sim.stepping.rows import row_width

Array = npt.NDArray[np.float64]


Measure = Callable[[Rollout], dict[str, float | None]]
"""Returns metrics of a run by name; raises MetricError."""


class MetricError(ValueError):
    """A run whose further metrics cannot be had; one line."""


class RunEnd(NamedTuple):
    """How a run ended."""

    metrics: dict[str, Any]  # of its summary, by dotted key; none where there was no run
    error: str | None  # why it ended before its time
    events: tuple[tuple[float, str], ...]
    refused: bool = False  # whether its scene is not possible


def run_all(scenes: Sequence[Scene]) -> list[RunEnd]:
    """Return how runs of scenes end, those that compiled code can gather the metrics of in one call for each kind."""
    keys = (kind_of_run(scene) if has_compiled_metrics(scene) else i for i, scene in enumerate(scenes))
    found: dict[int, RunEnd] = {}
    for group in group_indices(keys):
        own = [scenes[i] for i in group]
        ended = run_with_metrics(own) if has_compiled_metrics(own[0]) else [run_alone(own[0])]
        found |= zip(group, ended, strict=True)
    return [found[i] for i in range(len(scenes))]


class Attempt(NamedTuple):
    """A run that may have failed."""

    run: Rollout | None  # up to where it failed; None without one
    error: str | None  # why it ended before its time
    refused: bool = False  # whether its scene is not possible


def attempt_run(scene: Scene) -> Attempt:
    """Run a scene; whatever ends it is returned."""
    try:
        return Attempt(simulate(scene), None)
    except SceneError as error:
        return Attempt(None, str(error), refused=True)
    except SimulationError as error:
        return Attempt(error.run, str(error))
    except LawError as error:
        return Attempt(None, str(error))


def run_alone(scene: Scene, measure: Measure | None = None) -> RunEnd:
    """Return how the run of a scene ends; `measure`: further metrics of one that reaches its end."""
    run, error, refused = attempt_run(scene)
    if run is None:
        return RunEnd({}, error, (), refused)
    further: dict[str, float | None] = {}
    if measure is not None and error is None:
        try:
            further = measure(run)
        except MetricError as reason:
            error = str(reason)
    return RunEnd(flatten(run.summary) | further, error, tuple(run.events))


def has_compiled_metrics(scene: Scene) -> bool:
    """Return whether all metrics of a scene's summary are gathered by compiled code, and nothing switches."""
    model = scene.model
    if scene.trajectory is not None or (scene.hardware is not None and not scene.hardware.ideal):
        return False
    if scene.sampled and not system.command.has_implementation(type(scene.law)):
        return False
    plain = getattr(model, "contact", None) is None and not system.fall_count(model)
    return plain and system.switching(model) is None and not Extremes(scene).has_angles


def kind_of_run(scene: Scene) -> Any:
    """Return what scenes share that can run in one call."""
    limited = tuple(limit.joint for limit in scene.limits)
    joints = scene.joint_names, scene.actuated, limited, scene.reference is None
    return kind_of(make_driven(scene)), scene.period, scene.steps, joints


class RunStarts(NamedTuple):
    """What n runs of one kind start from."""

    first: Scene
    cranes: Any  # columns of `stepping.batch.Driven`
    q: Array  # (n, nq)
    v: Array  # (n, nq)
    target: Array | None  # (n, nu), of the actuated joints; None without
    limits: dict[str, Any]  # lowest and highest position by joint, (n,) each
    model_of: Callable[[int], Any]  # the model of run i


class EndColumns(NamedTuple):
    """How n runs ended."""

    metrics: dict[str, Any]  # of their summaries by dotted key, (n,) each
    errors: list[str | None]  # (n,), why each ended before its time


def run_with_metrics(scenes: Sequence[Scene]) -> list[RunEnd]:
    """Run scenes of one kind, which have compiled metrics, from their beginning to their end or failure.

    Raises:
        SceneError: they are not of one kind.
    """
    cranes, first = stack_columns([make_driven(scene) for scene in scenes]), scenes[0]
    q, v = (np.array([getattr(scene, name) for scene in scenes]) for name in ("initial_q", "initial_v"))
    target = None if first.reference is None else np.array([scene.reference for scene in scenes])
    ends = [np.array([(limit.low, limit.high) for limit in scene.limits]) for scene in scenes]
    limits = {limit.joint: np.array([each[k] for each in ends]).T for k, limit in enumerate(first.limits)}
    ended = _run(RunStarts(first, cranes, q, v, target, limits, lambda i: scenes[i].model))
    names, values = list(ended.metrics), zip(*(column.tolist() for column in ended.metrics.values()), strict=True)
    return [
        RunEnd(dict(zip(names, row, strict=True)) | flatten(scene.notes), error, ())
        for scene, row, error in zip(scenes, values, ended.errors, strict=True)
    ]


def _run(starts: RunStarts) -> EndColumns:
    """Run n cranes of one kind."""
    first, runs = starts.first, _allocate(starts)
    late, metered = (1.0 - LAST) * first.duration, first.model.energy_meter is not None
    clock = Clock(first.period, first.steps, late, metered)
    scratch, hashes = _allocate_scratch(first), list[str]()
    for start in range(0, len(runs.q), AT_ONCE):
        end = min(start + AT_ONCE, len(runs.q))
        run_cranes_with_metrics(starts.cranes, clock, runs, scratch, start, end)
        done = runs.counts[start:end, 1].tolist()
        hashes += _hash(scratch.states[: end - start], done)
    metrics = dict(leaves(_metrics_of_runs(starts, runs, hashes)))
    failed = np.flatnonzero(runs.counts[:, 1] != first.steps).tolist()
    errors: list[str | None] = [None] * len(runs.q)
    for i in failed:
        errors[i] = _error(starts.model_of(i), runs, i)
    return EndColumns(metrics, errors)


def _hash(states: Array, done: Sequence[int]) -> list[str]:
    """Return the hashes of runs of so many periods."""
    return [hashlib.sha256(run[: k + 1]).hexdigest() for run, k in zip(states, done, strict=True)]


def _allocate(starts: RunStarts) -> RunColumns:
    first, (n, nq) = starts.first, starts.q.shape
    nu, driven = len(first.actuated), [first.joint_names.index(name) for name in first.actuated]
    target, near = np.zeros((n, nu)), np.full((n, nu), np.inf)
    if starts.target is not None:
        target, near = starts.target, nearness(starts.target, starts.q[:, driven])
    ranges = np.full((n, 2, nq), np.inf)
    ranges[:, 1] = -np.inf
    sums = no_peaks(nu, n), empty_balance(nu, n), ranges, np.full((n, nu), -np.inf)
    found = np.empty((n, 2)), np.empty((n, 6)), np.empty((n, nu)), np.empty((n, 5), np.int64), np.empty(n)
    return RunColumns(starts.q, starts.v, target, near, *sums, *found)


def _allocate_scratch(scene: Scene) -> RunScratch:
    nq, nu, k = len(scene.joint_names), len(scene.actuated), scene.steps + 1
    driven = np.array([scene.joint_names.index(name) for name in scene.actuated], np.int64)
    width, lanes, watched = row_width(scene.model, nq, nu), None, k
    if system.observe.has_implementation(type(scene.model)) and system.link_count(scene.model) == 1:
        lanes, watched = lane_buffers(nq, nu), 0
    rows, energies, ends, driven_q = (np.empty((watched, n)) for n in (width, 2, 6, nu))
    times, commands = np.arange(k, dtype=np.float64) * scene.period, np.empty((k - 1, nu))
    states = np.empty((AT_ONCE, k, 1 + 2 * nq))
    return RunScratch(times, driven, rows, commands, energies, ends, driven_q, states, lanes)


def _metrics_of_runs(starts: RunStarts, runs: RunColumns, hashes: Sequence[str]) -> dict[str, Any]:
    ended = RunTotals(
        t=runs.counts[:, 1] * starts.first.period,
        q=runs.driven_end,
        swing=swing_angles(runs.ends[:, :3], runs.ends[:, 3:]),
        evaluations=runs.counts[:, 2],
        saturated=runs.counts[:, 4],
        peaks=runs.peaks,
        target=starts.target,
        near=runs.near,
        outside=runs.outside,
        audit=runs.audit,
        sha=hashes,
    )
    return name_metrics(starts.first, ended) | joint_margins(starts.limits, starts.first.joint_names, runs.ranges)


def _error(model: Any, runs: RunColumns, i: int) -> str | None:
    """Return why run i of a model ended before its time."""
    status, _, _, guard, _ = runs.counts[i].tolist()
    stopped = Integration(0.0, None, float(runs.reached[i]), None, 0.0, status=status, terminal_guard=guard)
    try:
        check_status(stopped, model)
    except SimulationError as error:
        return str(error)
    return None
