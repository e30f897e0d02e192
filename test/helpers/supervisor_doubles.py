"""Processes and process groups without processes, for tests of roles and the supervisor."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from crane_sim.orchestration.supervisor import Callbacks


class FakeChild:
    """A child without a process.

    Attributes:
        requests: the lines sent to it.
    """

    def __init__(self, name: str, ready: bool = True) -> None:
        """Create it alive."""
        self.name, self.ready, self.fault, self.exited, self.fatal, self.active = (
            name,
            ready,
            "",
            False,
            False,
            True,
        )
        self.pid, self.step, self.recorded, self.last_bag_step, self.resets, self.waiting = (
            1,
            0,
            0,
            0,
            0,
            "",
        )
        self.lost_commands = 0
        self.summary: dict[str, Any] | None = None
        self.notices: list[str] = []
        self.requests: list[str] = []
        self.send = self.requests.append

    def exit(self, fault: str) -> None:
        """Exit with a fault."""
        self.fault, self.exited = fault, True


class FakeGroup:
    """A process group of such children, in which something happens whenever their reports are read.

    Attributes:
        settings: parameters of the nodes, in the order in which they were started.
    """

    def __init__(self, on_listen: Callable[[], object] = lambda: None) -> None:
        """Create an empty group."""
        self.children: list[Any] = []
        self.settings: list[Any] = []
        self.shutting_down, self.on_listen = False, on_listen

    def start(self, name: str, module: str, namespace: str, settings: Any) -> FakeChild:
        """Add a child."""
        self.children.append(FakeChild(name))
        self.settings.append(settings)
        return self.children[-1]

    fork = start

    def request_shutdown(self) -> None:
        """Record the request."""
        self.shutting_down = True

    def remove(self, child: FakeChild) -> None:
        """Remove a child."""
        self.children.remove(child)

    def find_stopped(self) -> dict[int, str]:
        """Return that no process is stopped."""
        return {}

    def listen(self, timeout: float) -> bool:
        """Let the next thing happen."""
        self.on_listen()
        return True


def role_of(child: FakeChild) -> Any:
    """Return a role with this active process."""
    return SimpleNamespace(name=child.name, active=child, failure="", standbys_ready=True)


def news_into(news: list[str]) -> Callbacks:
    """Return callbacks of a run that record its news."""
    return Callbacks(lambda step: None, news.append, lambda name, pid: None)
