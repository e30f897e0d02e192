"""What a node's host serves: messages as they come, all else by the executor at intervals."""

import os
import select
import time
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim.ros.common import node_host
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.nodes import ServingNode


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
        silent: number of events without a callback that come first.
        guards: whether a call without anything follows each callback, as that of a guard condition
            does.
        turns: number of times that it was asked.
    """

    def __init__(self) -> None:
        """Have nothing to do."""
        self.pending = self.silent = self.turns = 0
        self.guards = self._guard = False

    def add_node(self, node: Any) -> None:
        """Serve a node."""
        self._node = node

    def spin_once(self, timeout_sec: float) -> None:
        """Handle an event, or wait for one."""
        self.turns += 1
        if self.silent:
            self.silent -= 1
        elif self.pending and not self._guard:
            self.pending -= 1
            self._node.calls += 1
            self._guard = self.guards
        else:
            self._guard = False
            time.sleep(timeout_sec)


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a host with one subscription and an executor without a middleware."""
    monkeypatch.setattr(node_host, "EventsExecutor", FakeExecutor)
    monkeypatch.setattr(node_host, "SingleThreadedExecutor", FakeExecutor)
    signals = SimpleNamespace(SIGINT=2, SIGTERM=15, signal=lambda *_: None)
    monkeypatch.setattr(node_host, "signal", signals)
    subscription, arrivals = FakeSubscription(), select.epoll()
    arrivals.register(subscription.fileno(), select.EPOLLIN)
    node: Any = SimpleNamespace(
        served={subscription.fileno(): subscription}, arrivals=arrivals, calls=0
    )
    pipes: Any = SimpleNamespace(attached=False, read_requests=list)
    return NodeHost(node, pipes)


def test_messages_have_no_turn_to_wait_for(host: Any) -> None:
    """Each spin delivers what has come on all subscriptions; the executor has its turn when due."""
    (first,), second = host.node.served.values(), FakeSubscription()
    ServingNode.serve(host.node, second)
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
    """A message that was counted before it could be taken is delivered with the next turn."""
    (subscription,) = host.node.served.values()
    host.spin(0.0)
    subscription.unannounced = 1
    while not subscription.delivered:
        host.spin(0.001)
    assert subscription.delivered == 1


def test_callbacks_that_wait_are_called_one_after_another(host: Any) -> None:
    """The executor's turn lasts while there are callbacks, but a flood of them ends it in time."""
    host._executor.pending = 3
    host.spin()
    assert (host._executor.pending, host._executor.turns) == (0, 4)
    host._executor.pending, host._next_turn = 10**9, 0.0
    host.spin()
    assert host._executor.pending > 0


@pytest.mark.parametrize("executor", ["events", "single"])
def test_events_without_a_callback_keep_no_service_waiting(host: Any, executor: str) -> None:
    """Messages that newer ones have pushed out, and guard conditions, are no end of a turn."""
    other = NodeHost(host.node, host.pipes, executor)
    own: Any = other._executor
    own.silent, own.pending, own.guards = 5, 3, executor == "single"
    other.spin()
    assert own.pending == 0


def test_without_a_message_the_executor_still_has_its_turn(host: Any) -> None:
    """A node whose subscriptions are silent serves its services."""
    host.spin()
    host._executor.pending = 1
    while host._executor.pending:
        host.spin(0.001)
    assert host.node.calls == 1
