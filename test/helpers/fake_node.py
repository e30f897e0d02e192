"""A node without a middleware, for what a controller publishes."""

from collections import Counter, defaultdict
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.serialization import serialize_message

_MODULES = (
    "crane_sim.ros.controller.responder",
    "crane_sim.ros.controller.setpoints",
)


@pytest.fixture
def fake_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nodes without a middleware subscribe to sources without publishers to tell apart."""
    for module in _MODULES:
        monkeypatch.setattr(f"{module}.SourceSubscription", FakeSourceSubscription)


class FakeSourceSubscription:
    """A subscription of a fake node that delivers messages, serialized or not, as serialized ones.

    Attributes:
        filter: which has refused nothing.
    """

    def __init__(
        self, node: Any, kind: type, topic: str, callback: Any, qos: Any, *_: Any, **__: Any
    ) -> None:
        """Subscribe."""
        self.filter = SimpleNamespace(refused=Counter())

        def deliver(message: Any) -> None:
            callback(message if isinstance(message, bytes) else serialize_message(message))

        node.create_subscription(kind, topic, deliver, qos, raw=True)

    def missing(self) -> str:
        """Return that nothing is."""
        return ""


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

    def create_subscription(
        self, _kind: type, topic: str, callback: Any, _qos: Any, **_: Any
    ) -> None:
        """Record the callback."""
        self.callbacks[topic] = callback
