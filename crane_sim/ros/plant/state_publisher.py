"""What publishes more than a plant's joint states: frames, the base, sensors."""

from collections.abc import Iterable
from typing import Any

from geometry_msgs.msg import Point, Quaternion, Vector3
from nav_msgs.msg import Odometry
from rclpy.node import Node

from crane_sim.description.rotations import quaternion_of
from crane_sim.description.transforms import BASE, WORLD
from crane_sim.ros.common import messages
from crane_sim.simulation.base_state import base_state
from crane_sim.simulation.plant import Plant


class StatePublisher:
    """Publishes something of every state published as `joint_states`, where it has subscribers."""

    def __init__(self, publisher: Any) -> None:
        """Publish by this publisher."""
        self._publisher, self._subscribers = publisher, 0

    def update_subscribers(self) -> bool:
        """Count the subscribers; return whether there are more than before."""
        before, self._subscribers = self._subscribers, self._publisher.get_subscription_count()
        return self._subscribers > before

    def publish(self, stamp: int, plant: Plant) -> None:
        """Publish what belongs to the present state, stamped `stamp` [ns]."""
        raise NotImplementedError


class BaseOdometry(StatePublisher):
    """The topic `base/odometry`: the exact pose in `world`, and velocities in the base's axes."""

    def __init__(self, node: Node, prefix: str) -> None:
        """Create the publisher; frames but `world` begin with the prefix."""
        super().__init__(node.create_publisher(Odometry, "base/odometry", messages.STREAM_QOS))
        self._message = Odometry(child_frame_id=prefix + BASE)
        self._message.header.frame_id = WORLD

    def publish(self, stamp: int, plant: Plant) -> None:
        """See `StatePublisher`."""
        if not self._subscribers:
            return
        message, state = self._message, base_state(plant.scene, plant.t)
        messages.set_stamp(message.header.stamp, stamp)
        set_vector(message.pose.pose.position, state.position)
        set_quaternion(message.pose.pose.orientation, quaternion_of(state.rotation))
        set_vector(message.twist.twist.linear, state.velocity)
        set_vector(message.twist.twist.angular, state.angular_velocity)
        self._publisher.publish(message)


def set_vector(vector: Vector3 | Point, values: Iterable[float]) -> None:
    """Write (3,) into a vector or point."""
    vector.x, vector.y, vector.z = map(float, values)


def set_quaternion(quaternion: Quaternion, values: Iterable[float]) -> None:
    """Write x, y, z, w into a quaternion."""
    quaternion.x, quaternion.y, quaternion.z, quaternion.w = map(float, values)
