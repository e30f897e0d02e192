"""Reader of bags of `crane run --mcap`: the scene from the metadata, steps from the messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from crane_sim.recording.bag_messages import Message, UnreadableBag, read_messages
from crane_sim.recording.blocks import block_of, run_of_block
from crane_sim.recording.completeness import Completeness, Steps, assess
from crane_sim.recording.digest import agrees
from crane_sim.recording.layout import Layout, layout_of_scene
from crane_sim.recording.mcap.reader import END, RUN, mcap_file, read_metadata
from crane_sim.recording.run import RecordedRun, UnreadableRecording, parse_scene
from crane_sim.recording.step_assembler import Row, StepAssembler
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.hardware import is_sensed

REQUIRED_TOPICS = ("joint_states", "applied_effort")
OPTIONAL_TOPICS = (
    "true_states",
    "joint_commands",
    "accepted_command",
    "held_command",
    "joint_trajectory",
)


RUN_PROPERTIES = ("provenance", "drawn")  # those that do not follow from the scene


class BagSteps(NamedTuple):
    """The control steps of a run as far as a bag has them."""

    rows: list[Row]
    lost: int  # number of steps before the last one that lack a message
    lost_commands: int  # number of rows without their command, while no brakes acted
    true_states: bool  # the rows' states are not those that sensors measure


def read_bag_run(path: Path) -> RecordedRun:
    """Return the run in a bag, as its recording would have it, but for events and metrics.

    No message has these.

    Of one that is cut or damaged that are the steps whose messages are whole.

    Raises:
        UnreadableRecording: the file lacks the scene, or messages; the message is one line.
    """
    properties = read_metadata(mcap_file(path), RUN)
    if "scene_file" not in properties:
        raise UnreadableRecording(
            f"{path}: has no scene: it is no bag of crane run --mcap, or of an older version"
        )
    try:
        contents = read_messages(path, REQUIRED_TOPICS, OPTIONAL_TOPICS)
    except UnreadableBag as error:
        raise UnreadableRecording(f"{path}: {error}") from None
    if not agrees(properties, contents.is_checked):
        raise UnreadableRecording(f"{path}: is damaged: its scene is not as it was written")
    scene = _load_scene(properties, path)
    steps = decode_steps(scene, contents.messages)
    if not steps.rows:
        raise UnreadableRecording(
            f"{path}: has no control step: no joint_states with an applied_effort of its stamp"
        )
    end, damage = contents.metadata.get(END, {}), contents.damage
    if not agrees(end, contents.is_checked):
        end = {}
        damage = damage or "its end is not as it was written"
    layout = _make_layout(scene, properties, steps.true_states)
    run = run_of_block(layout, block_of(scene, steps.rows), _summary(scene, steps, end))
    return replace(run, path=path, completeness=_assess(scene, steps.rows, end, damage))


def _load_scene(properties: Mapping[str, str], path: Path) -> Scene:
    scene = load_scene(parse_scene(properties["scene_file"], path), own_law=False)
    if properties.get("law") == "external":  # another node commanded, whatever law the scene has
        scene = scene.with_external_commands()
    return scene


def _make_layout(scene: Scene, properties: Mapping[str, str], truth: bool) -> Layout:
    """Return the layout of a scene with the bag's properties that do not follow from it."""
    layout = layout_of_scene(scene, "", truth)
    kept = {key: value for key, value in properties.items() if key in RUN_PROPERTIES}
    return layout._replace(properties={**layout.properties, **kept})


def decode_steps(scene: Scene, messages: Sequence[Message]) -> BagSteps:
    """Return the control steps that follow from messages of a run of a scene."""
    has_true_states = any(message.topic == "true_states" for message in messages)
    decoder = _Decoder(scene, has_true_states)
    for message in messages:
        decoder.decode(message)
    rows, counts = decoder.steps.pop_rows(final=True), decoder.steps
    return BagSteps(
        rows, counts.lost_steps, counts.lost_commands, has_true_states or not is_sensed(scene)
    )


def _summary(scene: Scene, steps: BagSteps, end: Mapping[str, str]) -> dict[str, Any]:
    recorded = len(steps.rows)
    entries: dict[str, Any] = {"scene": scene.name, "law": scene.law_name, "seed": scene.seed}
    entries |= {"steps": recorded + steps.lost, "recorded_steps": recorded}
    entries |= {"lost_steps": steps.lost + steps.lost_commands}
    entries |= {"lost_commands": steps.lost_commands} if steps.lost_commands else {}
    subjects = {"steps": steps.lost, "commands": steps.lost_commands}
    missing = [f"{number} {name}" for name, number in subjects.items() if number]
    if missing:
        entries["error"] = f"{' and '.join(missing)} are not in the bag"
    return entries | {key: end[key] for key in ("ended_by", "error") if key in end}


def _assess(scene: Scene, rows: Sequence[Row], end: Mapping[str, str], damage: str) -> Completeness:
    """Return the completeness of a bag.

    A bag by an older version has no end: it is compared to the scene's duration.
    """
    good = len(rows)
    steps = int(end["steps"]) if end else max(good, scene.steps)
    lost = 0 if damage else steps - good
    recorded = steps - lost if end or not lost else None
    return assess(
        Steps(good, (rows[-1].step - 1) * scene.period, scene.steps, recorded, lost), damage
    )


class _Decoder:
    """Decoder of messages, whose values it adds to an assembler of steps as a recorder does."""

    def __init__(self, scene: Scene, has_true_states: bool) -> None:
        self._scene, self._uses_held_command = scene, False
        self._kinds = dict(zip(scene.actuated, scene.commands, strict=True))
        self.steps = StepAssembler(
            scene.period_ns, scene.reference, scene.sampled, sensed=has_true_states
        )
        self._callbacks: Mapping[str, Callable[[int, Any], None]] = {
            "joint_states": partial(self._on_state, self.steps.add_state),
            "true_states": partial(self._on_state, self.steps.add_true_state),
            "applied_effort": self._on_effort,
            "joint_commands": self._on_command,
            "accepted_command": self._on_accepted,
            "held_command": self._on_held,
            "joint_trajectory": self._on_reference,
        }

    def decode(self, message: Message) -> None:
        """Add the values of a message of one of the topics."""
        self._callbacks[message.topic](message.stamp, message.content)

    def _on_state(
        self, add: Callable[[int, Sequence[float], Sequence[float]], None], stamp: int, message: Any
    ) -> None:
        q, v = (
            _reorder(self._scene.joint_names, message.name, each)
            for each in (message.position, message.velocity)
        )
        if q is not None and v is not None:
            add(stamp, q, v)

    def _on_effort(self, stamp: int, message: Any) -> None:
        effort = _reorder(self._scene.actuated, message.name, message.effort)
        if effort is not None:
            self.steps.add_effort(stamp, effort)

    def _on_command(self, stamp: int, message: Any) -> None:
        command = self._command(message)
        if command is not None:
            self.steps.add_command(stamp, command)

    def _on_accepted(self, stamp: int, message: Any) -> None:
        command = None if self._uses_held_command else self._command(message)
        if command is not None:
            self.steps.add_accepted(stamp, command)

    def _on_held(self, stamp: int, message: Any) -> None:
        """Add what the drives were given, none while the brakes act.

        It takes precedence over the accepted command.
        """
        if stamp:  # as every step has
            self._uses_held_command = True
            self.steps.add_accepted(stamp, self._command(message))

    def _on_reference(self, stamp: int, message: Any) -> None:
        if message.points:
            target = _reorder(
                self._scene.actuated, message.joint_names, message.points[-1].positions
            )
            if target is not None:
                self.steps.add_reference(stamp, target)

    def _command(self, message: Any) -> tuple[float, ...] | None:
        """Return a command (nu,), each joint's number from the field that commands its drive.

        None where joints do not fit or a number is not finite: a held command is NaN while the
        brakes act.
        """
        columns = [getattr(message, self._kinds.get(name, "effort")) for name in message.name]
        values = [column[i] for i, column in enumerate(columns) if i < len(column)]
        command = _reorder(self._scene.actuated, message.name, values)
        return command if command is not None and all(map(isfinite, command)) else None


def _reorder(
    joints: Sequence[str], names: Sequence[str], values: Sequence[float]
) -> tuple[float, ...] | None:
    """Return the values in the order of `joints`; None if one is missing or unknown."""
    found = dict(zip(names, map(float, values), strict=False))
    return tuple(found[name] for name in joints) if found.keys() == set(joints) else None
