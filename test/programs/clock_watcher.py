"""Watches cranes that step together, and /clock; prints as JSON what it saw. Plain rclpy."""

import json
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

PERIOD = 10_000_000  # ns, of both cranes
QUIET = 2.0  # s without a state: the runs are over


class Watcher(Node):
    """Notes when each state of each crane was first sent."""

    def __init__(self, cranes: list[str]) -> None:
        """Listen to the cranes in these namespaces."""
        super().__init__("watcher")
        self.sent: dict[str, dict[int, int]] = {crane: {} for crane in cranes}  # ns of the system's clock, by stamp
        self.heard, self.leaders, self.times = 0.0, 0, 0
        for crane in cranes:
            self.create_subscription(
                JointState,
                f"/{crane}/joint_states",
                lambda state, about, crane=crane: self._note(crane, state, about),
                QoSProfile(depth=10_000),
            )
        self._clock = self.create_subscription(Clock, "/clock", self._on_clock, qos_profile_sensor_data)

    def hasty(self) -> int:
        """Return how many states were sent before the other crane had sent the state one period earlier."""
        first, second = self.sent.values()
        pairs = [(first, second), (second, first)]
        return sum(
            other[stamp - PERIOD] > sent
            for one, other in pairs
            for stamp, sent in one.items()
            if stamp - PERIOD in other
        )

    def _note(self, crane: str, state: JointState, about: dict) -> None:
        stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        self.sent[crane].setdefault(stamp, about["source_timestamp"])
        self.heard = time.monotonic()
        self.leaders = max(self.leaders, self.count_publishers("/clock"))

    def _on_clock(self, _: Clock) -> None:
        self.times += 1


def main() -> None:
    """Watch until all is quiet."""
    rclpy.init()
    watcher = Watcher(sys.argv[1:])
    while not watcher.heard or time.monotonic() - watcher.heard < QUIET:
        rclpy.spin_once(watcher, timeout_sec=0.1)
    common = len(set.intersection(*(set(sent) for sent in watcher.sent.values())))
    print(json.dumps({"hasty": watcher.hasty(), "common": common, "leaders": watcher.leaders, "times": watcher.times}))


if __name__ == "__main__":
    main()
