"""How a child's process is started and ended: as a program of its own, or forked by a nursery that is warm already."""

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
    """What a child needs of its process."""

    @property
    def pid(self) -> int:
        """Process id."""
        ...

    def wait(self, timeout: float | None = None) -> int | None:
        """Return the exit code, negative for a signal, None where nobody knows it.

        Raises:
            subprocess.TimeoutExpired: it has not ended within so many seconds.
        """
        ...

    def send_signal(self, sig: int) -> None:
        """Send a signal to a process that may have ended."""
        ...


def start_program(module: str, arguments: Sequence[str], env: Mapping[str, str], fds: Sequence[int]) -> Process:
    """Start a module as a program that inherits file descriptors."""
    # A session of its own: Ctrl-C reaches the orchestrator alone, which then ends its children in order.
    return subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        env=env,
        pass_fds=fds,
        start_new_session=True,
        stdin=subprocess.DEVNULL,
        stdout=2,
    )


class ForkedProcess:
    """The process of a node that a nursery forks."""

    def __init__(self) -> None:
        """Begin unborn."""
        self.pid, self._handle = 0, -1
        self._code: int | None = None

    def on_started(self, pid: int) -> None:
        """Take note of its process id."""
        self.pid = pid
        with suppress(ProcessLookupError):  # it may have ended by now
            self._handle = os.pidfd_open(pid)

    def on_exit(self, code: int) -> None:
        """Take note of how it ended."""
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
    """A process that has a scene's compiled code in its memory, and forks nodes that need not load it again."""

    def __init__(self, scene_file: Path, env: Mapping[str, str]) -> None:
        """Start it; what it is asked for before it is warm waits."""
        self._channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        arguments = [str(scene_file), str(theirs.fileno())]
        self._process = start_program("crane_sim.orchestration.fork_server", arguments, env, [theirs.fileno()])
        theirs.close()

    def spawn(self, module: str, arguments: Sequence[str], control: int, report: int) -> Process:
        """Let it fork a node with its ends of two pipes; one that is gone is noticed where the reports end."""
        with suppress(OSError):
            socket.send_fds(self._channel, [json.dumps([module, *arguments]).encode()], [control, report])
        return ForkedProcess()

    def close(self) -> None:
        """End it; the nodes that it has forked live on."""
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        self._channel.close()
