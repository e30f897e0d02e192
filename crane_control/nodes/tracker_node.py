"""The node `tracker`: the outer loop of a law, which publishes setpoints of the tip servo.

They are for the states at its sampling instants.
"""

import sys
from types import SimpleNamespace
from typing import Any

from trajectory_msgs.msg import JointTrajectory

from crane_sim.laws import Law, outer_loop_of
from crane_sim.ros.common import messages, node_host
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.nodes import ServingNode
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.controller.law_node import LawNode, make_law
from crane_sim.ros.controller.responder import OutputTopic, serve_responder
from crane_sim.ros.controller.states import State

PARAMETERS = {
    "scene": Option("offshore_two_rate", "scene: a name of the catalogue or a path"),
    "law": Option("", "control law; empty: the scene's own"),
    "expected_recorders": Option(0, "subscribers of the setpoints besides the controller", 0, 100),
}
_SETPOINTS = OutputTopic(JointTrajectory, "tip_demand", messages.STREAM_QOS)


class TrackerNode(LawNode):
    """The whole law, evaluated only where its outer loop is due, and only for its setpoints."""

    def __init__(self, node: ServingNode, settings: SimpleNamespace) -> None:
        """See `LawNode`."""
        super().__init__(node, settings, make_two_rate_law, _SETPOINTS)
        self._answered = 0  # ns, stamp of the newest setpoint
        outer = outer_loop_of(self._law)
        self._setpoint = messages.setpoint_message(outer.names if outer else ())

    def finish(self) -> dict[str, Any]:
        """Return the outer loop's entries of the run's summary."""
        return {"tracker_us": self._execution_time.metrics()}

    def _reset(self) -> None:
        self._answered = 0

    def _answer(self, state: State) -> None:
        self._last_state = state
        if state.stamp == self._answered or self._evaluate(state):
            self._answers.publish(self._setpoint)

    def _evaluate(self, state: State) -> bool:
        outer = outer_loop_of(self._law)
        if outer is None or not outer.due(state.t) or self._ask_law(state) is None:
            return False
        messages.set_setpoint(self._setpoint, state.stamp, outer.demand)
        self._answered = state.stamp
        return True


def make_two_rate_law(settings: SimpleNamespace) -> Law:
    """Return the law of the parameters; raises ValueError where it has no outer loop.

    It is the law before its first state.
    """
    law = make_law(settings)
    if outer_loop_of(law) is None:
        raise ValueError(
            f"scene {settings.scene}: its law has no outer loop: give it control.tracker_rate"
        )
    return law


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Answer states with setpoints until the request to finish."""
    serve_responder(host, TrackerNode(host.node, settings), settings.autostart)


def main() -> int:
    """Run the node; see `node_host.main` for the exit code."""
    return node_host.main("tracker", PARAMETERS, serve, managed=True)


if __name__ == "__main__":
    sys.exit(main())
