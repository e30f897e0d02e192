"""Subscriptions that a node's host serves, with senders: to all publishers or to one node's."""

import os
from collections.abc import Callable, Sequence
from itertools import islice
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile

from crane_sim.ros.common.nodes import ServingNode
from crane_sim.ros.common.sender_subscription import MessageWithSender, SenderSubscription
from crane_sim.ros.common.source_filter import PLANT, SourceFilter

_BATCH = 1000  # messages that are delivered at a time: a flood holds up nothing else


class ServedSubscription(SenderSubscription):
    """A subscription that delivers serialized messages with their senders when the host spins."""

    def __init__(
        self,
        node: ServingNode,
        kind: Any,
        topic: str,
        callback: Callable[[Sequence[MessageWithSender]], object],
        qos: QoSProfile,
        on_incompatible: Callable[[Any], None] | None = None,
    ) -> None:
        """Subscribe; `on_incompatible` gets the middleware's event on an unmatched publisher."""
        super().__init__(node, kind, topic, qos)
        self._callback, self._arrivals = callback, self.count_arrivals()
        node.serve(self)
        events = SubscriptionEventCallbacks(incompatible_qos=on_incompatible)
        for handler in events.create_event_handlers(
            node.default_callback_group, self.handle, topic
        ):
            node.add_waitable(handler)

    def fileno(self) -> int:
        """Return the file that can be read when there are messages."""
        return self._arrivals

    def deliver(self) -> None:
        """Deliver the messages that have been counted since the last time."""
        try:
            count = os.eventfd_read(self._arrivals)
        except BlockingIOError:  # there are none
            return
        if count > _BATCH:
            os.eventfd_write(self._arrivals, count - _BATCH)
        self._deliver_up_to(count)

    def deliver_rest(self) -> None:
        """Deliver what is there: a message may have been counted before it could be taken.

        One that overtook another, which was lost and sent again, waits for that.
        """
        self._deliver_up_to(_BATCH)

    def _deliver_up_to(self, count: int) -> None:
        if taken := list(islice(iter(self.take, None), min(count, _BATCH))):
            self._callback(taken)


class SourceSubscription(ServedSubscription):
    """A subscription that delivers the node `source`'s serialized messages, and refuses others.

    A message whose publisher is not known by its name yet is dropped: a plant's comes again.

    Attributes:
        filter: of the publishers.
    """

    def __init__(
        self,
        node: ServingNode,
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
        """Return a line where the publisher is missing or not known by its name yet; else empty."""
        there = self.count_publishers() and self.filter.has_source
        return "" if there else f"a publisher of {self.topic} of the node {self.filter.source}"

    def _deliver(self, taken: Sequence[MessageWithSender]) -> None:
        for message in taken:
            if self.filter.accepts(message.sender):
                self._deliver_one(message.data)
