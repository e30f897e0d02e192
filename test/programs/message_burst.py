"""Publishes thousands of messages on three topics in turn, at full speed, until input closes."""

import sys
import time

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState

from crane_sim import load_scene
from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import EFFORT, JointStateCodec

TOPICS = ("joint_states", "joint_commands", "applied_effort")
LIMIT = 300.0  # s for the subscriber to be matched
COUNT = 4000  # messages a topic: fewer than a recorder's history holds


def main() -> None:
    """Publish to one subscriber."""
    rclpy.init()
    node: Node = rclpy.create_node("plant")  # whose messages a recorder takes
    joints = load_scene("knuckle_setpoint").actuated
    codec, zeros = JointStateCodec(joints, EFFORT), (0.0,) * len(joints)
    publishers = [
        node.create_publisher(JointState, name, messages.DEEP_STREAM_QOS) for name in TOPICS
    ]
    deadline = time.monotonic() + LIMIT
    while not all(publisher.get_subscription_count() for publisher in publishers):
        assert time.monotonic() < deadline, f"no subscriber within {LIMIT:g} s"
        time.sleep(0.01)
    for k in range(1, COUNT + 1):
        for publisher in publishers:
            publisher.publish(codec.encode(k, zeros))
    sys.stdin.read()


if __name__ == "__main__":
    main()
