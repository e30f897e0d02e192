"""Whole runs of many cranes with the figures of `simulate`, in one compiled call for all cranes of a kind.

Every crane's figures, its hash included, are those of `Metrics`, which gathers them by the same compiled functions.
"""

import hashlib
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.integrators import Integration
from crane_sim.numerics.jit import entry_point, generic, routine
from crane_sim.numerics.lanes import tree_column
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.columns import columns, extract_drive, group_indices, kind_of
from crane_sim.simulation.energy_balance import Balance, balance_errors, balance_instants, empty_balance
from crane_sim.simulation.extremes import Extremes, joint_margins, note_range
from crane_sim.simulation.figures import flatten, leaves
from crane_sim.simulation.metrics import RunTotals, name_figures, read_meters
from crane_sim.simulation.peaks import LAST, Peaks, fill_watched, no_peaks, swing_angles, watch_instants
from crane_sim.simulation.rollout import simulate
from crane_sim.simulation.settling import nearness, note_outside
from crane_sim.simulation.status import SimulationError, check_status
from crane_sim.stepping.batch import Sampled
from crane_sim.stepping.periods import Output, begin, continuous_rollout, zero_order_hold_rollout
from crane_sim.stepping.rows import row_width

AT_ONCE = 16
"""Runs whose states are kept until they are hashed: they fit the second cache."""

Array = npt.NDArray[np.float64]


class Clock(NamedTuple):
    """Control periods of a run, the same for all cranes of a kind, and whether these have meters."""

    period: float  # s
    steps: int
    late: float  # s, when the last part of the run begins
    metered: bool


class RunColumns(NamedTuple):
    """Initial states of n cranes, and what their runs have shown."""

    q: Any  # (n, nq), at the start
    v: Any  # (n, nq)
    target: Any  # (n, nu), of the actuated joints
    near: Any  # (n, nu), which distance from it counts as near
    peaks: Peaks  # columns
    balance: Balance  # columns
    ranges: Any  # (n, 2, nq), least and greatest joint positions
    outside: Any  # (n, nu) s, when joints were last away from their targets
    audit: Any  # (n, 2), energy errors
    ends: Any  # (n, 6) m, tip and payload at the end
    driven_end: Any  # (n, nu), positions of the actuated joints at the end
    counts: Any  # (n, 5): status, whole periods, evaluations, terminal guard, periods in which a command was limited
    reached: Any  # (n,) s, time of the integration


class RunScratch(NamedTuple):
    """Arrays that one run after another uses."""

    times: Any  # (steps + 1,) s
    driven: Any  # (nu,) indices of the actuated joints
    rows: Any  # (steps + 1, width), see `stepping.rows`
    commands: Any  # (steps, nu)
    energies: Any  # (steps + 1, 2) J
    ends: Any  # (steps + 1, 6) m
    driven_q: Any  # (steps + 1, nu)
    states: Any  # (AT_ONCE, steps + 1, 1 + 2 nq), time and joints of the runs


@generic
def roll_out(source, method, p, integration, period, out):
    """Return (last integration, number of whole periods, those in which a command was limited); fill `out`."""
    return (*continuous_rollout(method, p, source, integration, period, out), 0)


@roll_out.register(Sampled)
def _(source, method, p, integration, period, out):
    integration, done = zero_order_hold_rollout(method, p, source.law, integration, period, out)
    limited, nu = 0, out.commands.shape[1]
    first = 2 * len(system.joints(p, integration.x)[0])
    for k in range(done):
        differs = False
        for j in range(nu):
            differs = differs or out.commands[k, j] != out.rows[k, first + j]
        limited += differs
    return integration, done, limited


@entry_point
def run_cranes_with_figures(cranes, clock, runs, scratch, first, last):
    """Run cranes `first` to `last` (excluded): columns of `Driven`; fill `RunColumns`, and the states of each run."""
    nothing, samples = np.empty(0), np.empty((0, scratch.rows.shape[1]))
    out = Output(scratch.rows, scratch.commands, nothing, samples)
    for i in range(first, last):
        method, p, source = tree_column(cranes, i)
        integration, _, _ = begin(p, runs.q[i], runs.v[i])
        runs.balance.start[i, 0] = read_meters(p, integration.x)[0]
        integration, done, limited = roll_out(source, method, p, integration, clock.period, out)
        counts = runs.counts[i]
        counts[0], counts[1], counts[2] = integration.status, done, integration.evaluations
        counts[3], counts[4] = integration.terminal_guard, limited
        runs.reached[i] = integration.t
        watch_run(p, clock, tree_column(runs, i), scratch, scratch.states[i - first])
        finish_run(p, clock, tree_column(runs, i), scratch, integration.x)


@routine
def watch_run(p, clock, run, scratch, states):
    """Gather the figures of one run from its rows, and copy its states."""
    k, nq, nu = run.counts[1], len(run.q), len(run.target)
    rows, t = scratch.rows[: k + 1], scratch.times[: k + 1]
    q, v, u = rows[:, :nq], rows[:, nq : 2 * nq], rows[:, 2 * nq : 2 * nq + nu]
    fill_watched(p, t, q, v, scratch.energies, scratch.ends)
    for i in range(k + 1):
        states[i, 0] = t[i]
        for j in range(2 * nq):
            states[i, 1 + j] = rows[i, j]
        for j in range(nu):
            scratch.driven_q[i, j] = q[i, scratch.driven[j]]
    driven_q, energies = scratch.driven_q[:k], scratch.energies
    supplied, tensions = rows[:k, 2 * nq + nu], rows[:k, 2 * nq + nu + 1 :]
    balance_instants(run.balance, clock.metered, driven_q, u[:k], supplied, energies[:k, 0], energies[:k, 1])
    watch_instants(run.peaks, t[:k], clock.late, u[:k], tensions, scratch.ends)
    note_range(q, run.ranges[0], run.ranges[1])
    note_outside(run.target, run.near, t[:k], driven_q, run.outside)


@routine
def finish_run(p, clock, run, scratch, x):
    """Note the figures of a run at its end, in state x of the integration."""
    k = run.counts[1]
    for j in range(6):
        run.ends[j] = scratch.ends[k, j]
    for j in range(len(run.driven_end)):
        run.driven_end[j] = scratch.driven_q[k, j]
    energy, supplied = read_meters(p, x)
    audit = balance_errors(run.balance, clock.metered, scratch.driven_q[k], energy, supplied)
    run.audit[0], run.audit[1] = audit


class RunEnd(NamedTuple):
    """How a run ended."""

    figures: dict[str, Any]  # of its summary, by dotted key
    error: str | None  # why it ended before its time
    events: tuple[tuple[float, str], ...]


def run_all(scenes: Sequence[Scene]) -> list[RunEnd]:
    """Return how runs of scenes end, those that compiled code can gather the figures of in one call for each kind.

    Raises:
        LawError: a law failed.
    """
    keys = (kind_of_run(scene) if has_compiled_figures(scene) else i for i, scene in enumerate(scenes))
    found: dict[int, RunEnd] = {}
    for group in group_indices(keys):
        own = [scenes[i] for i in group]
        ended = run_with_figures(own) if has_compiled_figures(own[0]) else [_run_alone(own[0])]
        found |= zip(group, ended, strict=True)
    return [found[i] for i in range(len(scenes))]


def _run_alone(scene: Scene) -> RunEnd:
    try:
        run, why = simulate(scene), None
    except SimulationError as error:
        run, why = error.run, str(error)
    return RunEnd(flatten(run.summary), why, tuple(run.events))


def has_compiled_figures(scene: Scene) -> bool:
    """Return whether all figures of a scene's summary are gathered by compiled code, and nothing switches."""
    model = scene.model
    if scene.path is not None or (scene.hardware is not None and not scene.hardware.ideal):
        return False
    if scene.sampled and not system.command.has_implementation(type(scene.law)):
        return False
    plain = getattr(model, "contact", None) is None and not system.fall_count(model)
    return plain and system.switching(model) is None and not Extremes(scene).has_angles


def kind_of_run(scene: Scene) -> Any:
    """Return what scenes share that can run in one call."""
    limited = tuple(limit.joint for limit in scene.limits)
    joints = scene.joint_names, scene.actuated, limited, scene.reference is None
    return kind_of(extract_drive(scene)), scene.period, scene.steps, joints


def run_with_figures(scenes: Sequence[Scene]) -> list[RunEnd]:
    """Run scenes of one kind, which have compiled figures, from their beginning to their end or failure.

    Raises:
        SceneError: they are not of one kind.
    """
    cranes = columns([extract_drive(scene) for scene in scenes])
    first, runs = scenes[0], _allocate(scenes)
    late, metered = (1.0 - LAST) * first.duration, first.model.energy_meter is not None
    clock = Clock(first.period, first.steps, late, metered)
    scratch, hashes = _allocate_scratch(first), list[str]()
    for start in range(0, len(scenes), AT_ONCE):
        end = min(start + AT_ONCE, len(scenes))
        run_cranes_with_figures(cranes, clock, runs, scratch, start, end)
        done = runs.counts[start:end, 1].tolist()
        hashes += [hashlib.sha256(states[: k + 1]).hexdigest() for states, k in zip(scratch.states, done, strict=False)]
    figures = leaves(_figures(scenes, runs, hashes))
    names, columns_of = zip(*((name, column.tolist()) for name, column in figures), strict=True)
    rows = zip(scenes, zip(*columns_of, strict=True), strict=True)
    return [
        RunEnd(dict(zip(names, values, strict=True)) | flatten(scene.notes), _error(scene, runs, i), ())
        for i, (scene, values) in enumerate(rows)
    ]


def _allocate(scenes: Sequence[Scene]) -> RunColumns:
    first, n = scenes[0], len(scenes)
    nq, nu = len(first.joint_names), len(first.actuated)
    q, v = (np.array([getattr(scene, name) for scene in scenes]) for name in ("initial_q", "initial_v"))
    target, near = np.zeros((n, nu)), np.full((n, nu), np.inf)
    if first.reference is not None:
        target = np.array([scene.reference for scene in scenes])
        near = nearness(target, q[:, [first.joint_names.index(name) for name in first.actuated]])
    ranges = np.full((n, 2, nq), np.inf)
    ranges[:, 1] = -np.inf
    sums = no_peaks(nu, n), empty_balance(nu, n), ranges, np.full((n, nu), -np.inf)
    found = np.empty((n, 2)), np.empty((n, 6)), np.empty((n, nu)), np.empty((n, 5), np.int64), np.empty(n)
    return RunColumns(q, v, target, near, *sums, *found)


def _allocate_scratch(scene: Scene) -> RunScratch:
    nq, nu, k = len(scene.joint_names), len(scene.actuated), scene.steps + 1
    driven = np.array([scene.joint_names.index(name) for name in scene.actuated], np.int64)
    rows, commands = np.empty((k, row_width(scene.model, nq, nu))), np.empty((k - 1, nu))
    watched = np.empty((k, 2)), np.empty((k, 6)), np.empty((k, nu))
    states = np.empty((AT_ONCE, k, 1 + 2 * nq))
    return RunScratch(np.arange(k, dtype=np.float64) * scene.period, driven, rows, commands, *watched, states)


def _figures(scenes: Sequence[Scene], runs: RunColumns, hashes: Sequence[str]) -> dict[str, Any]:
    ended = RunTotals(
        t=runs.counts[:, 1] * scenes[0].period,
        q=runs.driven_end,
        swing=swing_angles(runs.ends[:, :3], runs.ends[:, 3:]),
        evaluations=runs.counts[:, 2],
        saturated=runs.counts[:, 4],
        peaks=runs.peaks,
        outside=None if scenes[0].reference is None else runs.outside,
        audit=runs.audit,
        sha=hashes,
    )
    limits = [scene.limits for scene in scenes]
    return name_figures(scenes, ended) | joint_margins(limits, scenes[0].joint_names, runs.ranges)


def _error(scene: Scene, runs: RunColumns, i: int) -> str | None:
    """Return why run i ended before its time, None if it did not."""
    status, done, _, guard, _ = runs.counts[i].tolist()
    if done == scene.steps:
        return None
    stopped = Integration(0.0, None, float(runs.reached[i]), None, 0.0, status=status, terminal_guard=guard)
    try:
        check_status(stopped, scene.model)
    except SimulationError as error:
        return str(error)
    return None
