"""The child processes of a run: started, supervised, and terminated at the end of the run."""

import json
import selectors
import signal
import time
from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Self

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process import ForkServerClient, is_stopped


class _GracePeriods(NamedTuple):
    until_terminate: float  # s from the request to finish to SIGTERM
    until_kill: float  # s from there to SIGKILL


_POLL = 0.1  # s between two checks whether a shutdown was requested
_GRACE = _GracePeriods(5.0, 2.0)
# once a shutdown is requested, after the results have been reported
_SHORT_GRACE = _GracePeriods(0.3, 0.2)
# s for a requested shutdown: 3 s are promised, and the program itself has to end, too
_SHUTDOWN_TIMEOUT = 2.4


class ProcessGroup:
    """The child processes of one run; at the end of the block all have exited.

    Attributes:
        children: those that have not been removed.
        deadline: instant of the monotonic clock [s] by which all have exited; inf until a shutdown
            is requested.
    """

    def __init__(self, env: Mapping[str, str], interrupts: Sequence[int] = ()) -> None:
        """Create an empty group.

        Args:
            env: environment of all children.
            interrupts: signals received so far, checked at each poll: any of them requests a
                shutdown.
        """
        self.children: list[Child] = []
        self.deadline = inf
        self._env, self._interrupts = env, interrupts
        self._selector = selectors.DefaultSelector()
        self._fork_server: ForkServerClient | None = None

    def __enter__(self) -> Self:
        """Enter the block."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End every child."""
        if self._fork_server and not all(child.pid for child in self.children):
            self._fork_server.kill()  # what it has not forked yet is not to be started
        for child in self.children:
            child.send("finish")
            child.close_control_pipe()
        for child in self.children:
            child.wait_for_start()
            if self.shutting_down and not child.ready:
                child.send_signal(signal.SIGKILL)
        self._terminate_all()
        if self._fork_server:
            self._fork_server.close()
        self._selector.close()

    def request_shutdown(self) -> None:
        """Set the deadline of the group, unless it is set."""
        self.deadline = min(self.deadline, time.monotonic() + _SHUTDOWN_TIMEOUT)

    @property
    def shutting_down(self) -> bool:
        """Whether a shutdown was requested."""
        if self._interrupts:
            self.request_shutdown()
        return self.deadline < inf

    @property
    def time_left(self) -> float:
        """Seconds until the processes' grace period begins; inf before a shutdown is requested."""
        return self.deadline - sum(_SHORT_GRACE) - time.monotonic() if self.shutting_down else inf

    def _terminate_all(self) -> None:
        """Send SIGTERM, then SIGKILL, each after its grace period, to all children together."""
        alive = self.children
        for stage, number in enumerate((signal.SIGTERM, signal.SIGKILL)):
            start = time.monotonic()
            while alive and time.monotonic() < (limit := self._grace_limit(start, stage)):
                instant = min(time.monotonic() + _POLL, limit)
                alive = [child for child in alive if not child.wait_for_exit(instant)]
            for child in alive:
                child.send_signal(number)
        for child in self.children:
            child.close()

    def _grace_limit(self, start: float, stage: int) -> float:
        """Return the end [s] of a stage's grace period from `start` [s]; a shutdown shortens it."""
        grace = _SHORT_GRACE if self.shutting_down else _GRACE
        return min(start + grace[stage], self.deadline - sum(grace[stage + 1 :]))

    def preload(self, scene_file: Path) -> None:
        """Have the fork server load the compiled code of a scene for nodes forked later."""
        self._start_fork_server().preload(scene_file)

    def start(
        self, name: str, module: str, namespace: str, settings: Mapping[str, object]
    ) -> Child:
        """Start the node of `module` by that `name` in `namespace`, with the given parameters."""
        server = self._start_fork_server()
        arguments = ["--ros-args", "-r", f"__ns:=/{namespace}", "-r", f"__node:={name}"]
        for key, value in settings.items():
            arguments += ["-p", f"{key}:={json.dumps(value)}"]
        child = Child(name, lambda *pipe_ends: server.spawn(module, arguments, *pipe_ends))
        self.children.append(child)
        self._selector.register(child.report_fd, selectors.EVENT_READ, child)
        return child

    def _start_fork_server(self) -> ForkServerClient:
        """Return the fork server, which is started with the first use."""
        self._fork_server = self._fork_server or ForkServerClient(self._env)
        return self._fork_server

    def remove(self, child: Child) -> None:
        """Remove a child that has exited."""
        self.children.remove(child)
        child.close_control_pipe()
        child.close()

    def find_stopped(self) -> dict[int, str]:
        """Return the names, by process id, of processes that a signal has stopped.

        The fork server is included.
        """
        processes = {child.pid: child.name for child in self.children if child.pid}
        if self._fork_server:
            processes[self._fork_server.pid] = "fork server"
        return {pid: name for pid, name in processes.items() if is_stopped(pid)}

    def listen(self, timeout: float) -> bool:
        """Read the children's reports within `timeout` seconds; return whether there were any."""
        if not self._selector.get_map():
            time.sleep(timeout)
        readable = self._selector.select(timeout)
        for key, _ in readable:
            key.data.read()
            if key.data.exited:
                self._selector.unregister(key.fd)
        return bool(readable)
