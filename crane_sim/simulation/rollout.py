"""The closed loop in one process, without ROS: the same numbers, bit for bit, as a lockstep run.

Whole runs as arrays: a scene under its law, from its initial state to its end or to where it fails.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.files.errors import SceneError, shorten
from crane_sim.files.extensions import find_view
from crane_sim.laws import evaluate_law, with_initial_state
from crane_sim.scenes.scene import Scene, SceneSource, load_scene
from crane_sim.simulation.derived import Derived, derive
from crane_sim.simulation.hardware import HardwareRun
from crane_sim.simulation.metrics import Metrics
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.status import SimulationError, check_status, events_of, noted_events
from crane_sim.stepping.hardware_periods import hardware_rollout
from crane_sim.stepping.periods import Output, Replay, Sampled, begin, output_of, roll_out
from crane_sim.stepping.rows import row_width, split
from crane_sim.tracing.compile_time import compile_time
from crane_sim.trajectories.breakpoints import unwrap

Array = npt.NDArray[np.float64]


class RawRun(NamedTuple):
    """A run, up to where it ended."""

    rows: Array  # (periods + 1, width), see `crane_sim.stepping.rows`
    samples: Array  # (m, width)
    integration: Any  # the integration as it ended
    saturated: int  # periods in which a command was limited
    commands: Array  # (periods, nu), of the law before limits; NaN without one
    hardware: HardwareRun | None = None  # of a scene with hardware
    loads: Array = np.empty((0, 2))  # (begun periods, 2) of the payload: kg, J that its changes
    # supplied up to there

    def segments(self, scene: Scene) -> list[tuple[int, int, Any]]:
        """Return (first period, last one + 1, model) of stretches of constant payload mass."""
        periods = len(self.rows) - 1
        if self.hardware is None or scene.hardware.payload_fault is None:
            return [(0, periods, scene.model)]
        first = [0, *(np.flatnonzero(np.diff(self.loads[:, 0])) + 1).tolist()]
        hardware, after = self.hardware, [*first[1:], periods]
        laden = [hardware.model_with_payload(scene.model, float(self.loads[k, 0])) for k in first]
        return list(zip(first, after, laden, strict=True))

    def payload_energy(self, k: int) -> float:
        """Return the energy [J] supplied by a change of the payload at the start of period k."""
        if not len(self.loads):
            return 0.0
        return float(self.loads[k, 1] - (self.loads[k - 1, 1] if k else 0.0))


def run_raw(scene: Scene, law: Any, times: Array) -> RawRun:
    """Run a scene.

    Args:
        scene: what to run.
        law: of a sampled scene, see `laws.Law`.
        times: sample times (m,), increasing, within the run.

    Raises:
        LawError: the law failed.
    """
    model = scene.model
    integration, q, _ = begin(model, np.array(scene.initial_q), np.array(scene.initial_v))
    nq, nu = len(q), len(scene.actuated)
    rows, samples = (np.empty((n, row_width(model, nq, nu))) for n in (scene.steps + 1, len(times)))
    out = output_of(rows, np.empty((scene.steps, nu)), times, samples)
    if scene.hardware is not None and not scene.hardware.ideal:
        return _with_hardware(scene, law, integration, out)
    source = Sampled(_compile_law(scene, law)) if scene.sampled else scene.source
    integration, periods_done = roll_out(
        scene.method, model, source, integration, scene.period, out
    )
    commands = out.commands[:periods_done]
    limited = np.any(commands != split(rows[:periods_done], nq, nu).u, axis=1)
    given = commands if scene.sampled else np.full_like(commands, np.nan)
    return RawRun(*_whole(scene, out, periods_done), integration, int(limited.sum()), given)


def _with_hardware(scene: Scene, law: Any, integration: Any, out: Output) -> RawRun:
    """Return the run of a scene with hardware.

    Drives that hold their demand take open-loop inputs as commands.
    """
    hardware, loads = HardwareRun(scene), np.empty((scene.steps, 2))
    source = _compile_law(scene, law) if scene.sampled else unwrap(scene.source)
    if type(source) is tuple:
        source = Replay(scene.model, scene.period, np.tile(source, (scene.steps, 1)))
    integration, periods_done = hardware_rollout(
        scene.method,
        scene.model,
        source,
        hardware.state,
        hardware.inputs,
        integration,
        scene.period,
        out,
        loads,
    )
    commands, loads = out.commands[:periods_done], loads[: periods_done + 1]
    commands[:] = commands if scene.sampled else np.nan
    return RawRun(
        *_whole(scene, out, periods_done),
        integration,
        hardware.saturated,
        commands,
        hardware,
        loads,
    )


def _whole(scene: Scene, out: Output, periods_done: int) -> tuple[Array, Array]:
    """Return rows and samples up to the end of the last whole period."""
    samples = (
        out.samples[out.times <= periods_done * scene.period]
        if periods_done < scene.steps
        else out.samples
    )
    return out.rows[: periods_done + 1], samples


def _compile_law(scene: Scene, law: Any) -> Any:
    """Return the law where it is compiled, else a replay of its commands.

    A law in Python is evaluated with a `Plant` in a run of its own, and the second run replays its
    commands: so there is one compiled loop, which writes rows, samples and events alike whatever
    the law is, at the cost of a second integration, small beside calls from Python.
    """
    return (
        law
        if system.command.has_implementation(type(law))
        else Replay(scene.model, scene.period, _collect_commands(scene, law))
    )


def _collect_commands(scene: Scene, law: Any) -> Array:
    """Return the commands (steps, nu) of a Python law, sampled every period.

    They are NaN after a run that fails.
    """
    plant = Plant(scene)
    commands = np.full((scene.steps, len(scene.actuated)), np.nan)
    for k in range(scene.steps):
        command = evaluate_law(law, plant.t, *plant.seen, commands.shape[1])
        commands[k] = command
        try:
            plant.advance(command)
        except SimulationError:  # the replay fails in the same period
            break
    return commands


LawFunction = Callable[[float, tuple[float, ...], tuple[float, ...]], Sequence[float]]


@dataclass(frozen=True, repr=False)
class Rollout:
    """A run: K instants, joints in the order of scene.joint_names, world frame, SI units."""

    scene: Scene  # what was run
    t: Array  # (K,) s
    q: Array  # (K, nq)
    v: Array  # (K, nq)
    u: Array  # (K, nu), efforts applied from t on
    tensions: Array  # (K, L) N, of the links from the top to the payload, positive where a link
    # pulls
    commands: Array  # (periods, nu) efforts that the law demanded at the start of each period; NaN
    # in open loop
    derived: Derived  # what is computed from the states: nodes, energies, swing, ...
    stats: dict[str, Any]  # rhs_evaluations, steps, rejected, wall_time, and compile_time, which is
    # no part of that [s]
    summary: dict[str, Any]  # the metrics that docs/summary.md explains
    events: list[tuple[float, str]]  # (s, what happened), of models whose equations switch

    def __repr__(self) -> str:
        """Return scene, law and main results in two lines; `summary` has all metrics."""
        law = f"law {self.scene.law_name!r}" if self.scene.law_name else "no law of the scene's own"
        shape = f"{len(self.t)} instants up to {self.t[-1]:g} s" if len(self.t) else "no instants"
        ended = f"peak swing {self.summary['peak_swing_deg']:.3g} deg, {len(self.events)} events"
        return (
            f"<Rollout of {self.scene.name!r}, {law}: {shape}, {self.q.shape[1]} joints\n {ended}>"
        )

    @property
    def payload(self) -> Array:
        """Positions of the payload (K, 3) [m]."""
        return self.derived.payload

    @property
    def tip(self) -> Array:
        """Positions of the tip (K, 3) [m]."""
        return self.derived.tip

    @property
    def nodes(self) -> Array:
        """Polyline base .. tip .. payload (K, N, 3) [m]."""
        return self.derived.nodes

    @property
    def tension(self) -> Array:
        """Tension of the uppermost link (K,) [N]."""
        return self.tensions[:, 0]

    @property
    def falls(self) -> Array:
        """Tensions (K, n) [N] of a reeved rope's n falls at the top, lead line to dead end.

        (K, 0) without one.
        """
        return self.derived.falls[:, 1:-1]

    @property
    def lead_line(self) -> Array:
        """Tension (K,) [N] of a reeved rope between drum and falls; (K, 0) without one."""
        return self.derived.falls[:, 0] if self.derived.falls.size else self.derived.falls

    @property
    def drum_torque(self) -> Array:
        """Torque (K,) [N m] on the drum of a reeved rope, positive pays out; (K, 0) without one."""
        return self.derived.falls[:, -1] if self.derived.falls.size else self.derived.falls

    @property
    def energy(self) -> Array:
        """Total energy in the world (K,) [J], weights from its height 0."""
        return self.derived.energy

    @property
    def energy_relative(self) -> Array:
        """Total energy relative to the base (K,) [J]: the same as `energy` where the base rests."""
        return self.derived.energy_relative

    def record(self, path: Path | str) -> Path:
        """Write the run as a recording FILE.rrd; needs the package rerun-sdk.

        It is the same as that of a run over ROS.

        `crane_sim.read_recording` reads it back; the `rerun` viewer shows it. Returns the file's
        path.

        Raises:
            ValueError: the run has samples at other times than its control periods.
            RuntimeError: the file cannot be written.
        """
        return find_view("record")(self, Path(path))

    def plot(self) -> Any:
        """Return a `matplotlib.figure.Figure` of the run, as `RecordedRun.plot` does."""
        return find_view("plot")(self)

    def show(self, height: int = 900) -> Any:
        """Return the run's page for a notebook, `height` pixels high; see `RecordedRun.show`."""
        return find_view("show")(self, height)

    def lyapunov(self) -> Array:
        """Return (V [J], dV/dt [W]) of the scene's law at all instants (K, 2).

        See `laws.EnergyShaping`.

        dV/dt is that of the law's nominal crane; what V does in the run is `np.gradient(V, run.t)`.

        Raises:
            TypeError: the law has none.
        """
        shaped = getattr(self.scene.law, "lyapunov", None)
        if shaped is None:
            raise TypeError(f"law {self.scene.law_name!r} shapes no energy")
        return np.array(
            [shaped(t, tuple(q), tuple(v)) for t, q, v in zip(self.t, self.q, self.v, strict=True)]
        )


def simulate(
    scene: SceneSource,
    law: str | LawFunction | None = None,
    duration: float | None = None,
    sample_times: Sequence[float] | Array | None = None,
    *,
    overrides: Mapping[str, Any] | None = None,
) -> Rollout:
    """Run a scene.

    Args:
        scene: a Scene, or what `load_scene` reads.
        law: None: the scene's own; a name; or a callable(t, q, v) -> efforts (nu,), evaluated every
            control period.
        duration: s, the scene's own when None.
        sample_times: instants of the result [s], within the run, increasing; None: every control
            period. They do not change the steps.
        overrides: changes of the scene by dotted key, as `load_scene` takes them.

    Raises:
        SceneError: the scene, its changes, the law or the instants are not possible.
        SimulationError: the integration failed or the model is no longer valid; its `run` is the
            run up to there.
        LawError: the law failed, or its answer is not a vector of efforts.
    """
    _check_law(law)
    named = {"control.law": law if isinstance(law, str) else None, "duration": duration}
    scene = _with_changes(scene, named, overrides)
    times = checked_times(sample_times, scene.steps * scene.period)
    started, compiled_before = time.perf_counter(), compile_time()
    if not callable(law):
        _check_own_law(scene)
    scene = scene.with_external_commands() if callable(law) else scene
    run = run_raw(scene, with_initial_state(law if callable(law) else scene.law), times)
    wall = time.perf_counter() - started - (compile_time() - compiled_before)
    (rows, samples, integration), model = run[:3], scene.model
    counted = {"rhs_evaluations": integration.evaluations, "steps": integration.steps}
    counted |= {"rejected": integration.rejected, "wall_time": wall}
    periods = np.arange(len(rows), dtype=np.float64) * scene.period
    shown = (periods, rows) if sample_times is None else (times[: len(samples)], samples)
    failed = len(rows) <= scene.steps
    events = events_of(integration, model, periods[-1], failed)
    result = make_rollout(scene, run, *shown, counted, summarize(scene, run), events)
    result.stats["compile_time"] = compile_time() - compiled_before
    if failed:
        _end_early(result, integration, model)
    return result


def _end_early(result: Rollout, integration: Any, model: Any) -> None:
    """Raise the SimulationError of a run that ended before its time, with the run up to there."""
    try:
        check_status(integration, model)
    except SimulationError as error:
        result.summary["error"] = str(error)
        error.run = result
        raise


def _check_law(law: Any) -> None:
    """Raise SceneError for what is no law.

    Changes of the scene are most likely to be given in its place.
    """
    if law is None or isinstance(law, str) or callable(law):
        return
    line = f"law = {shorten(law)}: must be a name or a callable(t, q, v) -> efforts"
    raise SceneError(
        f"{line}; changes of the scene go by name, overrides=..."
        if isinstance(law, Mapping)
        else line
    )


def _check_own_law(scene: Scene) -> None:
    """Raise SceneError where the scene names a law that it does not have."""
    if scene.law_name is not None and scene.law is None:
        raise SceneError(
            f"control.law = {shorten(scene.law_name)}: is not executed (own_law=False); give the "
            "law to use"
        )


def _with_changes(
    scene: SceneSource, named: Mapping[str, Any], overrides: Mapping[str, Any] | None
) -> Scene:
    """Return the scene with changes given by name (None: nothing) and by dotted key."""
    by_name = {key: value for key, value in named.items() if value is not None}
    for key in by_name:
        if isinstance(overrides, Mapping) and key in overrides:
            raise SceneError(
                f"overrides: {key!r} is given by name, too: {by_name[key]!r}; leave out one of the "
                "two"
            )
    changes = (
        by_name
        if overrides is None
        else {**overrides, **by_name}
        if isinstance(overrides, Mapping)
        else overrides
    )
    return load_scene(scene, changes)


def checked_times(times: Sequence[float] | Array | None, end: float) -> Array:
    """Return the instants of a result [s], none when `times` is None.

    Raises:
        ValueError: they are not within 0 .. `end`, or do not increase.
    """
    instants = np.empty(0) if times is None else np.array(times, dtype=np.float64)
    beyond = instants[~((instants >= 0.0) & (instants <= end * (1.0 + 1e-12)))]
    if instants.ndim != 1:
        raise ValueError(
            f"sample_times: must be a list of instants, here the shape is {instants.shape}"
        )
    if len(beyond):
        raise ValueError(f"sample_times: {beyond[:1]} is outside the run, 0 .. {end:g} s")
    if np.any(np.diff(instants) < 0.0):
        raise ValueError("sample_times: must increase")
    return np.minimum(instants, end)


def summarize(scene: Scene, run: RawRun) -> dict[str, Any]:
    """Return the metrics of a run: the summary, without what was measured by the clock."""
    model, rows, integration, nq = scene.model, run.rows, run.integration, len(scene.joint_names)
    metrics = Metrics(
        scene, model, begin(model, np.array(scene.initial_q), np.array(scene.initial_v))[0].x
    )
    t = np.arange(len(rows), dtype=np.float64) * scene.period
    for first, last, laden in run.segments(scene):
        if laden is not model:
            metrics.change(
                replace(scene, model=laden),
                laden,
                tuple(rows[first, :nq]),
                run.payload_energy(first),
            )
        metrics.extend(t[first:last], rows[first:last])
    found = metrics.summary(
        t[-1], tuple(rows[-1, :nq]), tuple(rows[-1, nq : 2 * nq]), integration, run.saturated
    )
    head = {"scene": scene.name, "law": scene.law_name, "mode": "simulate", "seed": scene.seed}
    further = run.hardware.summary() if run.hardware is not None else {}
    return (
        head | found | noted_events(integration, model, t[-1], len(rows) <= scene.steps) | further
    )


def make_rollout(
    scene: Scene, run: RawRun, t: Array, rows: Array, stats: Any, summary: Any, events: Any
) -> Rollout:
    """Return a run with what is derived from its states, rows (K, width) at instants t (K,) [s]."""
    nq = len(scene.joint_names)
    q, v, u, _, tensions = split(rows, nq, len(scene.actuated))
    parts = [
        np.searchsorted(t, np.array((first, last)) * scene.period)
        for first, last, _ in run.segments(scene)
    ]
    parts[-1][1] = len(t)
    pieces = [
        derive(replace(scene, model=laden), t[i:j], q[i:j], v[i:j], u[i:j])
        for (i, j), (_, _, laden) in zip(parts, run.segments(scene), strict=True)
    ]
    whole = (
        pieces[0] if len(pieces) == 1 else Derived(*map(np.concatenate, zip(*pieces, strict=True)))
    )
    return Rollout(scene, t, q, v, u, tensions, run.commands, whole, stats, summary, events)
