"""A subscription to the messages of one node, served by an executor."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.waitable import NumberOfEntities, Waitable

from crane_sim.ros.common.sender_subscription import MessageWithSender, SenderSubscription
from crane_sim.ros.common.source_filter import PLANT, SourceFilter


class SourceSubscription(Waitable):
    """A subscription that delivers serialized messages of the node `source`, and refuses those of others.

    Attributes:
        filter: of the publishers.
        topic: its name with the namespace.
    """

    def __init__(
        self,
        node: Node,
        kind: Any,
        topic: str,
        callback: Callable[[bytes], object],
        qos: QoSProfile,
        source: str = PLANT,
        standbys: bool = False,
    ) -> None:
        """Subscribe; arguments: see `Node.create_subscription` and `SourceFilter`."""
        super().__init__(node.default_callback_group)
        self._subscription, self._callback, self._index = SenderSubscription(node, kind, topic, qos), callback, 0
        self.topic = self._subscription.topic
        self.filter = SourceFilter(node, self.topic, source, standbys)
        node.add_waitable(self)

    def missing(self) -> str:
        """Return one line where the publisher is missing, or is not known by its name yet; empty where it is there."""
        there = self._subscription.count_publishers() and self.filter.has_source
        return "" if there else f"a publisher of {self.topic} of the node {self.filter.source}"

    def __enter__(self) -> None:
        """Keep the handle while the executor waits."""
        self._subscription.handle.__enter__()

    def __exit__(self, *error: object) -> None:
        """Release the handle."""
        self._subscription.handle.__exit__(*error)

    def get_num_entities(self) -> NumberOfEntities:
        """Return what the executor waits for."""
        return NumberOfEntities(num_subs=1)

    def add_to_wait_set(self, wait_set: Any) -> None:
        """Let the executor wait for messages."""
        self._index = wait_set.add_subscription(self._subscription.handle)

    def is_ready(self, wait_set: Any) -> bool:
        """Return whether there is a message."""
        return wait_set.is_ready("subscription", self._index)

    def take_data(self) -> MessageWithSender | None:
        """Take a message."""
        return self._subscription.take()

    async def execute(self, taken_data: MessageWithSender | None) -> None:
        """Deliver a message; one whose publisher is not known by its name yet is dropped, the plant's comes again."""
        if taken_data is not None and self.filter.accepts(taken_data.sender):
            self._callback(taken_data.data)
