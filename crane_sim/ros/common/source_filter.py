"""Filter of the messages of a topic by their publishers: a node believes its source, and refuses all others by name."""

import time
from collections import Counter
from collections.abc import Mapping

from rclpy.node import Node

from crane_sim.ros.common.sender_subscription import GONE, UNNAMED, publishers

PLANT = "plant"
"""Name of the node that states, efforts and held commands are of, in the namespace of the nodes that take them."""
_LOOK_PERIOD = 0.05  # s between two looks at the graph: there may be thousands of messages in a second


def refused_entry(refused: Mapping[str, int]) -> dict[str, dict[str, int]]:
    """Return the entry of a run's summary on messages refused, by topic and node; none where there are none."""
    return {"refused_messages": dict(refused)} if refused else {}


class SourceFilter:
    """Filter that passes the messages of one publisher of the node `source`, and later ones' when that has left.

    A publisher is known by its identifier, a node by its name: of two publishers with the source's name the first one
    is believed as long as it is in the graph.

    Attributes:
        source: full name of the node that is believed.
        refused: number of messages refused, by topic and full name of their node.
    """

    def __init__(self, node: Node, topic: str, source: str = PLANT, standbys: bool = False) -> None:
        """Believe a node in the namespace of `node` on a topic; with `standbys` every publisher with its name."""
        self.source = f"{node.get_namespace().rstrip('/')}/{source}"
        self.refused = Counter[str]()
        self._node, self._topic, self._standbys = node, topic, standbys
        self._believed, self._names, self._next_look = b"", dict[bytes, str](), 0.0

    @property
    def has_source(self) -> bool:
        """Whether a publisher of the source is in the graph."""
        self._look()
        return self.source in self._names.values()

    def accepts(self, sender: bytes) -> bool | None:
        """Return whether a message of this publisher passes, counted if not; None while its name has not arrived."""
        if sender == self._believed:
            return True
        name = self._names.get(sender, "")
        if name in ("", self.source):  # it is new, or there was another one with this name
            self._look()
            name = self._names.get(sender, "")
        if name == self.source and (self._standbys or self._believed not in self._names):
            self._believed = sender
            return True
        if name:
            self.refused[f"{self._topic} of {name}"] += 1
        return False if name else None

    def refuse(self, sender: bytes) -> None:
        """Count a message that does not fit, or whose publisher has left before its name came."""
        self.refused[f"{self._topic} of {self._names.get(sender, GONE)}"] += 1

    def _look(self) -> None:
        """Look at the graph, unless that was done just now; nodes whose names have not arrived are left out."""
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + _LOOK_PERIOD
        found = publishers(self._node, self._topic)
        self._names = {publisher.gid: publisher.node for publisher in found if publisher.node != UNNAMED}
