"""The topics of a run as a recorder hears them: one subscription each, in the bytes that came over the wire."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import String, UInt8
from trajectory_msgs.msg import JointTrajectory

from crane_sim.recording.mcap_file import Channel

Taker = Callable[[bytes], None]

_DEPTH = 10_000  # more steps than a plant makes while a block is written
_STREAM = QoSProfile(depth=_DEPTH)
_SENSOR = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
_LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Topic(NamedTuple):
    """How a topic is subscribed to."""

    kind: Any  # message class
    qos: QoSProfile


TOPICS = {
    "joint_states": Topic(JointState, _STREAM),
    "applied_effort": Topic(JointState, _STREAM),
    "joint_commands": Topic(JointState, _STREAM),
    "joint_trajectory": Topic(JointTrajectory, _STREAM),
    "payload_pose": Topic(PoseStamped, _SENSOR),
    "robot_description": Topic(String, _LATCHED),
    "simulation_state": Topic(UInt8, _LATCHED),
}
_OF_THE_PLANT = ("joint_states", "applied_effort")
