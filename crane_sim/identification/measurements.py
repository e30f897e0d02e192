"""Measured runs: joint positions and the commands that led to them, from a recording or bag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.identification.bags import read_bag
from crane_sim.recording.read import read_recording
from crane_sim.recording.run import RecordedRun
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.hardware import HardwareRun

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene
    from crane_sim.simulation.rollout import Rollout

Array = npt.NDArray[np.float64]


NANOSECOND = 9  # digits to which times of samples are rounded, so that those of one instant are one
EARLY = 1e-6  # of a sample's spacing: rounding of its time


class Measurements(NamedTuple):
    """Positions and commands of one run, each at its own instants, which increase."""

    t: Array  # (K,) s, of the positions, from the start of the scene's time
    joints: tuple[str, ...]  # m names of measured joints
    q: Array  # (K, m) m or rad, NaN where a joint was not measured
    command_times: Array  # (C,) s, from which each command is held
    commands: Array  # (C, nu), in the order and the units of the scene's actuated joints
    from_start: bool = False  # whether drives had their initial demands before the first command;
    # else that command


Source: TypeAlias = "Measurements | RecordedRun | Rollout | Path | str"  # of a run


def measurements_of(source: Source, scene: Scene) -> Measurements:
    """Return what a recording or a bag, by its path, or a run that is here has of a scene's crane.

    Raises:
        SceneError: it cannot be read, or is of another crane; the message is one line.
    """
    if isinstance(source, Path | str):
        return read_measurements(source, scene)
    if isinstance(source, RecordedRun):
        return from_recording(source, scene)
    if isinstance(source, Measurements):
        return select(_checked(source, scene), scene.actuated, scene, "run")
    found = select(from_rollout(source), source.scene.actuated, scene, "run")
    _check_units(source.scene.actuated, source.scene.command_units, scene, "run")
    return found


def _checked(given: Measurements, scene: Scene) -> Measurements:
    """Return measurements of one's own as arrays.

    Raises:
        SceneError: a joint is not the scene's, or the shapes do not fit each other; the message is
            one line.
    """
    for name in given.joints:
        if name not in scene.joint_names:
            raise SceneError(f"measurements: {unknown_key(name, scene.joint_names, 'joint')}")
    if len(set(given.joints)) < len(given.joints):
        raise SceneError(
            f"measurements: joints {', '.join(given.joints)}: one of them stands twice"
        )
    arrays = {
        name: _as_array(name, getattr(given, name))
        for name in ("t", "q", "command_times", "commands")
    }
    samples, commands = arrays["t"].size, arrays["command_times"].size
    shapes = {
        "t": (samples,),
        "q": (samples, len(given.joints)),
        "command_times": (commands,),
        "commands": (commands, len(scene.actuated)),
    }
    for name, shape in shapes.items():
        if arrays[name].shape != shape:
            raise SceneError(
                f"measurements: {name} has the shape {arrays[name].shape}, must have {shape}"
            )
    return given._replace(**arrays)


def _as_array(name: str, values: Any) -> Array:
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"measurements: {name}: must be an array of numbers") from None


def read_measurements(path: Path | str, scene: Scene) -> Measurements:
    """Return positions and commands of a scene's crane from FILE.rrd or a bag FILE.mcap.

    Raises:
        SceneError: it cannot be read, or is of another crane; the message is one line.
    """
    file = Path(path)
    if file.name.removesuffix(".part").endswith(".rrd"):
        return from_recording(read_recording(file), scene)
    bag = read_bag(file, scene.joint_names, scene.actuated, scene.commands)
    start = bag.states.nanoseconds[0]
    t, command_times = (1e-9 * (track.nanoseconds - start) for track in bag)
    found = Measurements(t, bag.states.names, bag.states.values, command_times, bag.commands.values)
    return undo_sensors(select(found, bag.commands.names, scene, str(path)), scene)


def from_recording(run: RecordedRun, scene: Scene) -> Measurements:
    """Return the positions of a recorded run, as its sensors measured them, and its commands.

    A run in open loop has no commands: the inputs of drives that hold them stand for these, or
    constant efforts.
    """
    lengths = np.rint(np.diff(run.t) / run.period)
    if np.any(lengths != 1.0):
        at = float(run.t[np.flatnonzero(lengths != 1.0)[0]])
        raise SceneError(
            f"{run.path}: steps after t = {at:g} s are not in the recording: their commands are "
            "not known"
        )
    q = run.q if run.q_measured is None else run.q_measured
    commands = _commands(run.commands, run.u, run.t, lambda: _scene_of(run), str(run.path))
    from_start = bool(run.t.size and run.t[0] == 0.0)
    measured = Measurements(run.t, run.crane.joint_names, q, run.t, commands, from_start)
    selected = select(measured, run.crane.actuated, scene, str(run.path))
    _check_units(run.crane.actuated, run.crane.command_units, scene, str(run.path))
    return undo_sensors(selected, scene)


def _scene_of(run: RecordedRun) -> Scene:
    """Return the scene of a recorded run; a law of a file is not executed."""
    return load_scene(run.scene_values, own_law=False)


def _check_units(
    actuated: tuple[str, ...], units: tuple[str, ...], scene: Scene, source: str
) -> None:
    """Raise SceneError where a joint was commanded in another unit than the scene's drive has."""
    recorded = dict(zip(actuated, units, strict=True))
    for name, unit in zip(scene.actuated, scene.command_units, strict=True):
        if recorded.get(name, unit) != unit:
            what = f"commands of {name} are in {recorded[name]}, the scene's drive takes {unit}"
            raise SceneError(f"{source}: {what}; give the scene the drives of the run (actuators)")


def _commands(
    given: Array, applied: Array, t: Array, scene: Callable[[], Scene], source: str
) -> Array:
    """Return the commands (K, nu) of a run.

    In open loop these are the inputs of drives that hold them, and constant efforts.

    Args:
        given: (K, nu), NaN in open loop.
        applied: (K or more, nu) efforts at t (K or more,) [s].
        t: starts of the periods.
        scene: returns that of the run.
        source: name of the run.

    Raises:
        SceneError: an input acted between the samples, too.
    """
    if np.isfinite(given).any() or not given.size:
        return given
    own, found = scene(), applied[: len(given)]
    held = np.isin(own.actuated, () if own.sampled else own.held)
    if held.any():
        take = HardwareRun(own).open_loop_command
        found = np.where(
            held,
            [take(time, own.initial_q, own.initial_v) for time in t[: len(given)].tolist()],
            found,
        )
    if (changing := ~held & np.any(found != found[0], axis=0)).any():
        names = ", ".join(np.array(own.actuated)[changing])
        possible = (
            "commands of a law or of a node, constant inputs, and inputs of drives that hold them "
            "(lag, rate limit)"
        )
        raise SceneError(
            f"{source}: has no commands of {names}, which acted between samples, too; possible: "
            f"{possible}"
        )
    return found


def from_rollout(run: Rollout, noise: float = 0.0, seed: int = 0) -> Measurements:
    """Return a simulated run's positions as encoders with normal noise [rad, m] show them."""
    q = run.q + np.random.default_rng(seed).normal(0.0, 1.0, run.q.shape) * noise
    # s, of the periods
    command_times = run.scene.period * np.arange(len(run.commands), dtype=np.float64)
    commands = _commands(run.commands, run.u, command_times, lambda: run.scene, "run")
    return Measurements(run.t, run.scene.joint_names, q, command_times, commands, from_start=True)


def select(found: Measurements, driven: tuple[str, ...], scene: Scene, source: str) -> Measurements:
    """Return what was found with its joints and commands (C, len(driven)) in the scene's order.

    Raises:
        SceneError: joints or actuated joints are not the scene's, a command is missing, or times do
            not increase.
    """
    joints = tuple(name for name in scene.joint_names if name in found.joints)
    _check_names(found, driven, scene, source)
    for times in (found.t, found.command_times):
        if (back := np.flatnonzero(~(np.diff(times) > 0.0))).size:
            raise SceneError(
                f"{source}: times must increase, and do not after t = {times[back[0]]:g} s"
            )
    q = found.q[:, [found.joints.index(name) for name in joints]]
    commands = found.commands[:, [driven.index(name) for name in scene.actuated]]
    if bad := np.flatnonzero(~np.isfinite(commands).all(axis=1)).tolist():
        raise SceneError(
            f"{source}: no command at t = {found.command_times[bad[0]]:g} s: brakes acted, or it "
            "is lost"
        )
    return found._replace(
        joints=joints,
        q=np.where(np.isfinite(q), q, np.nan),
        commands=np.ascontiguousarray(commands),
    )


def _check_names(found: Measurements, driven: tuple[str, ...], scene: Scene, source: str) -> None:
    """Raise SceneError where all of the scene's joints, or commands of it, are missing."""
    missing = [name for name in scene.actuated if name not in driven]
    if not any(name in found.joints for name in scene.joint_names):
        what = f"position of {', '.join(scene.joint_names)}"
    elif missing:
        what = f"commands of {', '.join(missing)}"
    else:
        return
    raise SceneError(
        f"{source}: has no {what}; it has {', '.join(found.joints)}, commands of "
        f"{', '.join(driven)}"
    )


def undo_sensors(found: Measurements, scene: Scene) -> Measurements:
    """Return measurements at the instants at which the scene's sensors took them, less their bias.

    A sample that is published again, between two samples of a slow sensor or after a lost one, is
    no measurement. Noise and quantisation stay: they are what the residuals are made of.
    """
    if scene.hardware is None:
        return found
    sensors, samples = scene.hardware.sensors, list[tuple[Array, Array]]()
    for name, values in zip(found.joints, found.q.T, strict=True):
        sensor = sensors[scene.joint_names.index(name)]
        instants, fresh = _sampling(found.t, values, sensor, scene.period)
        if sensor.dropout > 0.0:
            fresh[1:] &= np.diff(values) != 0.0
        samples.append((instants[fresh], values[fresh] - sensor.bias))
    t = np.unique(np.concatenate([instants for instants, _ in samples]))
    q = np.full((len(t), len(samples)), np.nan)
    for column, (instants, values) in zip(q.T, samples, strict=True):
        column[np.searchsorted(t, instants)] = values
    return found._replace(t=t, q=q)


def _sampling(
    t: Array, values: Array, sensor: Any, period: float
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Return (instants (K,) [s] of the samples published as `values` at t (K,), which are new)."""
    if sensor.every == 1 and sensor.delay == 0:
        return t, np.full(len(t), True)
    if sensor.every == 1:
        instants = np.round(t - sensor.delay * period, NANOSECOND)
        return instants, instants >= 0.0  # before, the first sample was published
    periods = t / period - sensor.delay
    phase = _first_sample(np.round(periods), values, sensor.every)
    number = np.floor((periods - phase) / sensor.every + EARLY)  # of the sample
    instants = np.round((number * sensor.every + phase) * period, NANOSECOND)
    return instants, (np.diff(number, prepend=-1.0) > 0.0) & (number >= 0.0)


def _first_sample(periods: Array, values: Array, every: int) -> float:
    """Return the period, 0 to every - 1, of a slow sensor's first sample in a bag.

    A bag may begin between two samples.

    Args:
        periods: (K,), at which values were published, less the delay.
        values: (K,), which change where a new sample is published; where none does, or all do, it
            is the first one.
        every: periods from sample to sample.
    """
    changes = (np.diff(periods) == 1.0) & (np.abs(np.diff(values)) > 0.0)
    phases = np.unique(periods[1:][changes] % every)
    return float(phases[0]) if len(phases) == 1 else 0.0


def choose_joints(data: Measurements, names: tuple[str, ...]) -> Measurements:
    """Return the measurements of the named joints, of all measured ones without names.

    Each has at least one position.

    Raises:
        SceneError: one of them is not measured.
    """
    for name in names:
        if name not in data.joints:
            raise SceneError(
                f"joint {name!r}: is not measured; measured are {', '.join(data.joints)}"
            )
    chosen = tuple(name for name in data.joints if not names or name in names)
    q = data.q[:, [data.joints.index(name) for name in chosen]]
    if bad := [
        name for name, column in zip(chosen, q.T, strict=True) if not np.isfinite(column).any()
    ]:
        raise SceneError(f"joint {bad[0]!r}: has no position that is a number; choose others")
    rows = np.isfinite(q).any(axis=1)
    return data._replace(joints=chosen, t=data.t[rows], q=np.ascontiguousarray(q[rows]))
