"""Other cranes on the same clock: none is more than one of its periods ahead of another."""

from collections.abc import Sequence
from functools import partial

from sensor_msgs.msg import JointState

from crane_sim.recording.mcap.topic import has_stamp, stamp_of
from crane_sim.ros.common import messages
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.sender_subscription import MessageWithSender


def peer_names(namespaces: str) -> tuple[str, ...]:
    """Return the namespaces in a text, separated by commas, each once and without outer slashes."""
    names = (name.strip().strip("/") for name in namespaces.split(","))
    return tuple(dict.fromkeys(name for name in names if name))


class ClockPeers:
    """The newest stamps of the other cranes' joint states.

    A crane that was reset is behind the others, until it has caught up or they are reset, too.

    Attributes:
        names: namespaces of the other cranes.
    """

    def __init__(self, host: NodeHost, namespaces: str) -> None:
        """Subscribe to the plants in these namespaces, with commas between them."""
        self.names = names = peer_names(namespaces)
        self._stamps = dict.fromkeys(names, 0)  # ns
        self._subscriptions = {
            name: host.subscribe_with_sender(
                JointState,
                f"/{name}/joint_states",
                partial(self._on_states, name),
                messages.DEEP_STREAM_QOS,
            )
            for name in names
        }

    def missing(self) -> str:
        """Return one line on the first plant that is not in the graph, empty when all are."""
        for subscription in self._subscriptions.values():
            if not subscription.count_publishers():
                return f"a publisher of {subscription.topic}"
        return ""

    def behind(self, stamp: int) -> str:
        """Return the name of a crane in the graph before `stamp` [ns], empty if there is none."""
        late = (name for name, newest in self._stamps.items() if newest < stamp)
        return next((name for name in late if self._subscriptions[name].count_publishers()), "")

    def take_one(self) -> bool:
        """Take a state at once; False where there is none."""
        for name, subscription in self._subscriptions.items():
            if message := subscription.take():
                self._on_states(name, [message])
                return True
        return False

    def _on_states(self, name: str, taken: Sequence[MessageWithSender]) -> None:
        for message in taken:
            if has_stamp(message.data):
                self._stamps[name] = stamp_of(message.data)
