"""The node `recorder`: listens to a run and writes it to a Rerun file; whatever happens to it, the plant goes on."""

import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt8
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from crane_sim import load_scene
from crane_sim.recording.recorder import Recorder
from crane_sim.recording.writer import RecordingError
from crane_sim.ros import messages, process
from crane_sim.ros.process import Fault, Host
from crane_sim.ros.wire import JointWire

if TYPE_CHECKING:
    from crane_sim.scene import Scene

PARAMETERS = {
    "scene": "knuckle_setpoint",  # catalogue name or path
    "path": "runs/run.rrd",  # the recording; <path>.part while it grows
    "live_port": 0,  # serve the run to viewers on this local port, too; 0: do not
}
MODES = ("stopped", "playing", "paused", "quitting")
_DEEP = QoSProfile(depth=10_000)  # more steps than a plant makes while a block is written
_LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class RecorderNode:
    """Subscribes to a run and passes its numbers on to a recorder.

    Attributes:
        over: the plant said that the run has ended.
    """

    def __init__(self, node: Node, scene: "Scene", recorder: Recorder) -> None:
        """Subscribe."""
        self._recorder, self._scene = recorder, scene
        self._state_wire = JointWire(scene.joint_names, effort=False)
        self._effort_wire = JointWire(scene.actuated, effort=True)
        self._began, self.over = False, False
        self._states = node.create_subscription(JointState, "joint_states", self._on_state, _DEEP, raw=True)
        self._efforts = node.create_subscription(JointState, "applied_effort", self._on_effort, _DEEP, raw=True)
        self._others = (
            node.create_subscription(JointState, "joint_commands", self._on_command, _DEEP, raw=True),
            node.create_subscription(JointTrajectory, "joint_trajectory", self._on_reference, _DEEP),
            node.create_subscription(UInt8, "simulation_state", self._on_mode, _LATCHED),
        )

    def missing(self) -> str:
        """Return one line on the peer still missing, empty when the plant is there."""
        for subscription in (self._states, self._efforts):
            if not subscription.get_publisher_count():
                return f"a publisher of {subscription.topic_name}"
        return ""

    def _on_state(self, data: bytes) -> None:
        state = self._state_wire.decode(data)
        self._recorder.state(state.stamp, state.position, state.velocity)

    def _on_effort(self, data: bytes) -> None:
        applied = self._effort_wire.decode(data)
        self._recorder.effort(applied.stamp, applied.effort)

    def _on_command(self, data: bytes) -> None:
        command = self._effort_wire.decode(data)
        effort = self._sorted(command.names, command.effort)
        if effort is not None:
            self._recorder.command(command.stamp, effort)

    def _on_reference(self, message: JointTrajectory) -> None:
        if message.points:
            point = cast(Sequence[JointTrajectoryPoint], message.points)[-1]
            target = self._sorted(list(message.joint_names), list(point.positions))
            if target is not None:
                self._recorder.reference(messages.nanoseconds(message.header.stamp), target)

    def _on_mode(self, message: UInt8) -> None:
        name = MODES[message.data] if message.data < len(MODES) else str(message.data)
        self._began = self._began or name == "playing"
        self.over = self._began and name in ("stopped", "quitting")
        self._recorder.mode(name)

    def _sorted(self, names: Sequence[str], values: Sequence[float]) -> tuple[float, ...] | None:
        """Return one value per actuated joint, or None for what the plant refuses, too."""
        by_name = dict(zip(names, values, strict=False))
        if by_name.keys() != set(self._scene.actuated):
            return None
        return tuple(by_name[name] for name in self._scene.actuated)


def serve(host: Host, settings: SimpleNamespace, kept: list[object]) -> None:
    """Record until told to finish, or until the run is over; what must outlive a failure goes into `kept`.

    Raises:
        Fault: the recording could not be written.
    """
    scene = load_scene(settings.scene)
    try:
        recorder = Recorder(scene, Path(settings.path), settings.live_port or None)
    except RecordingError as error:
        kept.append(error)
        raise Fault(str(error)) from error
    kept.append(recorder)
    node = RecorderNode(host.node, scene, recorder)
    host.wait(node.missing)
    host.pipes.report("ready")
    _listen(host, node, recorder)
    summary = _summary(scene, host.stopping)
    while not host.stopping.startswith("interrupted") and not recorder.has_all(summary.get("steps")):
        host.spin()
    added = recorder.finish(summary)
    host.pipes.report("done", summary=added)
    if recorder.broken:
        raise Fault(recorder.broken)
    host.node.get_logger().info(f"recorded {added['recorded_steps']} steps in {added['recording']}")


def _listen(host: Host, node: RecorderNode, recorder: Recorder) -> None:
    complained = False
    while not host.stopping and (host.pipes.attached or not node.over):
        host.spin()
        recorder.idle()
        if recorder.broken and not complained:
            complained = True
            host.node.get_logger().error(f"{recorder.broken}; the run goes on unrecorded")


def _summary(scene: "Scene", order: str) -> dict[str, Any]:
    """Return the summary that came with the order to finish, or what the recorder itself knows."""
    _, _, document = order.partition(" ")
    own = {"scene": scene.name, "law": scene.law_name, "seed": scene.seed}
    return json.loads(document) if document else own | ({"ended_by": order} if order else {})


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    kept: list[object] = []
    code = process.main("recorder", PARAMETERS, lambda host, settings: serve(host, settings, kept))
    if code:  # Rerun waits for ever, at interpreter exit and where its stream is freed, for a file it could not write
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
