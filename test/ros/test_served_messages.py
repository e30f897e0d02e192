"""What a node's host serves: messages as they come, and everything else, by the executor, at intervals."""

import os
import time
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim.ros.common import node_host
from crane_sim.ros.common.node_host import NodeHost


class FakeSubscription:
    """A subscription whose messages are the counts of an eventfd.

    Attributes:
        delivered: number of messages.
        unannounced: of those that have come without a count.
    """

    def __init__(self) -> None:
        """Create it without messages."""
        self._arrivals, self.delivered, self.unannounced = os.eventfd(0), 0, 0

    def send(self) -> None:
        """Let a message come."""
        os.eventfd_write(self._arrivals, 1)

    def fileno(self) -> int:
        """Return the eventfd."""
        return self._arrivals

    def deliver(self) -> None:
        """Count what has come."""
        self.delivered += os.eventfd_read(self._arrivals)

    def deliver_rest(self) -> None:
        """Count what was not announced."""
        self.delivered, self.unannounced = self.delivered + self.unannounced, 0


class FakeExecutor:
    """An executor with callbacks to call, one at a time.

    Attributes:
        pending: number of callbacks.
        turns: number of times that it was asked.
    """

    def __init__(self) -> None:
        """Have nothing to do."""
        self.pending = self.turns = 0

    def add_node(self, node: Any) -> None:
        """Serve a node."""
        self._node = node

    def spin_once(self, timeout_sec: float) -> None:
        """Call a callback, without waiting."""
        assert timeout_sec == 0.0
        self.turns += 1
        if self.pending:
            self.pending -= 1
            self._node.calls += 1


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a host with one subscription and an executor without a middleware."""
    monkeypatch.setattr(node_host, "EventsExecutor", FakeExecutor)
    signals = SimpleNamespace(SIGINT=2, SIGTERM=15, signal=lambda *_: None)
    monkeypatch.setattr(node_host, "signal", signals)
    node: Any = SimpleNamespace(served=[FakeSubscription()], calls=0)
    pipes: Any = SimpleNamespace(attached=False, read_requests=list)
    return NodeHost(node, pipes)


def test_messages_have_no_turn_to_wait_for(host: Any) -> None:
    """Each spin delivers what has come, on all subscriptions; the executor is asked when its turn is due."""
    first, second = host.node.served[0], FakeSubscription()
    host.node.served.append(second)
    began = time.monotonic()
    for _ in range(5000):
        first.send()
        host.spin()
    second.send()
    host.spin()
    assert (first.delivered, second.delivered) == (5000, 1)
    elapsed = time.monotonic() - began
    assert 1 <= host._executor.turns <= 2 + elapsed / node_host._TURN_PERIOD


def test_a_message_without_a_count_waits_for_a_turn(host: Any) -> None:
    """A message that was counted before it could be taken is delivered all the same, with the next turn."""
    subscription = host.node.served[0]
    host.spin(0.0)
    subscription.unannounced = 1
    while not subscription.delivered:
        host.spin(0.001)
    assert subscription.delivered == 1


def test_callbacks_that_wait_are_called_one_after_another(host: Any) -> None:
    """In its turn the executor goes on as long as there are callbacks, a flood of them up to a number."""
    host._executor.pending = 3
    host.spin()
    assert (host._executor.pending, host._executor.turns) == (0, 4)
    host._executor.pending, host._next_turn = 1000, 0.0
    host.spin()
    assert host._executor.pending == 1000 - node_host._CALLS


def test_without_a_message_the_executor_still_has_its_turn(host: Any) -> None:
    """A node whose subscriptions are silent serves its services."""
    host.spin()
    host._executor.pending = 1
    while host._executor.pending:
        host.spin(0.001)
    assert host.node.calls == 1
