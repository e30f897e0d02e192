"""Replay of a run: a fresh plant takes its commands, and states are compared bit for bit."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from math import isnan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.recording import provenance
from crane_sim.recording.states import BRAKES
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.plant import Plant

if TYPE_CHECKING:
    from crane_sim.recording.run import RecordedRun
    from crane_sim.recording.states import Changes
    from crane_sim.scenes.scene import Scene

Vector = Sequence[float]
_FRACTION_BITS = 52  # of a double; the exponent's and the sign follow


class Difference(NamedTuple):
    """The first component in which a replayed state is not the recorded one."""

    step: int  # 1 for the first one, whose state is the initial one
    time: float  # s
    joint: str
    quantity: str  # "position" or "velocity"
    recorded: float  # m or rad, or their rates
    replayed: float

    @property
    def bit(self) -> int:
        """Highest bit that differs, 0 for the last one of the fraction."""
        return (_bits(self.recorded) ^ _bits(self.replayed)).bit_length() - 1

    def __str__(self) -> str:
        """Return one line."""
        part = (
            f"bit {self.bit} of its fraction"
            if self.bit < _FRACTION_BITS
            else "its exponent or sign"
        )
        where = f"step {self.step} (t = {self.time:g} s): {self.quantity} of {self.joint}"
        return (
            f"{where} is {self.replayed!r}, recorded is {self.recorded!r}; they differ from {part} "
            "on"
        )


class Replay(NamedTuple):
    """Outcome of a replay."""

    steps: int  # whose states were compared, up to the first that differs
    difference: Difference | None
    changed: dict[str, tuple[str, str]]  # of the provenance, what is not as it was: (then, now)


def replay(run: RecordedRun, law: str | None = None) -> Replay:
    """Integrate a recorded run anew from its commands.

    Where commands are NaN the brakes acted, as their timeline says, or a command was lost. What
    services did to the crane in the run, such as faults, is not in a recording: states differ from
    there on. A recorder has the measured states, a recorded `Rollout` the true ones; the run agrees
    where one of the two does.

    Args:
        run: the recorded run.
        law: in place of the run's, which acts only where the equations evaluated it, without
            commands. Code of one's own, FILE.py:FUNCTION or MODULE:FUNCTION, is executed only if it
            is named here.

    Raises:
        SceneError: its scene is none of this version, a step or a command was lost, or it needs a
            law that is not named.
        SimulationError: the integration failed.
    """
    scene = load_scene(run.scene_values, own_law=False) if law is None else run.load_scene(law)
    _check_steps(scene, run)
    # a node commanded a scene without a law
    commanded = scene.sampled or bool(np.isfinite(run.commands).any())
    if not commanded and scene.law is None and scene.law_name is not None:
        scene = run.load_scene()  # which says that it is not executed
    plant = Plant(scene.with_external_commands() if commanded else scene)
    command = scene.idle_command
    true: Difference | None = None
    shown: Difference | None = None
    for k in range(len(run.t)):
        true = true or _difference(scene, k, run, (plant.q, plant.v))
        shown = shown or _difference(scene, k, run, plant.seen)
        if true and shown:
            last = max(true, shown, key=lambda each: each.step)
            return Replay(k + 1, last, _version_changes(run.versions))
        if commanded:
            plant.braking = all(map(isnan, run.commands[k]))
            if plant.braking:
                _check_brakes(scene, run, k)
            command = (
                scene.zero_command(command) if plant.braking else tuple(map(float, run.commands[k]))
            )
        plant.advance(command if commanded else None)
    return Replay(len(run.t), None, _version_changes(run.versions))


def _check_steps(scene: Scene, run: RecordedRun) -> None:
    """Raise SceneError where the recording lacks a step."""
    missing = np.flatnonzero(np.rint(run.t / scene.period) != np.arange(len(run.t)))
    if missing.size:
        raise SceneError(
            f"replay: step {missing[0] + 1} is not in the recording: its command is not known"
        )


def _check_brakes(scene: Scene, run: RecordedRun, k: int) -> None:
    """Raise SceneError where the brakes did not act in period k, which has no command."""
    if not _acts(run.states.get(BRAKES, []), run.t[k] + 0.5 * scene.period):
        raise SceneError(f"replay: the command of step {k + 1} is not in the recording")


def _acts(changes: Changes, t: float) -> bool:
    """Return whether the brakes act at a time [s], by the changes of their timeline."""
    return next((state == "acting" for since, state in reversed(changes) if since <= t), False)


def _difference(
    scene: Scene, k: int, run: RecordedRun, state: tuple[Vector, Vector]
) -> Difference | None:
    """Return the first component of (q, v) that differs as period k starts, None if none does."""
    for quantity, recorded, replayed in zip(
        ("position", "velocity"), (run.q[k], run.v[k]), state, strict=True
    ):
        for joint, then, now in zip(scene.joint_names, recorded.tolist(), replayed, strict=True):
            if _bits(then) != _bits(now):
                return Difference(k + 1, k * scene.period, joint, quantity, then, now)
    return None


def _version_changes(then: dict[str, str]) -> dict[str, tuple[str, str]]:
    now = provenance.of_this_process()
    return {
        name: (value, now.get(name, "none"))
        for name, value in then.items()
        if value != now.get(name)
    }


def _bits(x: float) -> int:
    return struct.unpack("<Q", struct.pack("<d", x))[0]
