"""The node `controller`: answers every joint state with the command of its law, stamped like the state.

Of a law with a slow half it is the fast one, which carries out what the node `tracker` demands.
"""

import sys
from types import SimpleNamespace
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from crane_sim import load_scene
from crane_sim.laws import Law, LawError, fast_half, slow_half
from crane_sim.ros.common import messages, node_host
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.controller.path_input import TrajectoryInput
from crane_sim.ros.controller.responder import ActivationBuffer, serve_responder
from crane_sim.ros.controller.setpoints import Setpoints
from crane_sim.ros.controller.states import ExecutionTime, State, StateReader
from crane_sim.scenes.scene import Scene

PARAMETERS = {
    "scene": Option("knuckle_setpoint", "scene: a name of the catalogue or a path"),
    "law": Option("", "control law; empty: the scene's own"),
    "mode": Option(
        "lockstep", "wait for a slow half, or hold its last demand as in real time", choices=("lockstep", "realtime")
    ),
    "expected_recorders": Option(0, "subscribers of the commands besides the plant", 0, 100),
}


class ControllerNode:
    """One law between two topics; a state that comes twice gets the same answer, from memory.

    Attributes:
        fault: one line on why the law cannot go on, empty while it can.
    """

    def __init__(self, node: Node, settings: SimpleNamespace) -> None:
        """Build the law and try it once, so that its first answer is as quick as the others."""
        self._settings = settings
        self._scene = scene = chosen_scene(settings)
        self._law = fast_half(fresh_law(settings))
        fast_half(fresh_law(settings))(0.0, scene.initial_q, scene.initial_v)  # compiles, our law stays untouched
        self._answered: State | None = None
        self._next_reference = 0  # ns
        self._standby = ActivationBuffer(self._on_state)
        self.fault = ""
        self._command = b""
        self._reader, self._workload = StateReader(node, scene), ExecutionTime(node)
        self._command_wire = JointWire(scene.actuated, effort=True)
        self._reference = messages.reference_message(scene.actuated, scene.reference or ())
        self._orders = TrajectoryInput(node, scene, self._law)
        self._commands = node.create_publisher(JointState, "joint_commands", messages.DEEP_STREAM)
        self._references = node.create_publisher(JointTrajectory, "joint_trajectory", messages.STREAM)
        self._demands = self._heard(node)
        self._states = node.create_subscription(
            JointState, "joint_states", self._standby.hear, messages.DEEP_STREAM, raw=True
        )

    def activate(self, active: bool) -> None:
        """Answer from now on, beginning with the newest state, or be silent."""
        self._standby.activate(active)

    def missing(self) -> str:
        """Return one line on the peers still missing, empty when all are there, the plant both ways."""
        if not self._states.get_publisher_count():
            return f"a publisher of {self._states.topic_name}"
        number = 1 + self._settings.expected_recorders - self._commands.get_subscription_count()
        if number > 0:
            return f"{number} more subscriber(s) of {self._commands.topic_name}"
        return self._demands.missing() if self._demands else ""

    def heartbeat(self) -> None:
        """Publish diagnostics when they are due."""
        if self._workload.silent():
            warning = self._demands.warning(self._law.slow_half) if self._demands else ""
            self._workload.tell(warning, self._demands.figures() if self._demands else {})

    def finish(self) -> dict[str, Any]:
        """Wait until everyone has every command; return what the run's summary says of the law."""
        self._commands.wait_for_all_acked(Duration(seconds=messages.LEASE))
        demands = {"demands": self._demands.figures()} if self._demands else {}
        return {"law_us": self._workload.figures()} | demands

    def _heard(self, node: Node) -> Setpoints | None:
        half = slow_half(self._law)
        return Setpoints(node, half.names, self._settings.mode == "lockstep", self._answer) if half else None

    def _on_state(self, data: bytes) -> None:
        state = self._reader.read(data)
        if state is None:
            return
        if self._answered and state.stamp <= self._answered.stamp and state != self._answered:  # the plant began anew
            self._law, self._answered, self._next_reference = fast_half(fresh_law(self._settings)), None, 0
            if self._demands:
                self._demands.forget()
        self._answer(state)

    def _answer(self, state: State) -> None:
        if state != self._answered and not self._evaluate(state):
            return
        self._commands.publish(self._command)  # first of all: the plant waits for it
        if state.stamp >= self._next_reference and self._scene.reference:
            self._next_reference = state.stamp + messages.SECOND
            messages.set_stamp(self._reference.header.stamp, state.stamp)
            self._references.publish(self._reference)

    def _evaluate(self, state: State) -> bool:
        if self._demands and not self._demands.given_to(self._law.slow_half, state):
            return False
        self._law = self._orders.applied(self._law, state.t)
        try:
            effort = self._workload.asked(self._law, state, len(self._scene.actuated))
        except LawError as error:
            self.fault = str(error)
            return False
        self._command = self._command_wire.encode(state.stamp, effort)
        self._answered = state
        return True


def chosen_scene(settings: SimpleNamespace) -> Scene:
    """Return the scene of the parameters, with the law of the parameters."""
    return load_scene(settings.scene, {"control.law": settings.law} if settings.law else None)


def fresh_law(settings: SimpleNamespace) -> Law:
    """Return a law that has seen no state yet; raises ValueError where the scene has none."""
    law = chosen_scene(settings).law
    if law is None:
        raise ValueError(f"scene {settings.scene} has no control law: give it a group control")
    return law


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Answer states until told to finish."""
    serve_responder(host, ControllerNode(host.node, settings), settings.autostart)


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    return node_host.main("controller", PARAMETERS, serve, managed=True)


if __name__ == "__main__":
    sys.exit(main())
