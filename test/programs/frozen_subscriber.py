"""A subscriber that stops, as with SIGSTOP, at the first joint state that it hears, and never goes on."""

import os
import signal

import rclpy
from sensor_msgs.msg import JointState


def main() -> None:
    """Listen until something comes."""
    rclpy.init()
    node = rclpy.create_node("frozen")
    node.create_subscription(JointState, "/knuckle/joint_states", lambda _: os.kill(os.getpid(), signal.SIGSTOP), 10)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
