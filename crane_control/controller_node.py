"""The node `controller`: answers every joint state with the command of its law, stamped like the state."""

import sys
from types import SimpleNamespace

from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from crane_sim import load_scene
from crane_sim.laws import Law, LawError, asked
from crane_sim.ros import messages, process
from crane_sim.ros.path_orders import PathOrders
from crane_sim.ros.process import Fault, Host
from crane_sim.ros.wire import Frame, JointWire
from crane_sim.scene import Scene

PARAMETERS = {
    "scene": "knuckle_setpoint",  # catalogue name or path
    "law": "",  # empty: the scene's own
    "expected_recorders": 0,  # subscribers of the commands besides the plant
}


class ControllerNode:
    """One law between two topics; a state that comes twice gets the same answer, from memory.

    Attributes:
        fault: one line on why the law cannot go on, empty while it can.
    """

    def __init__(self, node: Node, settings: SimpleNamespace) -> None:
        """Build the law and try it once, so that its first answer is as quick as the others."""
        self._node, self._settings = node, settings
        self._scene = scene = chosen_scene(settings)
        self._law = fresh_law(settings)
        fresh_law(settings)(0.0, scene.initial_q, scene.initial_v)  # compiles, and leaves our law untouched
        self._names = list(scene.joint_names)
        self._answered = self._next_reference = 0  # ns
        self.fault = ""
        self._command = b""
        self._state_wire = JointWire(scene.joint_names, effort=False)
        self._command_wire = JointWire(scene.actuated, effort=True)
        self._reference = messages.reference_message(scene.actuated, scene.reference or ())
        self._orders = PathOrders(node, scene, self._law, self._reference)
        self._commands = node.create_publisher(JointState, "joint_commands", messages.DEEP_STREAM)
        self._references = node.create_publisher(JointTrajectory, "joint_trajectory", messages.STREAM)
        self._states = node.create_subscription(
            JointState, "joint_states", self._on_state, messages.DEEP_STREAM, raw=True
        )

    def missing(self) -> str:
        """Return one line on the peers still missing, empty when all are there, the plant both ways."""
        if not self._states.get_publisher_count():
            return f"a publisher of {self._states.topic_name}"
        number = 1 + self._settings.expected_recorders - self._commands.get_subscription_count()
        return f"{number} more subscriber(s) of {self._commands.topic_name}" if number > 0 else ""

    def _on_state(self, data: bytes) -> None:
        state = self._state_wire.decode(data)
        if state.stamp != self._answered and not self._evaluate(state):
            return
        self._commands.publish(self._command)  # first of all: the plant waits for it
        if state.stamp >= self._next_reference and self._scene.reference:
            self._next_reference = state.stamp + messages.SECOND
            messages.set_stamp(self._reference.header.stamp, state.stamp)
            self._references.publish(self._reference)

    def _evaluate(self, state: Frame) -> bool:
        if state.stamp < self._answered:  # the plant began anew
            self._law, self._next_reference = fresh_law(self._settings), 0
        vectors = (state.position, state.velocity) if state.names == self._names else self._sorted(state)
        if vectors is None:
            return False
        time = (state.stamp / self._scene.period_ns - 1.0) * self._scene.period  # s, exactly the plant's own time
        self._law = self._orders.applied(self._law, time)
        try:
            effort = asked(self._law, time, *vectors, len(self._scene.actuated))
        except LawError as error:
            self.fault = str(error)
            return False
        self._command = self._command_wire.encode(state.stamp, effort)
        self._answered = state.stamp
        return True

    def _sorted(self, state: Frame) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        """Return position and velocity in the scene's order of joints, or None where joints are missing."""
        same = sorted(state.names) == sorted(self._names)
        if not same or not len(state.position) == len(state.velocity) == len(self._names):
            line = f"joint state of {state.names}, expected position and velocity of {self._names}: ignored"
            self._node.get_logger().warning(line, throttle_duration_sec=1.0)
            return None
        order = [state.names.index(name) for name in self._names]
        return tuple(state.position[i] for i in order), tuple(state.velocity[i] for i in order)


def chosen_scene(settings: SimpleNamespace) -> Scene:
    """Return the scene of the parameters, with the law of the parameters."""
    return load_scene(settings.scene, {"control.law": settings.law} if settings.law else None)


def fresh_law(settings: SimpleNamespace) -> Law:
    """Return a law that has seen no state yet; raises ValueError where the scene has none."""
    law = chosen_scene(settings).law
    if law is None:
        raise ValueError(f"scene {settings.scene} has no control law: give it a group control")
    return law


def serve(host: Host, settings: SimpleNamespace) -> None:
    """Answer states until told to finish; raises Fault when the law fails."""
    controller = ControllerNode(host.node, settings)
    host.wait(controller.missing)
    host.pipes.report("ready")
    while not host.stopping:
        host.spin()
        if controller.fault:
            raise Fault(controller.fault)
    host.pipes.report("done", summary={})


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    return process.main("controller", PARAMETERS, serve)


if __name__ == "__main__":
    sys.exit(main())
