"""The node `controller`: answers every joint state with its law's command, with its stamp.

Of a law with an outer loop it runs the inner one, which follows the setpoints of the node
`tracker`.
"""

import sys
from collections import Counter
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

from rclpy.duration import Duration
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from crane_sim.laws import inner_loop_of, outer_loop_of
from crane_sim.ros.common import messages, node_host
from crane_sim.ros.common.choices import RUN_MODES, RunMode
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.nodes import ServingNode
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.controller.law_node import LawNode, make_law
from crane_sim.ros.controller.responder import OutputTopic, serve_responder
from crane_sim.ros.controller.setpoints import Setpoints
from crane_sim.ros.controller.states import State
from crane_sim.ros.controller.trajectory_action import TrajectoryAction
from crane_sim.trajectories.replanning import to_piecewise_polynomial, trajectory_of_law

PARAMETERS = {
    "scene": Option("knuckle_setpoint", "scene: a name of the catalogue or a path"),
    "law": Option("", "control law; empty: the scene's own"),
    "mode": Option(
        RunMode.LOCKSTEP.value,
        "wait for an outer loop, or hold its last setpoint as in real time",
        choices=RUN_MODES,
    ),
    "expected_recorders": Option(0, "subscribers of the commands besides the plant", 0, 100),
    "stop_time": Option(
        2.0,
        "s in which the joints come to rest after a trajectory that was cancelled or left",
        1e-3,
        3600.0,
        live=True,
    ),
}
_COMMANDS = OutputTopic(JointState, "joint_commands", messages.DEEP_STREAM_QOS)


class ControllerNode(LawNode):
    """The law, or its inner loop, that answers every state with a command."""

    def __init__(self, node: ServingNode, settings: SimpleNamespace) -> None:
        """See `LawNode`."""
        super().__init__(
            node, settings, lambda settings: inner_loop_of(make_law(settings)), _COMMANDS
        )
        scene = self._scene
        self._goals = TrajectoryAction(node, scene, self._law, settings)
        # ns; the law whose path ends at the reference
        self._next_reference, self._referred = 0, self._law
        self._command = b""  # the newest, serialized
        self._command_codec = CommandCodec(scene)
        self._reference = self._reference_of_scene()
        self._references = node.create_publisher(
            JointTrajectory, "joint_trajectory", messages.STREAM_QOS
        )
        outer, lockstep = outer_loop_of(self._law), settings.mode == RunMode.LOCKSTEP
        self._setpoints = Setpoints(node, outer.names, lockstep, self._answer) if outer else None

    def set_active(self, active: bool) -> None:
        """See `LawNode`."""
        self._goals.set_active(active)
        super().set_active(active)

    def missing(self) -> str:
        """See `LawNode`."""
        return super().missing() or (self._setpoints.missing() if self._setpoints else "")

    def refused(self) -> Counter[str]:
        """See `LawNode`."""
        return (
            super().refused() + self._setpoints.refused() if self._setpoints else super().refused()
        )

    def on_spin(self) -> None:
        """See `LawNode`."""
        super().on_spin()
        self._goals.serve_cancellations()

    def finish(self) -> dict[str, Any]:
        """Wait until subscribers have every command; return the law's part of the summary.

        The summary is that of the run.
        """
        self._goals.finish()
        self._answers.wait_for_all_acked(Duration(seconds=messages.LIVELINESS_LEASE))
        demands = {"demands": self._setpoints.metrics()} if self._setpoints else {}
        return {"law_us": self._execution_time.metrics()} | demands

    def _diagnose(self) -> tuple[str, Mapping[str, object]]:
        setpoints, outer = self._setpoints, outer_loop_of(self._law)
        missing = (
            {"trajectory action": self._goals.missing_package}
            if self._goals.missing_package
            else {}
        )
        if setpoints and outer:
            return setpoints.warning(outer), missing | setpoints.metrics()
        return "", missing

    def _reset(self) -> None:
        self._next_reference, self._referred = 0, self._law
        self._reference = self._reference_of_scene()
        self._goals.reset()
        if self._setpoints:
            self._setpoints.reset()

    def _answer(self, state: State) -> None:
        if state != self._last_state and not self._evaluate(state):
            return
        self._answers.publish(self._command)  # first of all: the plant waits for it
        if self._reference is not None and state.stamp >= self._next_reference:
            self._next_reference = state.stamp + messages.NS_PER_S
            messages.set_stamp(self._reference.header.stamp, state.stamp)
            self._references.publish(self._reference)

    def _evaluate(self, state: State) -> bool:
        if self._setpoints:
            outer = outer_loop_of(self._law)
            if outer and not self._setpoints.apply_to(outer, state):
                return False
        self._law = self._goals.apply_to(self._law, state)
        effort = self._ask_law(state)
        self._goals.abort_replaced(self._law)
        if effort is None:
            return False
        self._command = self._command_codec.encode(state.stamp, effort)
        self._last_state = state
        self._update_reference()
        return True

    def _reference_of_scene(self) -> JointTrajectory | None:
        """Return the message of the scene's target, None where it has none."""
        target = self._scene.reference
        return messages.reference_message(self._scene.actuated, target) if target else None

    def _update_reference(self) -> None:
        """Let the reference be the end of the joints' path, if the law has a new one.

        The next message has it.
        """
        if self._law is self._referred:
            return
        self._referred, path = self._law, trajectory_of_law(self._law)
        if path is None or not path.of_joints:
            return
        end = to_piecewise_polynomial(path).coefficients[-1, :, 0]
        self._next_reference = 0
        self._reference = messages.reference_message(self._scene.actuated, end.tolist())
        self._trajectories.ignore(self._reference)


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Answer states until the request to finish."""
    serve_responder(host, ControllerNode(host.node, settings), settings.autostart)


def main() -> int:
    """Run the node; see `node_host.main` for the exit code."""
    return node_host.main("controller", PARAMETERS, serve, managed=True)


if __name__ == "__main__":
    sys.exit(main())
