"""Subscriptions with senders that an executor serves: to the messages of all publishers, and to those of one node."""

from collections.abc import Callable, Sequence
from itertools import islice
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.waitable import NumberOfEntities, Waitable

from crane_sim.ros.common.sender_subscription import MessageWithSender, SenderSubscription
from crane_sim.ros.common.source_filter import PLANT, SourceFilter

_BATCH = 1000  # messages that are taken at a time: a flood costs little, and holds up nothing else


class ServedSubscription(Waitable):
    """A subscription that delivers serialized messages with their senders, some at a time.

    Attributes:
        topic: its name with the namespace.
        polled: the executor leaves messages alone, its owner takes them: in a flood that costs a tenth.
    """

    def __init__(
        self,
        node: Node,
        kind: Any,
        topic: str,
        callback: Callable[[Sequence[MessageWithSender]], object],
        qos: QoSProfile,
        on_incompatible: Callable[[Any], None] | None = None,
    ) -> None:
        """Subscribe; `on_incompatible` is called with the middleware's event on a publisher that is not matched."""
        super().__init__(node.default_callback_group)
        self._subscription, self._callback, self._index = SenderSubscription(node, kind, topic, qos), callback, 0
        self._taken: list[MessageWithSender] = []
        self.polled = False
        self.topic = self._subscription.topic
        node.add_waitable(self)
        events = SubscriptionEventCallbacks(incompatible_qos=on_incompatible)
        for handler in events.create_event_handlers(node.default_callback_group, self._subscription.handle, topic):
            node.add_waitable(handler)

    def count_publishers(self) -> int:
        """Return the number of publishers that it is matched with."""
        return self._subscription.count_publishers()

    def take(self) -> MessageWithSender | None:
        """Take a message without the executor, None where there is none."""
        return self._subscription.take()

    def wait(self, seconds: float) -> None:
        """Return as soon as there is a message, or after `seconds`."""
        self._subscription.wait(seconds)

    def take_all(self) -> None:
        """Deliver the messages that are there without the executor."""
        while taken := list(islice(iter(self._subscription.take, None), _BATCH)):
            self._callback(taken)
            if len(taken) < _BATCH:
                return

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
        """Take messages, and return whether there were any: an earlier call may have taken those of this event."""
        if not self.polled and wait_set.is_ready("subscription", self._index):
            while len(self._taken) < _BATCH and (message := self._subscription.take()):
                self._taken.append(message)
        return bool(self._taken)

    def take_data(self) -> list[MessageWithSender]:
        """Return the messages that were taken."""
        taken, self._taken = self._taken, []
        return taken

    async def execute(self, taken_data: list[MessageWithSender]) -> None:
        """Deliver messages."""
        self._callback(taken_data)


class SourceSubscription(ServedSubscription):
    """A subscription that delivers serialized messages of the node `source` one by one, and refuses those of others.

    A message whose publisher is not known by its name yet is dropped: a plant's comes again.

    Attributes:
        filter: of the publishers.
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
        super().__init__(node, kind, topic, self._deliver, qos)
        self._deliver_one = callback
        self.filter = SourceFilter(node, self.topic, source, standbys)

    def missing(self) -> str:
        """Return one line where the publisher is missing, or is not known by its name yet; empty where it is there."""
        there = self.count_publishers() and self.filter.has_source
        return "" if there else f"a publisher of {self.topic} of the node {self.filter.source}"

    def _deliver(self, taken: Sequence[MessageWithSender]) -> None:
        for message in taken:
            if self.filter.accepts(message.sender):
                self._deliver_one(message.data)
