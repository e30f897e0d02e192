"""Child processes: programs of their own, or forks of a server that has loaded the compiled code already."""

import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol


class Process(Protocol):
    """The process of a child, however it was started."""

    @property
    def pid(self) -> int:
        """Process id."""
        ...

    def wait(self, timeout: float | None = None) -> int | None:
        """Return the exit code, negative for a signal, None where it is unknown.

        Raises:
            subprocess.TimeoutExpired: it has not exited within `timeout` seconds.
        """
        ...

    def send_signal(self, sig: int) -> None:
        """Send a signal to a process that may have exited."""
        ...


def start_program(module: str, arguments: Sequence[str], env: Mapping[str, str], fds: Sequence[int]) -> Process:
    """Start a module as a program that inherits file descriptors."""
    # A session of its own: Ctrl-C reaches the supervisor alone, which then shuts its children down in order.
    return subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        env=env,
        pass_fds=fds,
        start_new_session=True,
        stdin=subprocess.DEVNULL,
        stdout=2,
    )


class ForkedProcess:
    """The process of a node that the fork server starts."""

    def __init__(self) -> None:
        """Create it before its start is reported."""
        self.pid, self._handle = 0, -1
        self._code: int | None = None

    def on_started(self, pid: int) -> None:
        """Record its process id."""
        self.pid = pid
        with suppress(ProcessLookupError):  # it may have exited by now
            self._handle = os.pidfd_open(pid)

    def on_exit(self, code: int) -> None:
        """Record its exit code."""
        self._code = code

    def wait(self, timeout: float | None = None) -> int | None:
        """See `Process`."""
        if self._handle >= 0:
            if not select.select([self._handle], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(f"process {self.pid}", timeout or 0.0)
            os.close(self._handle)
            self._handle = -1
        return self._code

    def send_signal(self, sig: int) -> None:
        """See `Process`."""
        if self._handle >= 0:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._handle, sig)


class ForkServer:
    """The client of a process that has a scene's compiled code in memory and forks nodes, which need not load it."""

    def __init__(self, scene_file: Path, env: Mapping[str, str]) -> None:
        """Start the server; orders wait until it has loaded the code."""
        self._channel, server_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        arguments = [str(scene_file), str(server_end.fileno())]
        self._process = start_program("crane_sim.orchestration.fork_server", arguments, env, [server_end.fileno()])
        server_end.close()

    def spawn(self, module: str, arguments: Sequence[str], control: int, report: int) -> Process:
        """Order a fork with its ends of two pipes; an exited server is detected where the reports end."""
        with suppress(OSError):
            socket.send_fds(self._channel, [json.dumps([module, *arguments]).encode()], [control, report])
        return ForkedProcess()

    def close(self) -> None:
        """Kill the server; the nodes that it has forked go on."""
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        self._channel.close()
