"""Reads a bag of `crane run --mcap` back: the scene from its metadata, the control steps from its messages."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import yaml

from crane_sim.recording.bag_messages import UnreadableBag, read_messages
from crane_sim.recording.mcap.metadata import RUN, read_metadata
from crane_sim.recording.run import UnreadableRecording
from crane_sim.recording.step_assembler import StepAssembler
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.hardware import is_sensed

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from crane_sim.recording.bag_messages import Message
    from crane_sim.recording.step_assembler import Row
    from crane_sim.scenes.scene import Scene

NEEDED = ("joint_states", "applied_effort")
FURTHER = ("true_states", "joint_commands", "accepted_command", "held_command", "joint_trajectory")


class BaggedRun(NamedTuple):
    """What a bag has of a run."""

    properties: dict[str, str]  # those of the run's recording, as text
    scene: Scene
    rows: list[Row]  # control steps
    lost: int  # steps before the last one whose messages are not all there
    truth: bool  # the rows' states are the true ones: there are no sensors, or true states beside what they show


def read_bag(path: Path) -> BaggedRun:
    """Return the run in a bag.

    Raises:
        UnreadableRecording: the file is damaged, or lacks the scene or messages; the message is one line.
    """
    properties = read_metadata(path, RUN)
    if "scene_file" not in properties:
        raise UnreadableRecording(f"{path}: has no scene: it is no bag of crane run --mcap, or of an older version")
    scene = load_scene(yaml.safe_load(properties["scene_file"]))
    try:
        messages = read_messages(path, NEEDED, FURTHER)
    except UnreadableBag as error:
        raise UnreadableRecording(f"{path}: {error}") from None
    truth = any(message.topic == "true_states" for message in messages)
    decoder = _Decoder(scene, truth)
    for message in messages:
        decoder.take(message)
    rows = decoder.steps.take(final=True)
    if not rows:
        raise UnreadableRecording(f"{path}: has no control step: no joint_states with an applied_effort of its stamp")
    return BaggedRun(properties, scene, rows, decoder.steps.lost, truth or not is_sensed(scene))


class _Decoder:
    """Passes the numbers of messages on to an assembler of steps, as a recorder does."""

    def __init__(self, scene: Scene, truth: bool) -> None:
        self._scene, self._holds = scene, False
        self._kinds = dict(zip(scene.actuated, scene.commands, strict=True))
        self.steps = StepAssembler(scene.period_ns, scene.reference, scene.sampled, sensed=truth)
        self._callbacks: Mapping[str, Callable[[int, Any], None]] = {
            "joint_states": partial(self._on_state, self.steps.add_state),
            "true_states": partial(self._on_state, self.steps.add_true_state),
            "applied_effort": self._on_effort,
            "joint_commands": self._on_command,
            "accepted_command": self._on_accepted,
            "held_command": self._on_held,
            "joint_trajectory": self._on_reference,
        }

    def take(self, message: Message) -> None:
        """Take a message of one of the topics."""
        self._callbacks[message.topic](message.stamp, message.content)

    def _on_state(self, add: Callable[[int, Sequence[float], Sequence[float]], None], stamp: int, message: Any) -> None:
        q, v = (_sort(self._scene.joint_names, message.name, each) for each in (message.position, message.velocity))
        if q is not None and v is not None:
            add(stamp, q, v)

    def _on_effort(self, stamp: int, message: Any) -> None:
        effort = _sort(self._scene.actuated, message.name, message.effort)
        if effort is not None:
            self.steps.add_effort(stamp, effort)

    def _on_command(self, stamp: int, message: Any) -> None:
        command = self._command(message)
        if command is not None:
            self.steps.add_command(stamp, command)

    def _on_accepted(self, stamp: int, message: Any) -> None:
        command = None if self._holds else self._command(message)
        if command is not None:
            self.steps.add_accepted(stamp, command)

    def _on_held(self, stamp: int, message: Any) -> None:
        if stamp:
            self._holds = True
            self.steps.add_accepted(stamp, self._command(message))

    def _on_reference(self, stamp: int, message: Any) -> None:
        if message.points:
            target = _sort(self._scene.actuated, message.joint_names, message.points[-1].positions)
            if target is not None:
                self.steps.add_reference(stamp, target)

    def _command(self, message: Any) -> tuple[float, ...] | None:
        """Return a command (nu,), each joint's number from the field that its drive is commanded by."""
        columns = [getattr(message, self._kinds.get(name, "effort")) for name in message.name]
        values = [column[i] for i, column in enumerate(columns) if i < len(column)]
        return _sort(self._scene.actuated, message.name, values)


def _sort(joints: Sequence[str], names: Sequence[str], values: Sequence[float]) -> tuple[float, ...] | None:
    """Return one number a joint, or None where names or numbers are missing, or names unknown."""
    found = dict(zip(names, map(float, values), strict=False))
    return tuple(found[name] for name in joints) if found.keys() == set(joints) else None
