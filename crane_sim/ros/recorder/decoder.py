"""Decoder of a run's messages, as stamps and numbers, for a recorder; independent of ROS."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isnan
from typing import TYPE_CHECKING, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from crane_sim.recording import states
from crane_sim.ros.common import messages
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.command_filter import CommandValidator, largest_efforts
from crane_sim.ros.common.messages import MalformedMessage, SimulationState
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec

if TYPE_CHECKING:
    from crane_sim.recording.rerun.recorder import Recorder
    from crane_sim.scenes.scene import Scene

TOPICS = (
    "joint_states",
    "true_states",
    "applied_effort",
    "joint_commands",
    "accepted_command",
    "held_command",
    "joint_trajectory",
    "simulation_state",
    "/diagnostics",
)
# m or rad: beyond it is no crane's, and soon no picture's single precision
_LARGEST_REFERENCE = 1e9
STATE_NAMES = tuple(state.name.lower() for state in SimulationState)


class MessageDecoder:
    """Callbacks of serialized messages that pass their numbers on to a recorder.

    Attributes:
        refused: number of messages that do not fit, by topic.
    """

    def __init__(self, scene: "Scene", recorder: "Recorder", source: str = "") -> None:
        """Create a decoder for a scene's joints; `source` is the plant's name in diagnostics."""
        self._source, self.refused = source, Counter[str]()
        # commands refused up to the newest diagnostics [ns]
        self._refused, self._last_diagnostics_stamp = 0, 0
        self._recorder, self._scene, self._quitting, self._has_held_commands = (
            recorder,
            scene,
            False,
            False,
        )
        self._joints, self._actuated = list(scene.joint_names), list(scene.actuated)
        self._state_codec = JointStateCodec(scene.joint_names, STATE)
        self._effort_codec, self._command_codec = (
            JointStateCodec(scene.actuated, EFFORT),
            CommandCodec(scene),
        )
        self._validator = CommandValidator(
            scene.actuated, largest_efforts(scene), scene.joint_names
        )  # as the plant's own

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        """Return one callback of a serialized message per topic."""
        callbacks: dict[str, Callable[[bytes], bool]] = {
            "joint_states": self._on_state,
            "true_states": self._on_true_state,
            "applied_effort": self._on_effort,
            "joint_commands": self._on_command,
            "accepted_command": self._on_accepted,
            "held_command": self._on_held,
            "joint_trajectory": self._on_reference,
            "simulation_state": self._on_simulation_state,
            "/diagnostics": self._on_diagnostics,
        }
        return {
            topic: partial(self._read, topic, callback) for topic, callback in callbacks.items()
        }

    def _read(self, topic: str, callback: Callable[[bytes], bool], data: bytes) -> None:
        """Pass a message on, and count it where it does not fit: a topic may carry anything."""
        try:
            fits = callback(data)
        except MalformedMessage:
            fits = False
        if not fits:
            self.refused[topic] += 1

    def _on_state(self, data: bytes) -> bool:
        return self._add_motion(self._recorder.add_state, data)

    def _on_true_state(self, data: bytes) -> bool:
        return self._add_motion(self._recorder.add_true_state, data)

    def _add_motion(
        self, add: Callable[[int, Sequence[float], Sequence[float]], None], data: bytes
    ) -> bool:
        """Add the state in a message, unless it lacks joints or numbers."""
        state = self._state_codec.decode(data)
        vectors = state.sort_by_joint(self._joints, state.position, state.velocity)
        if vectors:
            add(state.stamp, *vectors)
        return vectors is not None

    def _on_effort(self, data: bytes) -> bool:
        if self._quitting:
            return True  # the zero effort after the last step belongs to no step
        applied = self._effort_codec.decode(data)
        vectors = applied.sort_by_joint(self._actuated, applied.effort)
        if vectors:
            self._recorder.add_effort(applied.stamp, *vectors)
        return vectors is not None

    def _on_command(self, data: bytes) -> bool:
        return self._has_held_commands or self._add_command(self._recorder.add_command, data)

    def _on_accepted(self, data: bytes) -> bool:
        return self._has_held_commands or self._add_command(self._recorder.add_accepted, data)

    def _add_command(self, add: Callable[[int, Sequence[float]], None], data: bytes) -> bool:
        decoded = self._command_codec.decode(data)
        command = self._validator.match_joints(decoded.names, self._command_codec.values(decoded))
        if command is None or decoded.stamp < 0:
            return False
        add(decoded.stamp, command)
        return True

    def _on_held(self, data: bytes) -> bool:
        """Add what the drives were given, none in braking; it precedes the accepted command."""
        decoded = self._command_codec.decode(data)
        values = self._command_codec.values(decoded)
        brakes = (
            decoded.names == self._actuated
            and len(values) == len(self._actuated)
            and all(map(isnan, values))
        )
        command = None if brakes else self._validator.match_joints(decoded.names, values)
        fits = decoded.stamp > 0 and (brakes or command is not None)
        if fits:
            self._has_held_commands = True
            self._recorder.add_accepted(decoded.stamp, command)
        return fits

    def _on_reference(self, data: bytes) -> bool:
        message: JointTrajectory = messages.deserialize(data, JointTrajectory)
        stamp = messages.nanoseconds(message.header.stamp)
        if not message.points:
            return True
        point = cast(Sequence[JointTrajectoryPoint], message.points)[-1]
        target = self._sort_by_joint(list(message.joint_names), list(point.positions))
        if target is None:
            return True  # coordinates of another kind are the payload's
        fits = all(abs(value) < _LARGEST_REFERENCE for value in target)
        if fits:
            self._recorder.add_reference(stamp, target)
        return fits

    def _on_simulation_state(self, data: bytes) -> bool:
        state = messages.decode_simulation_state(data)
        if state is None:
            return False
        self._quitting = state == SimulationState.QUITTING or (
            self._quitting and state == SimulationState.STOPPED
        )
        self._recorder.add_simulation_state(
            STATE_NAMES[state] if state < len(STATE_NAMES) else str(state)
        )
        return True

    def _on_diagnostics(self, data: bytes) -> bool:
        """Add what diagnostics report of controller, newly refused commands, and a stop."""
        message: DiagnosticArray = messages.deserialize(data, DiagnosticArray)
        for status in cast(Sequence[DiagnosticStatus], message.status):
            if status.name == self._source:
                values = {pair.key: pair.value for pair in cast(Sequence[KeyValue], status.values)}
                self._add_diagnostics(messages.nanoseconds(message.header.stamp), values)
        return True

    def _add_diagnostics(self, stamp: int, values: Mapping[str, str]) -> None:
        """Add diagnostics to the timelines of controller, emergency stop and commands."""
        add = self._recorder.add_timeline_state
        add(
            states.CONTROLLER,
            "answers",
            stamp,
            "silent" if "warning: commands" in values else "answers",
        )
        add(
            states.STOP, "released", stamp, "pressed" if "warning: brakes" in values else "released"
        )
        if stamp < self._last_diagnostics_stamp:  # the plant was reset, and counts anew
            self._refused, self._last_diagnostics_stamp = 0, 0
        counts = [count for key, count in values.items() if key.startswith("refused: ")]
        refused = sum(int(count) for count in counts if count.isdecimal())
        add(
            states.COMMANDS,
            "accepted",
            self._last_diagnostics_stamp,
            "refused" if refused > self._refused else "accepted",
        )
        self._refused, self._last_diagnostics_stamp = refused, stamp

    def _sort_by_joint(
        self, names: Sequence[str], values: Sequence[float]
    ) -> tuple[float, ...] | None:
        """Return one value per actuated joint, or None where names are missing or unknown."""
        by_name = dict(zip(names, values, strict=False))
        if by_name.keys() != set(self._scene.actuated):
            return None
        return tuple(by_name[name] for name in self._scene.actuated)


def source_of(node: Node) -> str:
    """Return the name, in diagnostics, of the plant in the namespace of a node."""
    return f"{node.get_namespace().strip('/')}/plant"
