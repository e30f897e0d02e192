"""Polled subscriptions of a recorder: one for each topic of a run, with serialized messages.

An executor wakes up for every message. A recorder is in no hurry, and on a busy machine each of its
wake-ups takes a core from the plant or the controller: here messages wait in the middleware until
they are polled.
"""

import time
from bisect import bisect_right
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import String, UInt8
from trajectory_msgs.msg import JointTrajectory

from crane_sim.recording.mcap.topic import Topic, has_stamp
from crane_sim.ros.common import messages
from crane_sim.ros.common.messages import SimulationState, TFMessage
from crane_sim.ros.common.sender_subscription import MessageWithSender, SenderSubscription
from crane_sim.ros.common.source_filter import PLANT, SourceFilter

Callback = Callable[[bytes], None]

_DEPTH = 10_000  # more steps than a plant takes while a block is written
_STREAM = QoSProfile(depth=_DEPTH)
_SENSOR = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
_LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class _Source(NamedTuple):
    kind: Any  # message class
    qos: QoSProfile
    publisher: str = PLANT  # name of the node whose messages are taken; empty: those of all nodes
    # are
    shared: bool = False  # other nodes' are taken as well, unless they have the publisher's name in
    # them


class _Message(NamedTuple):
    sent: int  # ns of the publisher's clock
    callback: Callback  # of its topic
    data: bytes


_SOURCES = {
    "joint_commands": _Source(JointState, _STREAM, ""),
    "accepted_command": _Source(JointState, _STREAM),
    "held_command": _Source(JointState, _STREAM),
    "joint_trajectory": _Source(JointTrajectory, _STREAM, ""),
    "tip_demand": _Source(JointTrajectory, _STREAM, "tracker"),
    "payload_pose": _Source(PoseStamped, _SENSOR),
    "base/odometry": _Source(Odometry, _STREAM),
    "base/imu": _Source(Imu, _STREAM),
    "camera/payload_pose": _Source(PoseStamped, _STREAM),
    "robot_description": _Source(String, _LATCHED),
    "simulation_state": _Source(UInt8, _LATCHED),
    "/clock": _Source(Clock, _SENSOR, ""),
    "/diagnostics": _Source(DiagnosticArray, _STREAM, shared=True),
}
if TFMessage is not None:
    _SOURCES |= {
        "/tf": _Source(TFMessage, _STREAM, ""),
        "/tf_static": _Source(TFMessage, _LATCHED, ""),
    }
# last: a plant that has discovered these, for which it waits, has discovered all before them
_SOURCES |= {
    "joint_states": _Source(JointState, _STREAM),
    "true_states": _Source(JointState, _STREAM),
    "applied_effort": _Source(JointState, _STREAM),
}
NAMES = tuple(_SOURCES)
"""Topics of a crane, which a bag keeps."""
_time_sent = attrgetter("sent")


def topics(node: Node) -> dict[str, Topic]:
    """Return the description of every topic for a bag, by the name without the namespace."""
    return {
        name: _topic(node.resolve_topic_name(name), source) for name, source in _SOURCES.items()
    }


class RecorderSubscriptions:
    """The subscriptions of a recorder; messages are dispatched to all callbacks of their topics.

    Attributes:
        over: the plant has published the end of the run.
    """

    def __init__(self, node: Node, receivers: Sequence[Mapping[str, Callback]]) -> None:
        """Subscribe to the topics of the receivers, which are callbacks by topic."""
        self._started, self.over = False, False
        receivers = ({"simulation_state": self._on_simulation_state}, *receivers)
        self._subscriptions: dict[str, PolledSubscription] = {}
        self._pending: list[_Message] = []
        self._newest = 0  # ns, when the last of them was sent
        for name in NAMES:
            callbacks = [receiver[name] for receiver in receivers if name in receiver]
            if callbacks:
                self._subscriptions[name] = PolledSubscription(node, name, _fan_out(callbacks))

    def dispatch(self) -> None:
        """Dispatch the messages that had come by the last call, in the order of sending.

        Later ones stay pending: a message that was sent before them may still be on its way on
        another topic.
        """
        self._pending += [
            message for each in self._subscriptions.values() for message in each.take_all()
        ]
        self._pending.sort(key=_time_sent)
        count = bisect_right(self._pending, self._newest, key=_time_sent)
        complete, self._pending = self._pending[:count], self._pending[count:]
        if self._pending:
            self._newest = self._pending[-1].sent
        for message in complete:
            message.callback(message.data)

    def missing(self, sensed: bool) -> str:
        """Return a line on the missing peer, empty where the plant is there, sensed or not."""
        needed = ("joint_states", "applied_effort", *(["true_states"] if sensed else []))
        return next(filter(None, (self._subscriptions[name].missing() for name in needed)), "")

    def refused(self) -> Counter[str]:
        """Return the numbers of messages refused: of other nodes, or that do not fit."""
        return sum((each.refused() for each in self._subscriptions.values()), Counter[str]())

    def _on_simulation_state(self, data: bytes) -> None:
        state = messages.decode_simulation_state(data)
        if state is None:
            return
        self._started = self._started or state == SimulationState.PLAYING
        self.over = self._started and state in (SimulationState.STOPPED, SimulationState.QUITTING)


class PolledSubscription:
    """A subscription that no executor serves.

    Of topics that one node publishes only its messages are taken.

    Attributes:
        topic: its name with the namespace.
    """

    def __init__(self, node: Node, name: str, callback: Callback) -> None:
        """Subscribe to the topic of this name; `take_all` yields the callback with each message."""
        source = _SOURCES[name]
        self._callback, self._sent = callback, 0
        self._stamped = _topic(name, source).stamped
        self._subscription = SenderSubscription(node, source.kind, name, source.qos)
        self.topic = self._subscription.topic
        standbys = source.publisher != PLANT  # the other nodes may be replaced in the run
        self._filter = (
            SourceFilter(node, self.topic, source.publisher, standbys) if source.publisher else None
        )
        own = (
            self._filter.source.strip("/").encode() + b"\0"
            if self._filter and source.shared
            else b""
        )
        self._claim = len(own).to_bytes(4, "little") + own if own else b""  # a string of CDR, whole
        # received before their nodes' names
        self._unknown = deque[tuple[float, MessageWithSender]](maxlen=_DEPTH)
        self._misfits = Counter[str]()

    def missing(self) -> str:
        """Return a line where the publisher is missing or not known by its name yet; else empty."""
        there = self._subscription.count_publishers() and (
            self._filter is None or self._filter.has_source
        )
        return "" if there else f"a publisher of {self.topic}"

    def refused(self) -> Counter[str]:
        """Return the number of messages refused, by topic and node."""
        return (self._filter.refused if self._filter else Counter[str]()) + self._misfits

    def take_all(self) -> Iterator[_Message]:
        """Take and yield all messages."""
        now, waiting = time.monotonic(), len(self._unknown)
        for _ in range(waiting):
            received, message = self._unknown.popleft()
            yield from self._pass(message, received, now)
        while message := self._subscription.take():
            yield from self._pass(message, now, now)

    def _accepts(self, message: MessageWithSender) -> bool | None:
        """See `SourceFilter.accepts`."""
        if self._filter is None or (self._claim and self._claim not in message.data):
            return True
        return self._filter.accepts(message.sender)

    def _pass(self, message: MessageWithSender, received: float, now: float) -> Iterator[_Message]:
        """Yield a message that counts; keep one whose publisher has no name yet.

        It is kept until the name must have come.
        """
        accepted = self._accepts(message)
        if accepted is None and now - received < messages.LIVELINESS_LEASE:
            self._unknown.append((received, message))
        elif accepted is None and self._filter:
            self._filter.refuse(message.sender)
        elif accepted and self._stamped and not has_stamp(message.data):
            self._misfits[f"{self.topic}, malformed"] += 1  # a topic may carry anything
        elif accepted:
            self._sent = max(self._sent, message.sent)  # a clock set back reorders no topic
            yield _Message(self._sent, self._callback, message.data)


def _topic(name: str, source: _Source) -> Topic:
    package, _, _ = source.kind.__module__.partition(".")
    shared = name.startswith("/") and name in _SOURCES  # names of the others may be resolved, too
    return Topic(
        name=name,
        kind=f"{package}/msg/{source.kind.__name__}",
        stamped=source.kind is Clock
        or (not shared and "header" in source.kind.get_fields_and_field_types()),
        latched=source.qos.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        reliable=source.qos.reliability == ReliabilityPolicy.RELIABLE,
        shared=shared,
    )


def _fan_out(callbacks: Sequence[Callback]) -> Callback:
    if len(callbacks) == 1:
        return callbacks[0]

    def call_all(data: bytes) -> None:
        for callback in callbacks:
            callback(data)

    return call_all
