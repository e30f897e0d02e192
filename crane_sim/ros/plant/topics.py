"""The plant's publishers, with messages and serializers that are built once."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String, UInt8

from crane_sim.ros.common import messages
from crane_sim.ros.common.sender_subscription import full_name, publishers
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec
from crane_sim.ros.common.timing import DurationHistogram
from crane_sim.ros.plant.state_publisher import set_quaternion, set_vector

_SLICE = Duration(nanoseconds=20_000_000)  # of a wait, in which signals are not handled


class PlantTopics:
    """The publishers of the node `plant`; stamps are integer ns, vectors in joint order.

    Attributes:
        publishing: durations of the calls that hand joint states to the middleware.
        clock_subscribed, effort_subscribed, payload_subscribed, truth_subscribed: the topic had
        subscribers at the last
            update.
    """

    def __init__(
        self,
        node: Node,
        joints: Sequence[str],
        actuated: Sequence[str],
        clock: bool = True,
        sensed: bool = False,
        notify: Callable[[str], object] = lambda line: None,
    ) -> None:
        """Create all publishers of `plant`; /clock only with `clock`, true states with `sensed`.

        `notify` is called with a line on a subscriber of the states that is not matched.
        """
        events = PublisherEventCallbacks(incompatible_qos=partial(self._on_incompatible, notify))
        create, stream = node.create_publisher, messages.DEEP_STREAM_QOS
        self._states = create(JointState, "joint_states", stream, event_callbacks=events)
        self._truth = create(JointState, "true_states", stream) if sensed else None
        self._efforts = create(JointState, "applied_effort", stream)
        self._clock = create(Clock, "/clock", messages.CLOCK_QOS) if clock else None
        self._pose = create(PoseStamped, "payload_pose", messages.SENSOR_QOS)
        self._description = create(String, "robot_description", messages.LATCHED_QOS)
        self._simulation_state = create(UInt8, "simulation_state", messages.LATCHED_QOS)
        self._diagnostics = create(DiagnosticArray, "/diagnostics", messages.STREAM_QOS)
        self._node, self._source = node, f"{node.get_namespace().strip('/')}/plant"
        self._state_codec = JointStateCodec(joints, STATE)
        self._applied_indices = [
            actuated.index(joint) if joint in actuated else -1 for joint in joints
        ]
        self._effort_codec = JointStateCodec(actuated, EFFORT)
        self._clock_message, self._payload = Clock(), PoseStamped()
        self._payload.header.frame_id = "world"
        self.clock_subscribed = self.effort_subscribed = self.payload_subscribed = (
            self.truth_subscribed
        ) = False
        self._state_subscribers = 0
        self.publishing = DurationHistogram()

    def _on_incompatible(self, notify: Callable[[str], object], event: Any) -> None:
        why = messages.describe_policy(event.last_policy_kind)
        notify(f"a subscriber of {self._states.topic_name} is not matched: {why}")

    def publish_state(
        self, stamp: int, q: Sequence[float], v: Sequence[float], applied: tuple[float, ...]
    ) -> None:
        """Publish the joint state; first of all in a step, since the controller waits for it.

        Its efforts are those `applied` (nu,) at the start of the period before it, and zero of
        other joints.
        """
        message = self._encode_state(stamp, q, v, applied)
        start = time.perf_counter()
        self._states.publish(message)
        self.publishing.add(time.perf_counter() - start)

    def publish_true_state(
        self, stamp: int, q: Sequence[float], v: Sequence[float], applied: tuple[float, ...]
    ) -> None:
        """Publish a crane's true state, with the joint state's efforts, if it has sensors."""
        if self._truth and self.truth_subscribed:
            self._truth.publish(self._encode_state(stamp, q, v, applied))

    def publish_effort(self, stamp: int, effort: Sequence[float]) -> None:
        """Publish the effort applied from `stamp` on, after limits and faults."""
        self._efforts.publish(self._effort_codec.encode(stamp, effort))

    def _encode_state(
        self, stamp: int, q: Sequence[float], v: Sequence[float], applied: tuple[float, ...]
    ) -> bytes:
        padded = (*applied, 0.0)
        return self._state_codec.encode(stamp, q, v, [padded[i] for i in self._applied_indices])

    def publish_clock(self, stamp: int) -> None:
        """Publish the simulation's time."""
        if self._clock:
            messages.set_stamp(self._clock_message.clock, stamp)
            self._clock.publish(self._clock_message)

    def publish_payload(
        self, stamp: int, position: Sequence[float], orientation: Sequence[float]
    ) -> None:
        """Publish the payload's position, m, and orientation, x, y, z, w, in the world frame."""
        messages.set_stamp(self._payload.header.stamp, stamp)
        set_vector(self._payload.pose.position, position)
        set_quaternion(self._payload.pose.orientation, orientation)
        self._pose.publish(self._payload)

    def publish_description(self, urdf: str) -> None:
        """Publish the robot description, latched for later subscribers."""
        self._description.publish(String(data=urdf))

    def publish_simulation_state(self, state: messages.SimulationState) -> None:
        """Publish the state of the simulation, latched."""
        self._simulation_state.publish(UInt8(data=state))

    def publish_diagnostics(self, stamp: int, warning: str, values: Mapping[str, object]) -> None:
        """Publish one diagnostic status, WARN where there is a `warning`."""
        message = messages.diagnostics(self._source, warning, values)
        messages.set_stamp(message.header.stamp, stamp)
        self._diagnostics.publish(message)

    def update_subscribers(self) -> bool:
        """Update which topics have subscribers: skipping others saves a tenth of a lockstep step.

        Returns:
            whether the joint states have more subscribers than at the last update.
        """
        self.clock_subscribed = self._clock is not None and self._clock.get_subscription_count() > 0
        self.effort_subscribed = self._efforts.get_subscription_count() > 0
        self.payload_subscribed = self._pose.get_subscription_count() > 0
        self.truth_subscribed = self._truth is not None and self._truth.get_subscription_count() > 0
        before, self._state_subscribers = (
            self._state_subscribers,
            self._states.get_subscription_count(),
        )
        return self._state_subscribers > before

    def missing(self, state_subscribers: int, effort_subscribers: int) -> str:
        """Return one line on the subscribers still missing, empty when all are matched."""
        truth = [(self._truth, effort_subscribers)] if self._truth else []
        for publisher, number in (
            (self._states, state_subscribers),
            (self._efforts, effort_subscribers),
            *truth,
        ):
            if (matched := publisher.get_subscription_count()) < number:
                return f"{number - matched} more subscriber(s) of {publisher.topic_name}"
        return ""

    def subscribing_nodes(self) -> set[str]:
        """Return the full names of the nodes that subscribe to the joint states."""
        infos = self._node.get_subscriptions_info_by_topic(self._states.topic_name)
        return {full_name(info) for info in infos}

    def duplicate_publisher(self) -> str:
        """Return one line on another publisher of the joint states, empty where there is none."""
        topic = self._states.topic_name
        if self._node.count_publishers(topic) < 2:
            return ""
        names = sorted(
            publisher.node for publisher in publishers(self._node, topic) if publisher.reliable
        )
        return f"{topic} has {len(names)} publishers: {', '.join(names)}"

    def all_acknowledged(self, timeout: float = 0.0) -> bool:
        """Return whether subscribers acknowledge all joint states within `timeout` [s].

        A dead process does not.
        """
        return self._states.wait_for_all_acked(Duration(seconds=timeout))

    def flush(self, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Wait until every matched subscriber has acknowledged all, or until `should_stop`.

        The wait ends with the liveliness lease of the middleware, after which a dead subscriber is
        removed.
        """
        deadline = time.monotonic() + messages.LIVELINESS_LEASE
        for publisher in filter(None, (self._states, self._truth, self._efforts)):
            while not publisher.wait_for_all_acked(_SLICE):
                if should_stop() or time.monotonic() >= deadline:
                    return
