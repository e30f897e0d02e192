"""Nodes that answer states with commands or setpoints: from matching with peers to the summary."""

import time
from collections import Counter
from typing import Any, NamedTuple

from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from crane_sim.ros.common import messages
from crane_sim.ros.common.node_host import Fault, NodeHost
from crane_sim.ros.common.nodes import ServingNode
from crane_sim.ros.common.refused_messages import refused_entry
from crane_sim.ros.common.served_subscription import SourceSubscription
from crane_sim.ros.controller.states import State, StateReader
from crane_sim.scenes.scene import Scene

_CHECK_PERIOD = 0.02  # s between two turns of what need not be done after every message


class OutputTopic(NamedTuple):
    """The topic on which a node publishes its answers: commands or setpoints."""

    kind: Any  # message class
    name: str
    qos: QoSProfile


class Responder:
    """A node that, while active, answers a plant's states with commands or setpoints.

    Attributes:
        fault: one line on why it cannot go on, empty while it can.
    """

    def __init__(
        self, node: ServingNode, scene: Scene, output: OutputTopic, expected_recorders: int
    ) -> None:
        """Subscribe to the states of the scene's joints, still inactive."""
        self.fault, self._scene, self._expected_recorders = "", scene, expected_recorders
        self._active, self._newest = False, b""  # serialized, of those that came while inactive
        self._reader = StateReader(node, scene)
        self._answers = node.create_publisher(*output)
        self._states = SourceSubscription(
            node, JointState, "joint_states", self._receive, messages.DEEP_STREAM_QOS
        )

    def set_active(self, active: bool) -> None:
        """Answer states from now on, beginning with the newest one, or publish nothing."""
        self._active, newest = active, self._newest
        self._newest = b""
        if active and newest:
            self._receive(newest)

    def missing(self) -> str:
        """Return one line on a peer still missing, empty when all are matched."""
        if missing := self._states.missing():
            return missing
        number = 1 + self._expected_recorders - self._answers.get_subscription_count()
        return f"{number} more subscriber(s) of {self._answers.topic_name}" if number > 0 else ""

    def refused(self) -> Counter[str]:
        """Return the numbers of messages refused, by topic and node."""
        return self._states.filter.refused

    def on_spin(self) -> None:
        """Do the periodic work, every 20 ms."""

    def finish(self) -> dict[str, Any]:
        """Return the node's entries of the run's summary."""
        return {}

    def _receive(self, data: bytes) -> None:
        if not self._active:
            self._newest = data
        elif (state := self._reader.read(data)) is not None:
            self._on_state(state)

    def _on_state(self, state: State) -> None:
        """Answer a state."""
        raise NotImplementedError


def serve_responder(host: NodeHost, node: Responder, autostart: bool) -> None:
    """Serve a node until the request to finish; raises Fault when it cannot go on.

    Without `autostart` it is a standby: matched and ready, but it publishes nothing until it is
    activated.
    """

    def set_active(active: bool) -> None:
        host.pipes.report("active", active=active)
        node.set_active(active)

    host.manage(autostart, set_active)
    host.wait(node.missing)
    host.report_ready()
    next_check = 0.0
    while not host.stop_reason:
        host.spin()
        if node.fault:
            raise Fault(node.fault)
        if (now := time.monotonic()) >= next_check:
            next_check = now + _CHECK_PERIOD
            node.on_spin()
            host.notify_refused(node.refused())
    host.pipes.report("done", summary=node.finish() | refused_entry(node.refused()))
