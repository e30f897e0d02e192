"""A flood of `joint_commands` at 20 kHz from the second state on; prints its count as JSON."""

import json
import sys
import time

import rclpy
from invalid_commands import JOINTS, PERIOD, InvalidCommands, command_message
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt8

from crane_sim.ros.common.messages import SimulationState

RATE = 20_000.0  # Hz


class Flood(Node):
    """A publisher of invalid and, every fourth time, valid commands that does not own the crane."""

    def __init__(self) -> None:
        """Create the node in the crane's namespace."""
        super().__init__("flood", namespace="knuckle")
        self.stamp, self.simulation_state, self.sent = 0, -1, 0
        invalid = InvalidCommands(3)
        self._prepared = [invalid.generate(10**9)[1] for _ in range(1000)]
        self._commands = self.create_publisher(JointState, "joint_commands", 10)
        latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(JointState, "joint_states", self._on_state, 10)
        self.create_subscription(UInt8, "simulation_state", self._on_simulation_state, latched)

    def send(self) -> None:
        """Send one command."""
        valid = self.sent % 4 == 0
        prepared = self._prepared[self.sent % 1000]
        self._commands.publish(
            command_message(self.stamp, JOINTS, [5.0] * 4) if valid else prepared
        )
        self.sent += 1

    def _on_state(self, state: JointState) -> None:
        self.stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec

    def _on_simulation_state(self, message: UInt8) -> None:
        self.simulation_state = message.data


def main() -> None:
    """Flood one run."""
    rclpy.init(args=sys.argv)
    flood = Flood()
    while flood.stamp < 2 * PERIOD:
        # then the scene's own controller owns the crane: it has moved it
        rclpy.spin_once(flood, timeout_sec=0.1)
    start, sent = time.monotonic(), 0
    while flood.simulation_state != SimulationState.STOPPED:
        due = int((time.monotonic() - start) * RATE)
        for _ in range(min(due - sent, 200)):
            flood.send()
        sent = due
        rclpy.spin_once(flood, timeout_sec=0.0)
    print(
        json.dumps({"sent": flood.sent, "rate": flood.sent / (time.monotonic() - start)}),
        flush=True,
    )
    rclpy.shutdown()


if __name__ == "__main__":
    main()
