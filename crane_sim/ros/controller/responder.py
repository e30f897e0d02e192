"""Nodes that publish commands or setpoints in answer to states: their life from matching with peers to the summary."""

import time
from collections import Counter
from collections.abc import Callable
from typing import Any, Protocol

from rclpy.publisher import Publisher

from crane_sim.ros.common.node_host import Fault, NodeHost
from crane_sim.ros.common.refused_messages import refused_entry
from crane_sim.ros.common.served_subscription import SourceSubscription

_CHECK_PERIOD = 0.02  # s between two turns of what need not be done after every message


class Responder(Protocol):
    """A node that publishes commands or setpoints in answer to the states of a plant.

    Attributes:
        fault: one line on why it cannot go on, empty while it can.
    """

    fault: str

    def set_active(self, active: bool) -> None:
        """Answer states from now on, or publish nothing."""
        ...

    def missing(self) -> str:
        """Return one line on the peers still missing, empty when all are matched."""
        ...

    def on_spin(self) -> None:
        """Do the periodic work, every 20 ms: publish diagnostics when they are due."""
        ...

    def refused(self) -> Counter[str]:
        """Return the numbers of messages refused, by topic and node."""
        ...

    def finish(self) -> dict[str, Any]:
        """Return the node's entries of the run's summary."""
        ...


class ActivationBuffer:
    """Buffers the newest message while inactive, delivers it on activation; later ones pass straight through."""

    def __init__(self, callback: Callable[[bytes], None]) -> None:
        """Create it inactive; `callback` is called with the serialized messages."""
        self._callback, self._active, self._newest = callback, False, b""

    def set_active(self, active: bool) -> None:
        """Deliver messages from now on, beginning with the buffered one, or only buffer the newest one."""
        self._active, newest = active, self._newest
        self._newest = b""
        if active and newest:
            self._callback(newest)

    def receive(self, data: bytes) -> None:
        """Deliver or buffer a serialized message."""
        if self._active:
            self._callback(data)
        else:
            self._newest = data


def missing_peers(states: SourceSubscription, output: Publisher, expected_recorders: int) -> str:
    """Return one line on a missing publisher of states, or missing subscribers of the output; empty for none."""
    if missing := states.missing():
        return missing
    number = 1 + expected_recorders - output.get_subscription_count()
    return f"{number} more subscriber(s) of {output.topic_name}" if number > 0 else ""


def serve_responder(host: NodeHost, node: Responder, autostart: bool) -> None:
    """Serve a node until the request to finish; raises Fault when it cannot go on.

    Without `autostart` it is a standby: matched and ready, but it publishes nothing until it is activated.
    """

    def set_active(active: bool) -> None:
        host.pipes.report("active", active=active)
        node.set_active(active)

    host.manage(autostart, set_active)
    host.wait(node.missing)
    host.report_ready()
    next_check = 0.0
    while not host.stop_reason:
        host.spin()
        if node.fault:
            raise Fault(node.fault)
        if (now := time.monotonic()) >= next_check:
            next_check = now + _CHECK_PERIOD
            node.on_spin()
            host.notify_refused(node.refused())
    host.pipes.report("done", summary=node.finish() | refused_entry(node.refused()))
