"""The plant's side of the ROS graph: its publishers, and what each needs to fill its message quickly."""

import time
from collections.abc import Callable, Mapping, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String, UInt8

from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.common.timing import Errors

_SLICE = Duration(nanoseconds=20_000_000)  # of a wait in which no signal is heard


class PlantTopics:
    """Publishes what the plant has to say; stamps are integer ns, vectors in the scene's joint order.

    Attributes:
        publishing: how long it took to hand each joint state to the middleware.
        clock_heard, effort_heard, payload_heard: somebody subscribed to this topic when `look_around` last looked.
    """

    def __init__(self, node: Node, joints: Sequence[str], actuated: Sequence[str], clock: bool = True) -> None:
        """Create every publisher of the node `plant`; that of /clock only where `clock`."""
        self._states = node.create_publisher(JointState, "joint_states", messages.DEEP_STREAM)
        self._efforts = node.create_publisher(JointState, "applied_effort", messages.DEEP_STREAM)
        self._clock = node.create_publisher(Clock, "/clock", messages.CLOCK) if clock else None
        self._pose = node.create_publisher(PoseStamped, "payload_pose", messages.SENSOR)
        self._description = node.create_publisher(String, "robot_description", messages.LATCHED)
        self._simulation = node.create_publisher(UInt8, "simulation_state", messages.LATCHED)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", messages.STREAM)
        self._source = f"{node.get_namespace().strip('/')}/plant"
        self._state_wire = JointWire(joints, effort=False)
        self._effort_wire = JointWire(actuated, effort=True)
        self._tick, self._payload = Clock(), PoseStamped()
        self._payload.header.frame_id = "world"
        self.clock_heard = self.effort_heard = self.payload_heard = False
        self.publishing = Errors()

    def publish_state(self, stamp: int, q: Sequence[float], v: Sequence[float]) -> None:
        """Publish the joint state; the first thing to leave in a step, since the controller waits for it."""
        message = self._state_wire.encode(stamp, q, v)
        began = time.perf_counter()
        self._states.publish(message)
        self.publishing.add(time.perf_counter() - began)

    def publish_effort(self, stamp: int, effort: Sequence[float]) -> None:
        """Publish the effort applied from `stamp` on, after limits and faults."""
        self._efforts.publish(self._effort_wire.encode(stamp, effort))

    def publish_clock(self, stamp: int) -> None:
        """Publish the simulation's time."""
        if self._clock:
            messages.set_stamp(self._tick.clock, stamp)
            self._clock.publish(self._tick)

    def publish_payload(self, stamp: int, position: Sequence[float]) -> None:
        """Publish the payload's position, m, in the world frame."""
        messages.set_stamp(self._payload.header.stamp, stamp)
        point = self._payload.pose.position
        point.x, point.y, point.z = position
        self._pose.publish(self._payload)

    def publish_description(self, urdf: str) -> None:
        """Publish the robot description for everyone who comes, now or later."""
        self._description.publish(String(data=urdf))

    def publish_simulation_state(self, state: int) -> None:
        """Publish STOPPED, PLAYING, PAUSED or QUITTING."""
        self._simulation.publish(UInt8(data=state))

    def publish_diagnostics(self, stamp: int, warning: str, values: Mapping[str, object]) -> None:
        """Publish one diagnostic status, WARN where there is a `warning`."""
        message = messages.diagnostics(self._source, warning, values)
        messages.set_stamp(message.header.stamp, stamp)
        self._diagnostics.publish(message)

    def look_around(self) -> None:
        """Note who listens: what nobody hears need not be said, which saves a tenth of a lockstep step."""
        self.clock_heard = self._clock is not None and self._clock.get_subscription_count() > 0
        self.effort_heard = self._efforts.get_subscription_count() > 0
        self.payload_heard = self._pose.get_subscription_count() > 0

    def missing(self, peers: int, recorders: int) -> str:
        """Return one line on the subscribers still missing, empty when all are matched."""
        wanted = ((self._states, peers), (self._efforts, recorders))
        for publisher, number in wanted:
            if (found := publisher.get_subscription_count()) < number:
                return f"{number - found} more subscriber(s) of {publisher.topic_name}"
        return ""

    @property
    def acknowledged(self) -> bool:
        """Whether all who hear the joint states have the newest one: the middleware of a dead process has it not."""
        return self._states.wait_for_all_acked(Duration(seconds=0))

    def flush(self, given_up: Callable[[], bool] = lambda: False) -> None:
        """Wait until every matched subscriber has received what was published, or `given_up`, asked now and then.

        Who does not acknowledge is waited for as long as the middleware may take him for alive.
        """
        deadline = time.monotonic() + messages.LEASE
        for publisher in (self._states, self._efforts):
            while not publisher.wait_for_all_acked(_SLICE):
                if given_up() or time.monotonic() >= deadline:
                    return
