"""The topics of a run as a recorder hears them: one subscription each, in the bytes that came over the wire."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import String, UInt8
from trajectory_msgs.msg import JointTrajectory

from crane_sim.recording.topic import Topic
from crane_sim.ros import messages

Taker = Callable[[bytes], None]

_DEPTH = 10_000  # more steps than a plant makes while a block is written
_STREAM = QoSProfile(depth=_DEPTH)
_SENSOR = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
_LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class _Source(NamedTuple):
    kind: Any  # message class
    qos: QoSProfile


_SOURCES = {
    "joint_states": _Source(JointState, _STREAM),
    "applied_effort": _Source(JointState, _STREAM),
    "joint_commands": _Source(JointState, _STREAM),
    "joint_trajectory": _Source(JointTrajectory, _STREAM),
    "payload_pose": _Source(PoseStamped, _SENSOR),
    "robot_description": _Source(String, _LATCHED),
    "simulation_state": _Source(UInt8, _LATCHED),
}


def topics(node: Node) -> dict[str, Topic]:
    """Return what a bag needs to know of every topic, by the name without the namespace."""
    return {name: _topic(node.resolve_topic_name(name), source) for name, source in _SOURCES.items()}


class Hearing:
    """Hands every message to all who take its topic.

    Attributes:
        over: the plant said that the run has ended.
    """

    def __init__(self, node: Node, listeners: Sequence[Mapping[str, Taker]]) -> None:
        """Subscribe to the topics that a listener takes."""
        self._began, self.over = False, False
        everyone = ({"simulation_state": self._on_mode}, *listeners)
        self._subscriptions = {}
        for name, (kind, qos) in _SOURCES.items():
            takers = [listener[name] for listener in everyone if name in listener]
            if takers:
                self._subscriptions[name] = node.create_subscription(kind, name, _to_all(takers), qos, raw=True)

    def missing(self) -> str:
        """Return one line on the peer still missing, empty when the plant is there."""
        for name in ("joint_states", "applied_effort"):
            if not self._subscriptions[name].get_publisher_count():
                return f"a publisher of {self._subscriptions[name].topic_name}"
        return ""

    def _on_mode(self, data: bytes) -> None:
        mode = deserialize_message(data, UInt8).data
        self._began = self._began or mode == messages.PLAYING
        self.over = self._began and mode in (messages.STOPPED, messages.QUITTING)


def _topic(name: str, source: _Source) -> Topic:
    package, _, _ = source.kind.__module__.partition(".")
    return Topic(
        name=name,
        kind=f"{package}/msg/{source.kind.__name__}",
        stamped="header" in source.kind.get_fields_and_field_types(),
        latched=source.qos.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        reliable=source.qos.reliability == ReliabilityPolicy.RELIABLE,
    )


def _to_all(takers: Sequence[Taker]) -> Taker:
    if len(takers) == 1:
        return takers[0]

    def pass_on(data: bytes) -> None:
        for take in takers:
            take(data)

    return pass_on
