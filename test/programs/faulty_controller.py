"""A controller in plain rclpy with zero efforts, and mistakes in its answers to some of the first states."""

import math
import sys

import rclpy
from builtin_interfaces.msg import Time
from rclpy.node import Node
from sensor_msgs.msg import JointState

JOINTS = ["slew", "boom", "jib", "rope"]
PERIOD = 10_000_000  # ns


class FaultyController(Node):
    """A node that answers every state; a wrong command is sent before the right answer."""

    def __init__(self) -> None:
        """Join the crane's namespace."""
        super().__init__("faulty", namespace="knuckle")
        self._skipped_once, self._answered = False, 0
        self._commands = self.create_publisher(JointState, "joint_commands", 10)
        self.create_subscription(JointState, "joint_states", self._on_state, 10)

    def _on_state(self, state: JointState) -> None:
        stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        if stamp <= self._answered:  # sent again, as on a busy machine: its mistakes are counted once
            return
        if not self._commands.get_subscription_count():  # the plant is not matched yet: it sends its state again
            return
        match stamp // PERIOD:
            case 3:  # NaN
                self._send(stamp, JOINTS, [math.nan, 0.0, 0.0, 0.0])
            case 4:  # a joint that the crane does not have
                self._send(stamp, [*JOINTS, "hoist"], [0.0] * 5)
            case 5:  # the stamp of a state that does not exist yet
                self._send(stamp + PERIOD, JOINTS, [1e3] * 4)
            case 6:  # the stamp of a state two periods ago
                self._send(stamp - 2 * PERIOD, JOINTS, [1e3] * 4)
            case 7:  # the stamp of the last state, which is already answered
                self._send(stamp - PERIOD, JOINTS, [1e3] * 4)
            case 8 if not self._skipped_once:  # no answer until the state comes again
                self._skipped_once = True
                return
            case _:
                pass
        self._send(stamp, JOINTS[::-1], [0.0] * 4)
        self._answered = stamp

    def _send(self, stamp: int, names: list[str], efforts: list[float]) -> None:
        message = JointState(name=names, effort=efforts)
        message.header.stamp = Time(sec=stamp // 10**9, nanosec=stamp % 10**9)
        self._commands.publish(message)


if __name__ == "__main__":
    rclpy.init(args=sys.argv)
    rclpy.spin(FaultyController())
