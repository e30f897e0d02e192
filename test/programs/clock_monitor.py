"""Records when two cranes on one clock send states; counts messages and publishers of /clock.

It uses plain rclpy.

Prints the counters as JSON.
"""

import json
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

PERIOD = 10_000_000  # ns, of both cranes
IDLE_TIMEOUT = 2.0  # s without a state after which the runs are taken to be over


class ClockMonitor(Node):
    """A subscriber that records when each state of each crane was first sent."""

    def __init__(self, cranes: list[str]) -> None:
        """Subscribe to the two cranes in these namespaces."""
        super().__init__("clock_monitor")
        # ns of the system's clock, by stamp
        self.sent: dict[str, dict[int, int]] = {crane: {} for crane in cranes}
        self.last_received, self.clock_publishers, self.clock_messages = 0.0, 0, 0
        for crane in cranes:
            self.create_subscription(
                JointState,
                f"/{crane}/joint_states",
                lambda state, info, crane=crane: self._record(crane, state, info),
                QoSProfile(depth=10_000),
            )
        self._clock = self.create_subscription(
            Clock, "/clock", self._on_clock, qos_profile_sensor_data
        )

    def count_early(self) -> int:
        """Return how many states came before the other crane's state one period earlier."""
        first, second = self.sent.values()
        pairs = [(first, second), (second, first)]
        return sum(
            other[stamp - PERIOD] > sent
            for one, other in pairs
            for stamp, sent in one.items()
            if stamp - PERIOD in other
        )

    def _record(self, crane: str, state: JointState, info: dict) -> None:
        stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        self.sent[crane].setdefault(stamp, info["source_timestamp"])
        self.last_received = time.monotonic()
        self.clock_publishers = max(self.clock_publishers, self.count_publishers("/clock"))

    def _on_clock(self, _: Clock) -> None:
        self.clock_messages += 1


def main() -> None:
    """Record until no more states come."""
    rclpy.init()
    monitor = ClockMonitor(sys.argv[1:])
    print("subscribed", flush=True)
    while not monitor.last_received or time.monotonic() - monitor.last_received < IDLE_TIMEOUT:
        rclpy.spin_once(monitor, timeout_sec=0.1)
    common_states = len(set.intersection(*(set(sent) for sent in monitor.sent.values())))
    counters = {"sent_early": monitor.count_early(), "common_states": common_states}
    counters |= {
        "clock_publishers": monitor.clock_publishers,
        "clock_messages": monitor.clock_messages,
    }
    print(json.dumps(counters))


if __name__ == "__main__":
    main()
