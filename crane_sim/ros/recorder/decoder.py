"""Decoder of a run's messages for a recorder, which takes stamps and numbers and is independent of ROS."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from crane_sim.recording import states
from crane_sim.ros.common import messages
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.command_filter import CommandValidator, largest_efforts
from crane_sim.ros.common.messages import SimulationState
from crane_sim.ros.common.serialization import EFFORT, STATE, DecodedJointState, JointStateCodec

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
STATE_NAMES = tuple(state.name.lower() for state in SimulationState)


class MessageDecoder:
    """Callbacks of serialized messages that pass their numbers on to a recorder."""

    def __init__(self, scene: "Scene", recorder: "Recorder", source: str = "") -> None:
        """Create a decoder for the joints of a scene, whose plant has the name `source` in diagnostics."""
        self._source = source
        self._refused, self._last_diagnostics_stamp = 0, 0  # commands refused up to the newest diagnostics [ns]
        self._recorder, self._scene, self._quitting, self._has_held_commands = recorder, scene, False, False
        self._joints, self._actuated = list(scene.joint_names), list(scene.actuated)
        self._state_codec = JointStateCodec(scene.joint_names, STATE)
        self._effort_codec, self._command_codec = JointStateCodec(scene.actuated, EFFORT), CommandCodec(scene)
        self._validator = CommandValidator(
            scene.actuated, largest_efforts(scene), scene.joint_names
        )  # as the plant's own

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        """Return one callback of a serialized message per topic."""
        return {
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

    def _on_state(self, data: bytes) -> None:
        self._add_motion(self._recorder.add_state, data)

    def _on_true_state(self, data: bytes) -> None:
        self._add_motion(self._recorder.add_true_state, data)

    def _add_motion(self, add: Callable[[int, Sequence[float], Sequence[float]], None], data: bytes) -> None:
        """Add the state in a message, unless it lacks joints or numbers, as one of another publisher may."""
        state = _decode(self._state_codec, data)
        vectors = state and state.sort_by_joint(self._joints, state.position, state.velocity)
        if state and vectors:
            add(state.stamp, *vectors)

    def _on_effort(self, data: bytes) -> None:
        if self._quitting:
            return  # the zero effort after the last step belongs to no step
        applied = _decode(self._effort_codec, data)
        vectors = applied and applied.sort_by_joint(self._actuated, applied.effort)
        if applied and vectors:
            self._recorder.add_effort(applied.stamp, *vectors)

    def _on_command(self, data: bytes) -> None:
        stamp, command = self._read_command(data)
        if command is not None:
            self._recorder.add_command(stamp, command)

    def _on_accepted(self, data: bytes) -> None:
        stamp, command = (0, None) if self._has_held_commands else self._read_command(data)
        if command is not None:
            self._recorder.add_accepted(stamp, command)

    def _on_held(self, data: bytes) -> None:
        """Add what the drives were given, none while the brakes act: it takes precedence over the accepted command."""
        stamp, command = self._read_command(data)
        if stamp:
            self._has_held_commands = True
            self._recorder.add_accepted(stamp, command)

    def _read_command(self, data: bytes) -> tuple[int, tuple[float, ...] | None]:
        """Return (stamp [ns], the command (nu,) in a message, or None where it is none)."""
        decoded = _decode(self._command_codec, data)
        if decoded is None:
            return 0, None
        return decoded.stamp, self._validator.match_joints(decoded.names, self._command_codec.values(decoded))

    def _on_reference(self, data: bytes) -> None:
        try:
            message = deserialize_message(data, JointTrajectory)
        except RuntimeError:  # the middleware's: the bytes are no such message
            return
        if message.points:
            point = cast(Sequence[JointTrajectoryPoint], message.points)[-1]
            target = self._sort_by_joint(list(message.joint_names), list(point.positions))
            if target is not None:
                self._recorder.add_reference(messages.nanoseconds(message.header.stamp), target)

    def _on_simulation_state(self, data: bytes) -> None:
        state = messages.decode_simulation_state(data)
        if state is None:
            return
        self._quitting = state == SimulationState.QUITTING or (self._quitting and state == SimulationState.STOPPED)
        self._recorder.add_simulation_state(STATE_NAMES[state] if state < len(STATE_NAMES) else str(state))

    def _on_diagnostics(self, data: bytes) -> None:
        """Add what diagnostics report of the controller, of commands refused since the last message, and of a stop."""
        try:
            message = deserialize_message(data, DiagnosticArray)
        except RuntimeError:
            return
        stamp = messages.nanoseconds(message.header.stamp)
        for status in cast(Sequence[DiagnosticStatus], message.status):
            if status.name == self._source:
                values = {pair.key: pair.value for pair in cast(Sequence[KeyValue], status.values)}
                self._add_diagnostics(stamp, values)

    def _add_diagnostics(self, stamp: int, values: Mapping[str, str]) -> None:
        """Add to the timelines of controller, emergency stop and commands what the plant's diagnostics report."""
        add = self._recorder.add_timeline_state
        add(states.CONTROLLER, "answers", stamp, "silent" if "warning: commands" in values else "answers")
        add(states.STOP, "released", stamp, "pressed" if "warning: brakes" in values else "released")
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

    def _sort_by_joint(self, names: Sequence[str], values: Sequence[float]) -> tuple[float, ...] | None:
        """Return one value per actuated joint, or None where names are missing or unknown."""
        by_name = dict(zip(names, values, strict=False))
        if by_name.keys() != set(self._scene.actuated):
            return None
        return tuple(by_name[name] for name in self._scene.actuated)


def source_of(node: Node) -> str:
    """Return the name, in diagnostics, of the plant in the namespace of a node."""
    return f"{node.get_namespace().strip('/')}/plant"


def _decode(codec: JointStateCodec | CommandCodec, data: bytes) -> DecodedJointState | None:
    """Return a decoded message, None for data of another type: a topic may carry anything."""
    try:
        return codec.decode(data)
    except ValueError:
        return None
