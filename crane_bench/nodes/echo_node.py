"""The node `echo`, the lower bound of a lockstep step.

It exchanges the plant's two messages without any simulation.

Messages are serialized by `JointStateCodec`, as plant and controller do.
"""

import sys
import time
from types import SimpleNamespace
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import JointState

from crane_sim import load_scene
from crane_sim.ros.common import messages, node_host
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec

PARAMETERS = {
    "scene": Option(
        "knuckle_setpoint",
        "scene that gives joint names and period: a name of the catalogue or a path",
    ),
    "role": Option(
        "ping", "ping sends states, pong answers with commands", choices=("ping", "pong")
    ),
    "steps": Option(1000, "exchanges", 1, 1_000_000_000),
}


class Ping:
    """Publisher of state k + 1 as soon as the answer to state k has come."""

    def __init__(self, node: Node, settings: SimpleNamespace) -> None:
        """Use the names, message types, depths and period of the plant."""
        scene = load_scene(settings.scene)
        self._period, self._steps, self._k = scene.period_ns, settings.steps, 0
        self._q, self._v, self._applied = (
            scene.initial_q,
            scene.initial_v,
            (0.0,) * len(scene.joint_names),
        )
        self._encoder = JointStateCodec(scene.joint_names, STATE)
        self._decoder = JointStateCodec(scene.actuated, EFFORT)
        callback: Any = self._on_command  # of serialized messages
        self._states = node.create_publisher(JointState, "joint_states", messages.DEEP_STREAM_QOS)
        self._commands = node.create_subscription(
            JointState, "joint_commands", callback, messages.STREAM_QOS, raw=True
        )

    def missing(self) -> str:
        """Return one line on the peer still missing, empty when it is there."""
        matched = self._states.get_subscription_count() and self._commands.get_publisher_count()
        return "" if matched else "pong"

    def run(self, host: NodeHost) -> dict[str, float]:
        """Exchange all messages; return the rate."""
        host.wait(lambda: "" if host.started else "the request go")
        start = time.monotonic()
        self._send()
        host.wait(lambda: "" if self._k > self._steps else "the answers")
        return {"steps_per_second": self._steps / (time.monotonic() - start)}

    def _send(self) -> None:
        self._k += 1
        self._states.publish(
            self._encoder.encode(self._k * self._period, self._q, self._v, self._applied)
        )

    def _on_command(self, data: bytes) -> None:
        if self._decoder.decode(data).stamp == self._k * self._period:
            self._send()


class Pong:
    """Publisher of a command of the same stamp for every state."""

    def __init__(self, node: Node, settings: SimpleNamespace) -> None:
        """Use the names, message types and depths of the controller."""
        scene = load_scene(settings.scene)
        self._effort = (0.0,) * len(scene.actuated)
        self._encoder = JointStateCodec(scene.actuated, EFFORT)
        self._decoder = JointStateCodec(scene.joint_names, STATE)
        callback: Any = self._on_state  # of serialized messages
        self._commands = node.create_publisher(
            JointState, "joint_commands", messages.DEEP_STREAM_QOS
        )
        self._states = node.create_subscription(
            JointState, "joint_states", callback, messages.DEEP_STREAM_QOS, raw=True
        )

    def missing(self) -> str:
        """Return one line on the peer still missing, empty when it is there."""
        matched = self._commands.get_subscription_count() and self._states.get_publisher_count()
        return "" if matched else "ping"

    def run(self, host: NodeHost) -> dict[str, float]:
        """Answer until the request to finish."""
        while not host.stop_reason:
            host.spin()
        return {}

    def _on_state(self, data: bytes) -> None:
        self._commands.publish(self._encoder.encode(self._decoder.decode(data).stamp, self._effort))


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Run the role of the parameters."""
    role = Ping(host.node, settings) if settings.role == "ping" else Pong(host.node, settings)
    host.wait(role.missing)
    host.report_ready()
    host.pipes.report("done", summary=role.run(host))
    host.wait(lambda: "" if not host.pipes.attached else "the request finish")


def main() -> int:
    """Run the node; see `node_host.main` for the exit code."""
    return node_host.main("echo", PARAMETERS, serve)


if __name__ == "__main__":
    sys.exit(main())
