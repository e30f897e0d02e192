"""The fork server as its client sees it, and whether a signal has stopped a process."""

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from crane_sim.process_signals import blocked_interrupts

_END_TIMEOUT = 0.2  # s for the fork server to reap and end; it takes milliseconds


def is_stopped(pid: int) -> bool:
    """Return whether a signal has stopped a process, which does nothing until SIGCONT."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except OSError:  # it has exited
        return False
    return status.rpartition(")")[2].split()[0] == "T"


class ForkServerClient:
    """The fork server's process, and the socket of the requests to it (see `fork_server`)."""

    def __init__(self, env: Mapping[str, str]) -> None:
        """Start the server; requests wait until it has imported the simulator."""
        self._channel, server_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        # A session of its own: Ctrl-C reaches the supervisor alone, which then shuts its children
        # down in order.
        with blocked_interrupts():  # until it ignores them
            self._process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "crane_sim.orchestration.fork_server",
                    str(server_end.fileno()),
                ],
                env=env,
                pass_fds=[server_end.fileno()],
                start_new_session=True,
                stdin=subprocess.DEVNULL,
                stdout=2,
            )
        server_end.close()

    def preload(self, scene_file: Path) -> None:
        """Request that a scene's compiled code is loaded, which later forks then need not do."""
        with suppress(OSError):
            self._channel.send(json.dumps(str(scene_file)).encode())

    @property
    def pid(self) -> int:
        """Process id of the server."""
        return self._process.pid

    def spawn(self, module: str, arguments: Sequence[str], control_fd: int, report_fd: int) -> None:
        """Request a fork that gets these ends of its pipes.

        An exited server is detected where the reports end.
        """
        with suppress(OSError):
            socket.send_fds(
                self._channel, [json.dumps([module, *arguments]).encode()], [control_fd, report_fd]
            )

    def kill(self) -> None:
        """Kill the server; the nodes that it has forked go on, and are no more its children."""
        self._process.send_signal(signal.SIGKILL)

    def close(self) -> None:
        """Have the server reap the nodes that have exited, and end."""
        self._channel.close()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_TIMEOUT)
            return
        self.kill()
        self._process.wait()
