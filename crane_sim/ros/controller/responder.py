"""Nodes that answer messages: matched with their peers, activated, and finished with a summary."""

from collections.abc import Callable
from typing import Any, Protocol

from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from crane_sim.ros.common.node_host import Fault, NodeHost


class Responder(Protocol):
    """A node that answers messages.

    Attributes:
        fault: one line on why it cannot go on, empty while it can.
    """

    fault: str

    def activate(self, active: bool) -> None:
        """Answer from now on, or be silent."""
        ...

    def missing(self) -> str:
        """Return one line on the peers still missing, empty when all are matched."""
        ...

    def heartbeat(self) -> None:
        """Publish diagnostics when they are due."""
        ...

    def finish(self) -> dict[str, Any]:
        """Return the node's entries of the run's summary."""
        ...


class ActivationBuffer:
    """Buffer of the newest message of an inactive node, which it gets when it is activated; later ones pass through."""

    def __init__(self, callback: Callable[[bytes], None]) -> None:
        """Create it inactive; `callback` is called with the serialized messages."""
        self._callback, self._active, self._newest = callback, False, b""

    def activate(self, active: bool) -> None:
        """Pass messages on from now on, beginning with the buffered one, or buffer them."""
        self._active, newest = active, self._newest
        self._newest = b""
        if active and newest:
            self._callback(newest)

    def receive(self, data: bytes) -> None:
        """Pass on or buffer a serialized message."""
        if self._active:
            self._callback(data)
        else:
            self._newest = data


def missing_peers(states: Subscription, answers: Publisher, expected_recorders: int) -> str:
    """Return one line on a missing publisher of the states, or missing subscribers of the answers; empty for none."""
    if not states.get_publisher_count():
        return f"a publisher of {states.topic_name}"
    number = 1 + expected_recorders - answers.get_subscription_count()
    return f"{number} more subscriber(s) of {answers.topic_name}" if number > 0 else ""


def serve_responder(host: NodeHost, node: Responder, autostart: bool) -> None:
    """Serve a node until the request to finish; raises Fault when it cannot go on.

    Without `autostart` it is a standby: matched and ready, but silent until it is activated.
    """

    def activate(active: bool) -> None:
        host.pipes.report("active", active=active)
        node.activate(active)

    host.manage(autostart, activate)
    host.wait(node.missing)
    host.pipes.report("ready")
    while not host.stop_reason:
        host.spin()
        node.heartbeat()
        if node.fault:
            raise Fault(node.fault)
    host.pipes.report("done", summary=node.finish())
