"""Other cranes on the same clock: no crane is ever more than one of its periods ahead of another."""

from functools import partial

from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from crane_sim.recording.mcap.topic import has_stamp, stamp_of
from crane_sim.ros.common import messages


def peer_names(namespaces: str) -> tuple[str, ...]:
    """Return the namespaces in a text with commas between them, without slashes around them, each once."""
    names = (name.strip().strip("/") for name in namespaces.split(","))
    return tuple(dict.fromkeys(name for name in names if name))


class ClockPeers:
    """The newest stamps of the other cranes' joint states.

    A crane that was reset is behind the others, until it has caught up or they are reset, too.

    Attributes:
        names: namespaces of the other cranes.
    """

    def __init__(self, node: Node, namespaces: str) -> None:
        """Subscribe to the plants in these namespaces, with commas between them."""
        self.names = names = peer_names(namespaces)
        self._stamps = dict.fromkeys(names, 0)  # ns
        self._subscriptions: dict[str, Subscription] = {
            name: node.create_subscription(
                JointState, f"/{name}/joint_states", partial(self._on_state, name), messages.DEEP_STREAM_QOS, raw=True
            )
            for name in names
        }

    def missing(self) -> str:
        """Return one line on the first plant that is not in the graph, empty when all are."""
        for subscription in self._subscriptions.values():
            if not subscription.get_publisher_count():
                return f"a publisher of {subscription.topic_name}"
        return ""

    def behind(self, stamp: int) -> str:
        """Return the name of a crane in the graph that has not reached `stamp` [ns], empty where all have."""
        late = (name for name, newest in self._stamps.items() if newest < stamp)
        return next((name for name in late if self._subscriptions[name].get_publisher_count()), "")

    def take_one(self) -> bool:
        """Take a state without the executor; False where there is none."""
        for name, subscription in self._subscriptions.items():
            if data := messages.take_message(subscription, JointState):
                self._on_state(name, data)
                return True
        return False

    def _on_state(self, name: str, data: bytes) -> None:
        if has_stamp(data):
            self._stamps[name] = stamp_of(data)
