"""The topic `base/odometry`: where a base that moves is, and how fast, without errors of measurement."""

from nav_msgs.msg import Odometry
from rclpy.node import Node

from crane_sim.description.rotations import quaternion_of
from crane_sim.description.transforms import BASE, WORLD
from crane_sim.ros.common import messages
from crane_sim.ros.plant.state_publisher import SubscriberCount, set_quaternion, set_vector
from crane_sim.simulation.base_state import base_state
from crane_sim.simulation.plant import Plant


class BaseOdometry:
    """Publisher of the base's pose in `world` and of its velocities in its own axes, as nav_msgs/Odometry has them."""

    def __init__(self, node: Node, prefix: str) -> None:
        """Create the publisher; frames but `world` begin with the prefix."""
        self._publisher = node.create_publisher(Odometry, "base/odometry", messages.STREAM_QOS)
        self._subscribers = SubscriberCount(self._publisher)
        self._message = Odometry(child_frame_id=prefix + BASE)
        self._message.header.frame_id = WORLD

    def update_subscribers(self) -> bool:
        """See `StatePublisher`."""
        return self._subscribers.update()

    def publish(self, stamp: int, plant: Plant) -> None:
        """See `StatePublisher`."""
        if not self._subscribers.number:
            return
        message, state = self._message, base_state(plant.scene, plant.t)
        messages.set_stamp(message.header.stamp, stamp)
        set_vector(message.pose.pose.position, state.position)
        set_quaternion(message.pose.pose.orientation, quaternion_of(state.rotation))
        set_vector(message.twist.twist.linear, state.velocity)
        set_vector(message.twist.twist.angular, state.angular_velocity)
        self._publisher.publish(message)
