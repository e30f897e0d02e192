"""The fork server: imports the simulator once, then forks a node of a run for each request.

It never imports ROS: the middleware is started in the forked process, which then has its threads.
It also loads the compiled code of a scene for standbys, processes that have to be ready at once
when they replace a node.
"""

import gc
import json
import os
import selectors
import socket
import sys
import traceback
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from crane_sim import load_scene
from crane_sim.laws import inner_loop_of
from crane_sim.process_signals import (
    clear_parent_death_signal,
    ignore_interrupts,
    set_parent_death_signal,
)
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import derive_instant

MODULES = ("crane_sim.simulation.plant", "crane_control", "crane_sim.recording.layout")
"""What the nodes import, ROS apart; the last one imports the parts of scipy that a recorder
uses."""


def preload(scene: Scene) -> None:
    """Load the compiled code of a scene's law, its inner loop if any, and derived quantities."""
    if scene.law is not None:
        inner_loop_of(scene.law)(0.0, scene.initial_q, scene.initial_v)
        scene.law(0.0, scene.initial_q, scene.initial_v)
    derive_instant(scene, 0.0, scene.initial_q, scene.initial_v)


class _Node(NamedTuple):
    pid: int
    report_fd: int  # of the pipe of its reports


class ForkServer:
    """Forks the requested nodes, and reports the exit of each on the pipe of its reports."""

    def __init__(self, channel: socket.socket) -> None:
        """Serve the requests of a channel."""
        self._channel = channel
        self._nodes: dict[int, _Node] = {}  # by the pidfd of the process
        self._selector = selectors.DefaultSelector()
        self._selector.register(channel, selectors.EVENT_READ)

    def serve(self) -> None:
        """Fork and reap until the supervisor has closed the channel."""
        channel_is_open = True
        while channel_is_open:
            for key, _ in self._selector.select():
                if key.fd != self._channel.fileno():
                    self._reap(key.fd)
                else:
                    channel_is_open = self._take_request()
        for key, _ in self._selector.select(0):
            if key.fd in self._nodes:
                self._reap(key.fd)

    def _take_request(self) -> bool:
        """Preload a scene, or fork a node; return False where the channel is closed."""
        data, fds, _, _ = socket.recv_fds(self._channel, 65536, 2)
        if not data:
            return False
        request = json.loads(data)
        if isinstance(request, str):
            preload(load_scene(request))
            gc.freeze()
        else:
            self._fork(request, *fds)
        return True

    def _fork(self, request: list[str], control_fd: int, report_fd: int) -> None:
        request_death_with_parent = set_parent_death_signal()
        pid = os.fork()
        if pid == 0:
            request_death_with_parent()  # until its id is reported, the supervisor cannot kill it
            _report_event(report_fd, "started", pid=os.getpid())
            clear_parent_death_signal()
            self._close_inherited()
            os._exit(run_node(request, control_fd, report_fd))
        os.close(control_fd)
        pidfd = os.pidfd_open(pid)
        self._nodes[pidfd] = _Node(pid, report_fd)
        self._selector.register(pidfd, selectors.EVENT_READ)

    def _reap(self, pidfd: int) -> None:
        node = self._nodes.pop(pidfd)
        self._selector.unregister(pidfd)
        os.close(pidfd)
        _, status = os.waitpid(node.pid, 0)
        _report_event(node.report_fd, "exited", code=os.waitstatus_to_exitcode(status))
        os.close(node.report_fd)

    def _close_inherited(self) -> None:
        self._selector.close()
        self._channel.close()
        for pidfd, node in self._nodes.items():
            os.close(pidfd)
            os.close(node.report_fd)


def run_node(request: list[str], control_fd: int, report_fd: int) -> int:
    """Run the node of a request (module, arguments) in this fork; return its exit code."""
    os.setsid()
    module, *arguments = request
    Path("/proc/self/comm").write_text(module.rpartition(".")[2])  # as `top` and `ps -e` show it
    sys.argv = [
        module,
        *arguments,
        "-p",
        f"control_fd:={control_fd}",
        "-p",
        f"report_fd:={report_fd}",
    ]
    try:
        return import_module(module).main()
    except BaseException:  # nothing may return into the fork server's own loop
        traceback.print_exc()
        return 1


def _report_event(report_fd: int, event: str, **fields: int) -> None:
    try:
        os.write(report_fd, (json.dumps({"event": event, **fields}) + "\n").encode())
    except BrokenPipeError:
        return


def main() -> int:
    """Run the program: its argument is the channel's file descriptor."""
    (channel,) = sys.argv[1:]
    ignore_interrupts()  # of itself and of each fork until that is a node: the supervisor ends both
    for module in MODULES:
        import_module(module)
    gc.freeze()  # a collection in a fork would copy all pages of what is imported
    ForkServer(socket.socket(fileno=int(channel))).serve()
    return 0


if __name__ == "__main__":
    sys.exit(main())
