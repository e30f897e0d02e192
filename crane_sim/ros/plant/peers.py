"""Other cranes on the same clock: no crane is ever more than one of its periods ahead of another."""

from functools import partial

from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from crane_sim.recording.mcap.topic import has_stamp, stamp_of
from crane_sim.ros.common import messages


class ClockPeers:
    """Knows how far the other cranes are, by the stamps of their joint states."""

    def __init__(self, node: Node, namespaces: str) -> None:
        """Listen to the plants in these namespaces, with commas between them; to nobody where there are none."""
        names = [name.strip().strip("/") for name in namespaces.split(",") if name.strip()]
        self._stamps = dict.fromkeys(names, 0)  # ns
        self._states: dict[str, Subscription] = {
            name: node.create_subscription(
                JointState, f"/{name}/joint_states", partial(self._note, name), messages.DEEP_STREAM, raw=True
            )
            for name in names
        }

    def missing(self) -> str:
        """Return one line on those that are not there yet, empty when all are."""
        for states in self._states.values():
            if not states.get_publisher_count():
                return f"a publisher of {states.topic_name}"
        return ""

    def behind(self, stamp: int) -> str:
        """Return who has not come to `stamp` [ns], empty where all have; one that has left keeps nobody waiting."""
        behind = (name for name, newest in self._stamps.items() if newest < stamp)
        return next((name for name in behind if self._states[name].get_publisher_count()), "")

    def fetch(self) -> bool:
        """Take a state that waits, without the executor; False where there is none."""
        for name, states in self._states.items():
            if data := messages.take_message(states, JointState):
                self._note(name, data)
                return True
        return False

    def _note(self, name: str, data: bytes) -> None:
        if has_stamp(data):
            self._stamps[name] = stamp_of(data)
