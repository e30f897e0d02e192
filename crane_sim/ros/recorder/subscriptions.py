"""The topics of a run as a recorder hears them: one subscription each, in the bytes that came over the wire.

An executor wakes up for every message. A recorder is in no hurry, and on a busy machine each of its wake-ups takes a
core from the plant or the controller: here messages wait in the middleware until somebody asks for them.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import itemgetter
from typing import Any, NamedTuple

from geometry_msgs.msg import PoseStamped
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.type_support import check_for_type_support
from sensor_msgs.msg import JointState
from std_msgs.msg import String, UInt8
from trajectory_msgs.msg import JointTrajectory

from crane_sim.recording.mcap.topic import Topic, has_stamp
from crane_sim.ros.common import messages

Callback = Callable[[bytes], None]

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
    "accepted_command": _Source(JointState, _STREAM),
    "joint_trajectory": _Source(JointTrajectory, _STREAM),
    "tip_demand": _Source(JointTrajectory, _STREAM),
    "payload_pose": _Source(PoseStamped, _SENSOR),
    "robot_description": _Source(String, _LATCHED),
    "simulation_state": _Source(UInt8, _LATCHED),
}
NAMES = tuple(_SOURCES)
_sent = itemgetter(0)


def topics(node: Node) -> dict[str, Topic]:
    """Return what a bag needs to know of every topic, by the name without the namespace."""
    return {name: _topic(node.resolve_topic_name(name), source) for name, source in _SOURCES.items()}


class RecorderSubscriptions:
    """Hands every message to all who take its topic, whenever it is asked to.

    Attributes:
        over: the plant said that the run has ended.
    """

    def __init__(self, node: Node, listeners: Sequence[Mapping[str, Callback]]) -> None:
        """Subscribe to the topics that a listener takes."""
        self._began, self.over = False, False
        everyone = ({"simulation_state": self._on_mode}, *listeners)
        self._ears: dict[str, PolledSubscription] = {}
        self._waiting: list[tuple[int, Callback, bytes]] = []
        self._newest = 0  # ns, when the last of them was sent
        for name in NAMES:
            takers = [listener[name] for listener in everyone if name in listener]
            if takers:
                self._ears[name] = PolledSubscription(node, name, _to_all(takers))

    def dispatch(self) -> None:
        """Hand over what had come by the last call, in the order in which it was sent.

        What has come since then stays: of what was sent before it, something may still be on its way on another topic.
        """
        self._waiting += [message for ear in self._ears.values() for message in ear.take_all()]
        self._waiting.sort(key=_sent)
        count = bisect_right(self._waiting, self._newest, key=_sent)
        settled, self._waiting = self._waiting[:count], self._waiting[count:]
        if self._waiting:
            self._newest = _sent(self._waiting[-1])
        for _, take, data in settled:
            take(data)

    def missing(self) -> str:
        """Return one line on the peer still missing, empty when the plant is there."""
        for name in ("joint_states", "applied_effort"):
            if not self._ears[name].has_publisher:
                return f"a publisher of {self._ears[name].topic}"
        return ""

    def _on_mode(self, data: bytes) -> None:
        mode = messages.mode(data)
        if mode is None:
            return
        self._began = self._began or mode == messages.PLAYING
        self.over = self._began and mode in (messages.STOPPED, messages.QUITTING)


class PolledSubscription:
    """A subscription that no executor serves.

    Attributes:
        topic: its name with the namespace.
    """

    def __init__(self, node: Node, name: str, take: Callback) -> None:
        """Subscribe to the topic of this name; `take` is what `take_all` names with its messages."""
        source = _SOURCES[name]
        self._take, self._kind, self._sent = take, source.kind, 0
        self._stamped = _topic(name, source).stamped
        check_for_type_support(source.kind)  # loads it, too
        with node.handle:  # what `create_subscription` wraps, and hands to the executor
            qos = source.qos.get_c_qos_profile()
            self._handle = rclpy_implementation.Subscription(node.handle, source.kind, name, qos)
        self.topic = self._handle.get_topic_name()

    @property
    def has_publisher(self) -> bool:
        """Whether somebody publishes it."""
        return self._handle.get_publisher_count() > 0

    def take_all(self) -> Iterator[tuple[int, Callback, bytes]]:
        """Yield (time at which it was sent [ns], who takes it, message) for every message that waits."""
        with self._handle:
            while taken := self._handle.take_message(self._kind, True):
                data, about = taken
                self._sent = max(self._sent, about["source_timestamp"])  # a clock set back reorders no topic
                if self._stamped and not has_stamp(data):
                    continue  # anybody may publish anything: what is no message is nothing to record
                yield self._sent, self._take, data


def _topic(name: str, source: _Source) -> Topic:
    package, _, _ = source.kind.__module__.partition(".")
    return Topic(
        name=name,
        kind=f"{package}/msg/{source.kind.__name__}",
        stamped="header" in source.kind.get_fields_and_field_types(),
        latched=source.qos.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        reliable=source.qos.reliability == ReliabilityPolicy.RELIABLE,
    )


def _to_all(takers: Sequence[Callback]) -> Callback:
    if len(takers) == 1:
        return takers[0]

    def pass_on(data: bytes) -> None:
        for take in takers:
            take(data)

    return pass_on
