"""Thousands of cranes at once: one scene with many values of its parameters, on all cores.

    batch = crane_sim.simulate_batch("overhead_swing", {"payload.mass": numpy.linspace(5.0, 20.0,
    1024)}) batch.q, batch.v, batch.payload, batch.errors

Every crane moves as `simulate` moves it alone, to the last bit. Methods with a fixed step move as
many of them at once as a vector register has lanes.

The scenes of a batch: one document, changed for each crane, and their numbers put into columns.
"""

import os
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.files.errors import SceneError, shorten
from crane_sim.integrators import Status
from crane_sim.integrators.dop853 import RK8
from crane_sim.integrators.rk4 import RK4
from crane_sim.numerics.lanes import LANES
from crane_sim.scenes.scene import Scene, SceneSource, load_scenes
from crane_sim.simulation.batch_metrics import (
    RunEnd,
    allocate_arrays,
    errors_of,
    has_compiled_metrics,
    kind_of_run,
    run_alone,
    run_with_metrics,
)
from crane_sim.simulation.columns import group_indices, kind_of, make_driven, stack_columns
from crane_sim.simulation.flat_summary import metric_columns
from crane_sim.simulation.rollout import checked_times
from crane_sim.stepping.batch import BatchArrays, TimeGrid, pass_lanes, simulate_range
from crane_sim.stepping.periods import begin
from crane_sim.tracing.compile_time import compile_time


def scenes_of(
    scene: SceneSource, parameters: Mapping[str, Any], duration: float | None
) -> list[Scene]:
    """Return one checked scene for each crane.

    Raises:
        SceneError: the parameters do not fit one another, or the scene of a crane is invalid; it
            names the crane.
    """
    count = _count(parameters)
    if duration is not None and "duration" in parameters:
        raise SceneError(
            f"duration = {duration}: is among the parameters, too; leave out one of the two"
        )
    always = {} if duration is None else {"duration": duration}
    changes = [
        always | {key: _value(parameters[key][i]) for key in parameters} for i in range(count)
    ]
    scenes: list[Scene] = []
    for i, loaded in enumerate(load_scenes(scene, changes)):
        if isinstance(loaded, SceneError):
            raise SceneError(f"crane {i}: {loaded}") from None
        scenes.append(loaded)
        _check_alike(scenes[0], loaded, i)
    return scenes


def _value(value: Any) -> Any:
    """Return a value as a scene file would hold it: no arrays."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _count(parameters: Mapping[str, Any]) -> int:
    """Return the number of cranes."""
    if not isinstance(parameters, Mapping) or not all(isinstance(key, str) for key in parameters):
        raise SceneError(
            f"parameters = {parameters!r}: must map keys of the scene to values, one for each crane"
        )
    if not parameters:
        raise SceneError(
            "parameters: are empty; give at least one key of the scene with a value for each crane"
        )
    counts = {key: _count_values(key, values) for key, values in parameters.items()}
    (first, count), *_ = counts.items()
    for key, other in counts.items():
        if not other:
            raise SceneError(f"parameters: {key!r} is empty; give a value for each crane")
        if other != count:
            raise SceneError(
                f"parameters: {key!r} has {other} entries, {first!r} has {count}: one for each "
                "crane"
            )
    return count


def _count_values(key: str, values: Any) -> int:
    """Return the number of values that a key of the scene is given."""
    listed = values.ndim if isinstance(values, np.ndarray) else isinstance(values, Sequence)
    if not listed or isinstance(values, str):
        raise SceneError(
            f"parameters: {key!r} = {values!r}: must be an array with one entry for each crane"
        )
    return len(values)


def _check_alike(first: Scene, scene: Scene, i: int) -> None:
    """Raise SceneError when crane i cannot run in one batch with the first one.

    It has other joints or periods, or its law cannot run compiled.
    """
    for name in ("duration", "period"):
        value, expected = getattr(scene, name), getattr(first, name)
        if value != expected:
            raise SceneError(
                f"crane {i}: {name} = {value}, that of crane 0 is {expected}: a batch keeps one "
                "time"
            )
    if scene.joint_names != first.joint_names:
        own, expected = (shorten(list(each.joint_names)) for each in (scene, first))
        raise SceneError(
            f"crane {i}: its joints are {own}, those of crane 0 {expected}: a batch has the same "
            "joints"
        )
    if scene.hardware is not None and not scene.hardware.ideal:
        raise SceneError(
            "sensors, actuators and faults: a batch has none; leave them out, or use simulate"
        )
    if scene.sampled and not system.command.has_implementation(type(scene.law)):
        raise SceneError(
            f"control.law = {scene.law_name!r}: has no compiled form, which a batch needs; use "
            "simulate"
        )


Array = npt.NDArray[np.float64]


Share = Callable[[int, int], None]  # simulates cranes `first` to `last` (excluded)


@dataclass(frozen=True, repr=False)
class Batch:
    """Results of n cranes: joint coordinates in the order of joint_names, world frame, SI units.

    Of a crane that failed, `errors` has one line on time and reason, q, v and payload are those at
    the end of the last whole period before that, and later samples are not numbers.
    """

    joint_names: tuple[str, ...]  # nq
    t: Array  # (n,) s, of q, v and payload: the duration, less for a crane that failed
    q: Array  # (n, nq)
    v: Array  # (n, nq)
    payload: Array  # (n, 3) m
    errors: tuple[str | None, ...]  # (n,), None where nothing went wrong
    evaluations: npt.NDArray[np.int64]  # (n,), of the equations
    steps: npt.NDArray[np.int64]  # (n,)
    sample_times: Array  # (m,) s
    sampled_q: Array  # (n, m, nq)
    sampled_v: Array  # (n, m, nq)
    sampled_payload: Array  # (n, m, 3) m
    lanes: int  # cranes that moved in step
    setup_time: float  # s, to check the scenes and to compile what moves them
    wall_time: float  # s, to move them
    notes: tuple[Mapping[str, Any], ...]  # (n,), of the scenes: what was chosen, `rounded`,
    # `warnings`
    metrics: Mapping[str, npt.NDArray[Any]] | None = None  # (n,) each, of the summaries of
    # `simulate`, if asked for
    events: tuple[tuple[Any, ...], ...] | None = None  # (n,), likewise

    @property
    def figures(self) -> Mapping[str, npt.NDArray[Any]] | None:
        """Deprecated name of `metrics`, for one release."""
        warnings.warn("Batch.figures is now Batch.metrics", DeprecationWarning, stacklevel=2)
        return self.metrics

    def __repr__(self) -> str:
        """Return the number of cranes, and of failed ones, in one line."""
        failed = sum(error is not None for error in self.errors)
        return f"<Batch of {len(self.t)} cranes: {len(self.joint_names)} joints, {failed} failed>"


def simulate_batch(
    scene: SceneSource,
    parameters: Mapping[str, Any],
    duration: float | None = None,
    sample_times: Sequence[float] | Array | None = None,
    threads: int | None = None,
    metrics: bool = False,
    figures: bool | None = None,
) -> Batch:
    """Run a scene for many values of its parameters.

    Args:
        scene: a Scene, or what `load_scene` reads.
        parameters: by dotted key of the scene, such as "payload.mass", "initial.q" or "control.kp":
            one value for each crane, an array or a sequence whose first axis is the crane.
        duration: s, the scene's own when None.
        sample_times: instants [s], within the run, increasing, of q, v and payload in addition to
            the end.
        threads: the processor's cores when None.
        metrics: whether the result has the metrics and events of `simulate`; they are gathered one
            by one, and cranes with switches run once more for them.
        figures: deprecated name of `metrics`, for one release.

    Cranes whose scenes differ in kind (of model, method or law) run in groups of one kind.

    Raises:
        SceneError: the scene of a crane is invalid, or it has other joints or periods than the
            first one.
        ValueError: the instants are not within the run.
    """
    if threads is not None and threads < 1:
        raise SceneError(f"threads = {threads}: must be at least 1")
    if figures is not None:
        warnings.warn(
            "simulate_batch(figures=...) is now simulate_batch(metrics=...)",
            DeprecationWarning,
            stacklevel=2,
        )
        metrics = figures
    start = time.perf_counter()
    scenes = scenes_of(scene, parameters, duration)
    times = checked_times(sample_times, scenes[0].steps * scenes[0].period)
    checked = time.perf_counter() - start
    batch = run_groups(scenes, times, threads or len(os.sched_getaffinity(0)), metrics)
    return replace(batch, setup_time=checked + batch.setup_time)


def run_groups(scenes: Sequence[Scene], times: Array, threads: int, metrics: bool) -> Batch:
    """Run scenes that may differ in kind, grouped by kind; arguments of `simulate_batch`."""
    keys = (
        (kind_of(make_driven(each)), each.actuated, kind_of_run(each) if metrics else None)
        for each in scenes
    )
    groups, parts, ends = group_indices(keys), list[Batch](), list[RunEnd]()
    for numbers in groups:
        own = [scenes[i] for i in numbers]
        if metrics and has_compiled_metrics(own[0]):
            part, ended = measure_cranes(own, times)
        else:
            part = run_cranes(own, times, threads, moves_in_lanes(own))
            ended = [run_alone(scene) for scene in own] if metrics else []
        parts.append(part)
        ends += ended
    order = np.argsort(np.concatenate(groups))
    batch = parts[0] if len(parts) == 1 else _join(parts, order)
    if not metrics:
        return batch
    ends = [ends[i] for i in order]
    return replace(
        batch,
        metrics=metric_columns([e.metrics for e in ends]),
        events=tuple(e.events for e in ends),
    )


def measure_cranes(scenes: Sequence[Scene], times: Array) -> tuple[Batch, list[RunEnd]]:
    """Run scenes of one kind with compiled metrics; return how each ended as well.

    They are sampled at `times` (m,) [s].
    """
    start, compiled = time.perf_counter(), compile_time()
    ends, arrays = run_with_metrics(scenes, times)
    compiled = compile_time() - compiled
    grid = TimeGrid(scenes[0].period, scenes[0].steps, times)
    return _batch(
        list(scenes), grid, arrays, 1, (compiled, time.perf_counter() - start - compiled)
    ), ends


def _join(parts: Sequence[Batch], order: npt.NDArray[np.int64]) -> Batch:
    """Return the batches of groups as one, whose crane k is number `order[k]` of all."""

    def along(name: str) -> Any:
        values = [getattr(part, name) for part in parts]
        if isinstance(values[0], tuple):
            every = [entry for value in values for entry in value]
            return tuple(every[i] for i in order)
        return np.concatenate(values)[order]

    cranes = ("t", "q", "v", "payload", "errors", "evaluations", "steps", "notes")
    sampled = ("sampled_q", "sampled_v", "sampled_payload")
    total = {
        name: sum(getattr(part, name) for part in parts) for name in ("setup_time", "wall_time")
    }
    joined = {name: along(name) for name in (*cranes, *sampled)}
    return replace(parts[0], **joined, **total, lanes=min(part.lanes for part in parts))


def run_cranes(scenes: Sequence[Scene], times: Array, threads: int, wide: bool) -> Batch:
    """Run scenes of one kind, sampled at `times` (m,), in lanes if `wide`; see `simulate_batch`."""
    start, n = time.perf_counter(), len(scenes)
    grid = TimeGrid(scenes[0].period, scenes[0].steps, times)
    scenes = [*scenes, *[scenes[-1]] * (-n % LANES if wide else 0)]
    # first: it rejects scenes that differ
    cranes = stack_columns([make_driven(scene) for scene in scenes])
    arrays = allocate_arrays(scenes, len(times))
    batch = cranes, grid, arrays
    alone: Share = partial(simulate_range, *batch)
    share: Share = partial(pass_lanes, scenes[0].method, *batch) if wide else alone
    share(0, 0)  # compiles
    alone(0, 0)
    ready = time.perf_counter()
    unit = LANES if wide else 1
    with ThreadPoolExecutor(threads) as pool:
        # some eight pieces for each thread: they may differ in length
        size = unit * (1 + n // (8 * threads * unit))
        starts = range(0, len(scenes), size)
        list(pool.map(lambda first: share(first, min(first + size, len(scenes))), starts))
        if wide:
            failed = np.flatnonzero(arrays.counts[:n, 0] != Status.OK).tolist()
            _repeat_alone(pool, scenes, failed, grid, arrays)
    return _batch(scenes[:n], grid, arrays, unit, (ready - start, time.perf_counter() - ready))


def _repeat_alone(
    pool: ThreadPoolExecutor,
    scenes: Sequence[Scene],
    failed: Sequence[int],
    grid: TimeGrid,
    arrays: BatchArrays,
) -> None:
    """Run those that failed in lanes once more, one by one, to know when and why."""
    # laws with their initial state
    again = stack_columns([make_driven(scene) for scene in scenes]) if failed else None
    list(pool.map(lambda i: simulate_range(again, grid, arrays, i, i + 1), failed))


def moves_in_lanes(scenes: Sequence[Scene]) -> bool:
    """Return whether the cranes take the same steps, without branches, and fill most lanes."""
    first = scenes[0]
    in_step = isinstance(first.method, RK4 | RK8) and all(
        scene.method == first.method for scene in scenes
    )
    starts = begin(first.model, np.array(first.initial_q), np.array(first.initial_v))[0]
    smooth = starts.event_log is None and not system.rhs_into.has_implementation(type(first.model))
    return in_step and smooth and 2 * len(scenes) >= LANES


def _batch(
    scenes: list[Scene], grid: TimeGrid, arrays: BatchArrays, lanes: int, times: tuple[float, float]
) -> Batch:
    n, nq = len(scenes), len(scenes[0].joint_names)
    rows, payload, counts = arrays.rows[:n], arrays.payload[:n], arrays.counts[:n]
    end, before = (rows[:, -1], payload[:, -1]), (rows[:, :-1], payload[:, :-1])
    return Batch(
        joint_names=scenes[0].joint_names,
        t=counts[:, 1] * grid.period,
        q=end[0][:, :nq],
        v=end[0][:, nq : 2 * nq],
        payload=end[1],
        errors=errors_of(scenes, arrays),
        evaluations=counts[:, 2],
        steps=counts[:, 3],
        sample_times=grid.times,
        sampled_q=before[0][..., :nq],
        sampled_v=before[0][..., nq : 2 * nq],
        sampled_payload=before[1],
        lanes=lanes,
        setup_time=times[0],
        wall_time=times[1],
        notes=tuple(scene.notes for scene in scenes),
    )
