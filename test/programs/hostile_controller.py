"""A controller that sends invalid commands before every valid one; prints their numbers as JSON.

The numbers are by reason.
"""

import json
import sys
from collections import Counter

import rclpy
from invalid_commands import JOINTS, PERIOD, InvalidCommands, command_message
from rclpy.duration import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState

from crane_sim import load_scene


class HostileController(Node):
    """The law of the default scene, with `each` invalid commands per state."""

    def __init__(self, each: int) -> None:
        """Join the crane's namespace."""
        super().__init__("hostile", namespace="knuckle")
        self.sent: Counter[str] = Counter()
        self.answered = 0
        self._each, self._invalid, self._scene = (
            each,
            InvalidCommands(2),
            load_scene("knuckle_setpoint"),
        )
        self._commands = self.create_publisher(JointState, "joint_commands", 10)
        self.create_subscription(JointState, "joint_states", self._on_state, 10)

    def wait_for_plant(self) -> bool:
        """Wait until the plant has acknowledged all commands; return whether it has in a minute."""
        return self._commands.wait_for_all_acked(Duration(seconds=60.0))

    def _on_state(self, state: JointState) -> None:
        stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        if stamp // PERIOD != self.answered + 1:
            return  # sent again: it has been answered
        if self._commands.get_subscription_count() < 2:
            return  # plant and recorder are not matched yet: the state comes again
        self.answered += 1
        for _ in range(self._each):
            reason, data = self._invalid.generate(stamp)
            self.sent[reason] += 1
            self._commands.publish(data)
        t = (stamp // PERIOD - 1) * self._scene.period
        law = self._scene.law
        assert law is not None
        self._commands.publish(
            command_message(stamp, JOINTS, law(t, tuple(state.position), tuple(state.velocity)))
        )


if __name__ == "__main__":
    rclpy.init()
    node = HostileController(int(sys.argv[1]))
    while node.answered < int(sys.argv[2]):
        rclpy.spin_once(node, timeout_sec=0.1)
    print(json.dumps(node.sent), flush=True)
    assert node.wait_for_plant(), "the plant has not acknowledged the last answer"
