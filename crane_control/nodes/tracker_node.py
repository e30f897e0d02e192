"""The node `tracker`: the slow half of a law, which answers the states of its instants with demands on the servo."""

import sys
from types import SimpleNamespace
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from crane_control.nodes.controller_node import chosen_scene, fresh_law
from crane_sim.laws import Law, LawError, SlowHalf, slow_half
from crane_sim.ros.common import messages, node_host
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.controller.path_input import TrajectoryInput
from crane_sim.ros.controller.responder import ActivationBuffer, serve_responder
from crane_sim.ros.controller.states import ExecutionTime, State, StateReader

PARAMETERS = {
    "scene": Option("offshore_two_rate", "scene: a name of the catalogue or a path"),
    "law": Option("", "control law; empty: the scene's own"),
    "expected_recorders": Option(0, "subscribers of the demands besides the controller", 0, 100),
}


class TrackerNode:
    """The whole law, asked only where its slow half is due, and only for what that demands.

    Attributes:
        fault: one line on why the law cannot go on, empty while it can.
    """

    def __init__(self, node: Node, settings: SimpleNamespace) -> None:
        """Build the law and try it once, so that its first demand is as quick as the others."""
        self._settings = settings
        self._scene = scene = chosen_scene(settings)
        self._law, half = halved_law(settings)
        halved_law(settings)[0](0.0, scene.initial_q, scene.initial_v)  # compiles, and leaves our law untouched
        self._seen: State | None = None
        self._answered = 0  # ns
        self._standby = ActivationBuffer(self._on_state)
        self.fault = ""
        self._reader, self._workload = StateReader(node, scene), ExecutionTime(node)
        self._demand = messages.demand_message(half.names)
        self._orders = TrajectoryInput(node, scene, self._law)
        self._demands = node.create_publisher(JointTrajectory, "tip_demand", messages.STREAM)
        self._states = node.create_subscription(
            JointState, "joint_states", self._standby.hear, messages.DEEP_STREAM, raw=True
        )

    def activate(self, active: bool) -> None:
        """Answer from now on, beginning with the newest state, or be silent."""
        self._standby.activate(active)

    def missing(self) -> str:
        """Return one line on the peers still missing, empty when all are there."""
        if not self._states.get_publisher_count():
            return f"a publisher of {self._states.topic_name}"
        number = 1 + self._settings.expected_recorders - self._demands.get_subscription_count()
        return f"{number} more subscriber(s) of {self._demands.topic_name}" if number > 0 else ""

    def heartbeat(self) -> None:
        """Publish diagnostics when they are due."""
        if self._workload.silent():
            self._workload.tell("", {})

    def finish(self) -> dict[str, Any]:
        """Return what the run's summary says of the slow half."""
        return {"tracker_us": self._workload.figures()}

    def _on_state(self, data: bytes) -> None:
        state = self._reader.read(data)
        if state is None:
            return
        if self._seen and state.stamp <= self._seen.stamp and state != self._seen:  # the plant began anew
            self._law, self._answered = halved_law(self._settings)[0], 0
        self._seen = state
        if state.stamp == self._answered or self._evaluate(state):
            self._demands.publish(self._demand)

    def _evaluate(self, state: State) -> bool:
        half = slow_half(self._law)
        if half is None or not half.due(state.t):
            return False
        self._law = self._orders.applied(self._law, state.t)
        try:
            self._workload.asked(self._law, state, len(self._scene.actuated))
        except LawError as error:
            self.fault = str(error)
            return False
        messages.set_demand(self._demand, state.stamp, half.demand)
        self._answered = state.stamp
        return True


def halved_law(settings: SimpleNamespace) -> tuple[Law, SlowHalf]:
    """Return a law that has seen no state yet, and its slow half; raises ValueError where it has none."""
    law = fresh_law(settings)
    half = slow_half(law)
    if half is None:
        raise ValueError(f"scene {settings.scene}: its law has no slow half: give it control.tracker_rate")
    return law, half


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Answer states with demands until told to finish."""
    serve_responder(host, TrackerNode(host.node, settings), settings.autostart)


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    return node_host.main("tracker", PARAMETERS, serve, managed=True)


if __name__ == "__main__":
    sys.exit(main())
