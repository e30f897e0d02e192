"""Filter of a topic's messages by their publishers: all but those of the source are refused."""

import time
from collections import Counter

from rclpy.node import Node

from crane_sim.ros.common.sender_subscription import GONE, UNNAMED, publishers

PLANT = "plant"
"""Name of the node that states, efforts and held commands are of, in the namespace of the nodes
that take them."""
# s between two looks at the graph: there may be thousands of messages in a second
_LOOK_PERIOD = 0.05


class SourceFilter:
    """Filter that passes one publisher of the node `source`, and the next when that is gone.

    A publisher is known by its identifier, a node by its name: of two publishers with the source's
    name the first one is the accepted source as long as it is in the graph.

    Attributes:
        source: full name of the node whose messages are accepted.
        refused: number of messages refused, by topic and full name of their node.
    """

    def __init__(self, node: Node, topic: str, source: str = PLANT, standbys: bool = False) -> None:
        """Accept a node in the namespace of `node`; with `standbys` every publisher of its name."""
        self.source = f"{node.get_namespace().rstrip('/')}/{source}"
        self.refused = Counter[str]()
        self._node, self._topic, self._standbys = node, topic, standbys
        self._publisher, self._names, self._next_look = b"", dict[bytes, str](), 0.0

    @property
    def has_source(self) -> bool:
        """Whether a publisher of the source is in the graph."""
        self._look()
        return self.source in self._names.values()

    def accepts(self, sender: bytes) -> bool | None:
        """Return whether a publisher's message passes, counted if not; None without a name yet."""
        if sender == self._publisher:
            return True
        name = self._names.get(sender, "")
        if name in ("", self.source):  # it is new, or there was another one with this name
            self._look()
            name = self._names.get(sender, "")
        if name == self.source and (self._standbys or self._publisher not in self._names):
            self._publisher = sender
            return True
        if name:
            self.refused[f"{self._topic} of {name}"] += 1
        return False if name else None

    def refuse(self, sender: bytes) -> None:
        """Count a message that does not fit, or whose publisher was gone before its name came."""
        self.refused[f"{self._topic} of {self._names.get(sender, GONE)}"] += 1

    def _look(self) -> None:
        """Read the graph, unless just done; nodes whose names have not arrived are left out."""
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + _LOOK_PERIOD
        found = publishers(self._node, self._topic)
        self._names = {
            publisher.gid: publisher.node for publisher in found if publisher.node != UNNAMED
        }
