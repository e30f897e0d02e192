"""A controller that holds the crane by zero effort in its own way: `best_effort`, `wall_clock`.

`best_effort` subscribes and publishes with best effort; on a line of its input it publishes
reliably. `wall_clock` stamps its commands with the time of the system, as a node without simulated
time does.
"""

import select
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


class OddController(Node):
    """A controller of the scene overhead_energy."""

    def __init__(self, kind: str) -> None:
        """Join the crane's namespace."""
        super().__init__("odd", namespace="overhead")
        self._wall_clock, qos = kind == "wall_clock", 10 if kind == "wall_clock" else BEST_EFFORT
        self._commands = self.create_publisher(JointState, "joint_commands", qos)
        self.create_subscription(JointState, "joint_states", self._on_state, qos)

    def be_reliable(self) -> None:
        """Publish reliably from now on."""
        self._commands = self.create_publisher(JointState, "joint_commands", 10)

    def _on_state(self, state: JointState) -> None:
        command = JointState(header=state.header, name=["trolley"], effort=[0.0])
        if self._wall_clock:
            command.header.stamp.sec = int(time.time())
        self._commands.publish(command)


def main() -> None:
    """Answer until the process is killed."""
    rclpy.init()
    node = OddController(sys.argv[1])
    waits = True
    while rclpy.ok():
        rclpy.spin_once(node, timeout_sec=0.05)
        if waits and select.select([sys.stdin], [], [], 0)[0]:
            sys.stdin.readline()
            node.be_reliable()
            waits = False


if __name__ == "__main__":
    main()
