"""A node without a middleware, for what a controller publishes."""

from collections import defaultdict
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any


class FakeNode:
    """A node that records callbacks and messages.

    Attributes:
        callbacks: of its subscriptions, by topic.
        published: messages by topic.
    """

    def __init__(self) -> None:
        """Create it without topics."""
        self.callbacks: dict[str, Callable[[Any], None]] = {}
        self.published = defaultdict[str, list[Any]](list)
        self.get_name, self.get_namespace = (lambda: "controller"), (lambda: "/pendulum")

    def create_publisher(self, _kind: type, topic: str, _qos: Any) -> SimpleNamespace:
        """Return a publisher, which records messages."""
        return SimpleNamespace(publish=self.published[topic].append)

    def create_subscription(self, _kind: type, topic: str, callback: Any, _qos: Any, **_: Any) -> None:
        """Record the callback."""
        self.callbacks[topic] = callback
