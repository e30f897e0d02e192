"""A publisher of the same effort, again and again, without stamps or subscriptions.

It is like `ros2 topic pub`.
"""

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState

JOINTS = ["slew", "boom", "jib", "rope"]


def main() -> None:
    """Publish until the process is killed."""
    rclpy.init()
    node = Node("blind_publisher", namespace="knuckle")
    commands = node.create_publisher(JointState, "joint_commands", 10)
    node.create_timer(
        0.05, lambda: commands.publish(JointState(name=JOINTS, effort=[0.0] * len(JOINTS)))
    )
    rclpy.spin(node)


if __name__ == "__main__":
    main()
