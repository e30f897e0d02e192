"""The fork server: a program that loads the compiled code of a scene once, and then forks a node for each order.

It never imports ROS: the middleware is started in the forked process, which then has its threads.
"""

import json
import os
import selectors
import socket
import sys
import traceback
from importlib import import_module
from typing import NamedTuple

import numpy as np

from crane_sim import load_scene
from crane_sim.laws import fast_half
from crane_sim.process_signals import clear_parent_death_signal, set_parent_death_signal
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.metrics import derive


def preload(scene: Scene) -> None:
    """Load the compiled code of the scene's law and of its derived quantities, and packages that import slowly."""
    import_module("crane_sim.recording.layout")  # imports the parts of scipy that a recorder uses
    if scene.law is not None:
        fast_half(scene.law)(0.0, scene.initial_q, scene.initial_v)
        scene.law(0.0, scene.initial_q, scene.initial_v)
    effort = np.zeros((1, len(scene.actuated)))
    derive(scene, np.zeros(1), np.array([scene.initial_q]), np.array([scene.initial_v]), effort)


class _Node(NamedTuple):
    pid: int
    report: int  # its pipe of reports


class ForkedNodes:
    """The forked nodes, each with the pipe on which its exit is reported."""

    def __init__(self, channel: socket.socket) -> None:
        """Serve the orders of a channel."""
        self._channel = channel
        self._nodes: dict[int, _Node] = {}  # by the handle of the process
        self._selector = selectors.DefaultSelector()
        self._selector.register(channel, selectors.EVENT_READ)

    def serve(self) -> None:
        """Fork and reap until the supervisor has closed the channel."""
        while True:
            for key, _ in self._selector.select():
                if key.fd != self._channel.fileno():
                    self._reap(key.fd)
                elif not self._fork():
                    return

    def _fork(self) -> bool:
        order, fds, _, _ = socket.recv_fds(self._channel, 65536, 2)
        if not order:
            return False
        control, report = fds
        bind = set_parent_death_signal()
        pid = os.fork()
        if pid == 0:
            bind()  # until its id is reported, no other process could kill it
            _report_event(report, "started", pid=os.getpid())
            clear_parent_death_signal()
            self._close_inherited()
            os._exit(_run_node(json.loads(order), control, report))
        os.close(control)
        handle = os.pidfd_open(pid)
        self._nodes[handle] = _Node(pid, report)
        self._selector.register(handle, selectors.EVENT_READ)
        return True

    def _reap(self, handle: int) -> None:
        node = self._nodes.pop(handle)
        self._selector.unregister(handle)
        os.close(handle)
        _, status = os.waitpid(node.pid, 0)
        _report_event(node.report, "exited", code=os.waitstatus_to_exitcode(status))
        os.close(node.report)

    def _close_inherited(self) -> None:
        self._selector.close()
        self._channel.close()
        for handle, node in self._nodes.items():
            os.close(handle)
            os.close(node.report)


def _run_node(order: list[str], control: int, report: int) -> int:
    """Run a node in this process; return its exit code."""
    os.setsid()
    module, *arguments = order
    sys.argv = [module, *arguments, "-p", f"control_fd:={control}", "-p", f"report_fd:={report}"]
    try:
        return import_module(module).main()
    except BaseException:  # nothing may return into the fork server's own loop
        traceback.print_exc()
        return 1


def _report_event(report: int, event: str, **fields: int) -> None:
    try:
        os.write(report, (json.dumps({"event": event, **fields}) + "\n").encode())
    except BrokenPipeError:
        return


def main() -> int:
    """Run the program: its arguments are the scene and the channel's file descriptor."""
    scene, channel = sys.argv[1:]
    preload(load_scene(scene))
    ForkedNodes(socket.socket(fileno=int(channel))).serve()
    return 0


if __name__ == "__main__":
    sys.exit(main())
