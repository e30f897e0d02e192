"""The life of a node that answers messages: it meets its peers, answers, and tells at the end what it has to tell."""

from collections.abc import Callable
from typing import Any, Protocol

from crane_sim.ros.common.node_host import Fault, NodeHost


class Responder(Protocol):
    """A node that answers.

    Attributes:
        fault: one line on why it cannot go on, empty while it can.
    """

    fault: str

    def activate(self, active: bool) -> None:
        """Answer from now on, or be silent."""
        ...

    def missing(self) -> str:
        """Return one line on the peers still missing, empty when all are there."""
        ...

    def heartbeat(self) -> None:
        """Publish diagnostics when they are due."""
        ...

    def finish(self) -> dict[str, Any]:
        """Return what the node adds to the run's summary."""
        ...


class ActivationBuffer:
    """Hands messages on while its node is active; of those that come before, only the newest, as soon as it is."""

    def __init__(self, take: Callable[[bytes], None]) -> None:
        """Be inactive; `take` is handed the serialized messages."""
        self._take, self._active, self._kept = take, False, b""

    def activate(self, active: bool) -> None:
        """Hand on from now on, beginning with what was kept, or keep."""
        self._active, kept = active, self._kept
        self._kept = b""
        if active and kept:
            self._take(kept)

    def hear(self, data: bytes) -> None:
        """Take a serialized message."""
        if self._active:
            self._take(data)
        else:
            self._kept = data


def serve_responder(host: NodeHost, node: Responder, autostart: bool) -> None:
    """Let a node answer until it is told to finish; raises Fault when it cannot go on.

    Without `autostart` it is a spare: matched and ready, but silent until it is activated.
    """

    def activate(active: bool) -> None:
        host.pipes.report("active", active=active)
        node.activate(active)

    host.manage(autostart, activate)
    host.wait(node.missing)
    host.pipes.report("ready")
    while not host.stopping:
        host.spin()
        node.heartbeat()
        if node.fault:
            raise Fault(node.fault)
    host.pipes.report("done", summary=node.finish())
