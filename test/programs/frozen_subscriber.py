"""A subscriber that stops itself by SIGSTOP at the first joint state that it receives."""

import os
import signal

import rclpy
from sensor_msgs.msg import JointState


def main() -> None:
    """Subscribe, and stop at the first message."""
    rclpy.init()
    node = rclpy.create_node("frozen")
    node.create_subscription(
        JointState, "/knuckle/joint_states", lambda _: os.kill(os.getpid(), signal.SIGSTOP), 10
    )
    print("subscribed", flush=True)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
