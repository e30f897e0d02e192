"""The life of a node that answers messages: it meets its peers, answers, and tells at the end what it has to tell."""

from typing import Any, Protocol

from crane_sim.ros.process import Fault, Host


class Answering(Protocol):
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


def attend(host: Host, node: Answering, autostart: bool) -> None:
    """Let a node answer until it is told to finish; raises Fault when it cannot go on.

    Without `autostart` it is a spare: matched and ready, but silent until it is activated.
    """
    host.manage(autostart, node.activate)
    host.wait(node.missing)
    host.pipes.report("ready")
    while not host.stopping:
        host.spin()
        node.heartbeat()
        if node.fault:
            raise Fault(node.fault)
    host.pipes.report("done", summary=node.finish())
