"""Whole runs of many cranes with the metrics of `simulate`, in one compiled call for each kind.

Every crane's metrics, its hash included, are those of `Metrics`, which gathers them by the same
compiled functions.
"""

import hashlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.laws import LawError
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.lanes import take_entry
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.columns import group_indices, kind_of, make_driven, stack_columns
from crane_sim.simulation.flat_summary import cell_of, flatten, leaves
from crane_sim.simulation.metrics import Ended, name_further_metrics, name_metrics
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.simulation.status import SimulationError, describe_failure
from crane_sim.simulation.totals import (
    add_instants,
    empty_totals,
    finish_run,
    read_final_meters,
    read_meters,
    watched_of,
)
from crane_sim.stepping.batch import BatchArrays, TimeGrid, store_result
from crane_sim.stepping.periods import Output, begin, roll_out
from crane_sim.stepping.rows import row_width

Array = npt.NDArray[np.float64]
NO_TIMES = np.empty(0)

AT_ONCE = 16
"""Runs whose states are kept until they are hashed: they fit the second cache."""
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
    """Return how runs of scenes end.

    Those whose metrics compiled code can gather run in one call for each kind.
    """
    keys = (
        kind_of_run(scene) if has_compiled_metrics(scene) else i for i, scene in enumerate(scenes)
    )
    found: dict[int, RunEnd] = {}
    for group in group_indices(keys):
        own = [scenes[i] for i in group]
        ended = run_with_metrics(own)[0] if has_compiled_metrics(own[0]) else [run_alone(own[0])]
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
    """Return how the run of a scene ends; `measure`: further metrics if it reaches its end."""
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
    """Return whether compiled code runs a scene with all metrics, since nothing switches."""
    if scene.hardware is not None and not scene.hardware.ideal:
        return False
    if scene.sampled and not system.command.has_implementation(type(scene.law)):
        return False
    return system.switching(scene.model) is None


def kind_of_run(scene: Scene) -> Any:
    """Return what scenes share that can run in one call."""
    limited = tuple(limit.joint for limit in scene.limits)
    joints = scene.joint_names, scene.actuated, limited, scene.reference is None
    return kind_of((make_driven(scene), scene.trajectory)), scene.period, scene.steps, joints


class RunScratch(NamedTuple):
    """Arrays that one run after another uses."""

    times: Any  # (steps + 1,) s
    rows: Any  # (steps, width), see `stepping.rows`
    commands: Any  # (steps, nu)
    states: Any  # (AT_ONCE, steps + 1, 1 + 2 nq), time and joints of the runs


def run_with_metrics(
    scenes: Sequence[Scene], times: Array = NO_TIMES
) -> tuple[list[RunEnd], BatchArrays]:
    """Run scenes of one kind, which have compiled metrics, to their end or failure.

    Args:
        scenes: to run.
        times: at which they are sampled (m,) [s].

    Raises:
        SceneError: they are not of one kind.
    """
    first, n = scenes[0], len(scenes)
    watched = [watched_of(scene, scene.model.energy_meter is not None) for scene in scenes]
    cranes = stack_columns(
        [(make_driven(scene), each) for scene, each in zip(scenes, watched, strict=True)]
    )
    grid, arrays = TimeGrid(first.period, first.steps, times), allocate_arrays(scenes, len(times))
    scratch, totals, limited, hashes = (
        _allocate_scratch(first),
        empty_totals(first, n),
        np.empty(n, int),
        list[str](),
    )
    for start in range(0, n, AT_ONCE):
        end = min(start + AT_ONCE, n)
        measure_range(cranes, grid, arrays, totals, limited, scratch, start, end)
        hashes += _hash(scratch.states[: end - start], arrays.counts[start:end, 1].tolist())
    counts = arrays.counts[:, 1] * first.period, arrays.counts[:, 2], limited
    ended = Ended(*counts, hashes, cranes[1], totals)
    named = dict(leaves(name_metrics(first, ended) | name_further_metrics(first, ended)))
    values = zip(*(map(cell_of, column.tolist()) for column in named.values()), strict=True)
    ends = [
        RunEnd(dict(zip(named, row, strict=True)) | flatten(scene.notes), error, ())
        for scene, row, error in zip(scenes, values, errors_of(scenes, arrays), strict=True)
    ]
    return ends, arrays


@entry_point
def measure_range(cranes, grid, arrays, totals, limited, scratch, first, last):
    """Run cranes `first` to `last` (excluded) of `cranes`, as `simulate_range` does.

    Their columns are (`Driven`, `Watched`).

    Totals, states, and in how many periods a command was limited (n,) are filled, too.
    """
    for i in range(first, last):
        (method, p, source), watched = take_entry(cranes, i)
        shown, states = take_entry(totals, i), scratch.states[i - first]
        rows, m, nq = arrays.rows[i], len(grid.times), arrays.q.shape[1]
        integration, _, _ = begin(p, arrays.q[i], arrays.v[i])
        shown.balance.start[0] = read_meters(p, integration.x)[0]
        out = Output(grid.steps, scratch.rows, scratch.commands, rows[m:], grid.times, rows[:m])
        integration, done = roll_out(method, p, source, integration, grid.period, out)
        add_instants(p, watched, shown, scratch.times, scratch.rows, done)
        t, q, v = scratch.times[done], rows[m, :nq], rows[m, nq : 2 * nq]
        finish_run(p, watched, shown, t, q, v, read_final_meters(p, integration.x, t, q, v))
        for k in range(done + 1):
            states[k, 0] = scratch.times[k]
            states[k, 1:] = scratch.rows[k, : 2 * nq] if k < done else rows[m, : 2 * nq]
        limited[i] = count_limited(scratch.commands, scratch.rows[:, 2 * nq :], done)
        store_result(p, grid, arrays, i, integration, done)


def count_limited(commands, efforts, periods):
    """Return in how many periods a command was limited.

    There `commands` (n, nu) and the efforts applied differ.
    """
    limited = 0
    for k in range(periods):
        differs = False
        for j in range(commands.shape[1]):
            differs = differs or commands[k, j] != efforts[k, j]
        limited += differs
    return limited


def _hash(states: Array, done: Sequence[int]) -> list[str]:
    """Return the hashes of runs of so many periods."""
    return [hashlib.sha256(run[: k + 1]).hexdigest() for run, k in zip(states, done, strict=True)]


def _allocate_scratch(scene: Scene) -> RunScratch:
    nq, nu, k = len(scene.joint_names), len(scene.actuated), scene.steps + 1
    rows, commands = np.empty((k - 1, row_width(scene.model, nq, nu))), np.empty((k - 1, nu))
    times, states = (
        np.arange(k, dtype=np.float64) * scene.period,
        np.empty((AT_ONCE, k, 1 + 2 * nq)),
    )
    return RunScratch(times, rows, commands, states)


def allocate_arrays(scenes: Sequence[Scene], samples: int) -> BatchArrays:
    """Return the arrays of scenes of one kind, with initial states, for `samples` instants."""
    n, nq, nu = len(scenes), len(scenes[0].joint_names), len(scenes[0].actuated)
    q, v = (
        np.array([scene.initial_q for scene in scenes]),
        np.array([scene.initial_v for scene in scenes]),
    )
    width = row_width(scenes[0].model, nq, nu)
    rows, payload = np.empty((n, samples + 1, width)), np.empty((n, samples + 1, 3))
    return BatchArrays(q, v, rows, payload, np.empty(n), np.empty((n, 6), np.int64))


def errors_of(scenes: Sequence[Scene], arrays: BatchArrays) -> tuple[str | None, ...]:
    """Return why the runs of scenes ended before their time; None for one that did not."""
    return tuple(
        None
        if counts[1] == scene.steps
        else describe_failure(scene.model, counts[0], counts[5], float(reached))
        for scene, counts, reached in zip(
            scenes, arrays.counts.tolist(), arrays.reached, strict=False
        )
    )
