"""A controller that answers every state with the same effort: NAME EFFORT. Plain rclpy."""

import sys

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState

JOINTS = ["slew", "boom", "jib", "rope"]


def main(name: str, effort: float) -> None:
    """Answer until the process is killed."""
    rclpy.init()
    node = Node(name, namespace="knuckle")
    commands = node.create_publisher(JointState, "joint_commands", 10)

    def answer(state: JointState) -> None:
        commands.publish(
            JointState(header=state.header, name=JOINTS, effort=[effort] * len(JOINTS))
        )

    node.create_subscription(JointState, "joint_states", answer, 10)
    rclpy.spin(node)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
