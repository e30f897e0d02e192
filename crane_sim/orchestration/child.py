"""A child process that is a ROS node: its environment, its pipes, and an end that leaves no orphan; no rclpy."""

import json
import os
import select
import signal
import subprocess
import time
from collections.abc import Callable
from typing import Any

from crane_sim.orchestration.process import ForkedProcess, Process

_START_TIMEOUT = 0.5  # s in which a process that was just forked says so, or is ended with its nursery


class Child:
    """One node as an OS process.

    Attributes:
        ready: it has matched its peers.
        summary: what it reported when it was done, None before.
        fault: one line on what went wrong, empty while nothing did.
        gone: it has ended.
        fatal: it told the fault itself: another one like it would meet the same.
        step: the last step it reported.
        recorded: steps that reached the disk, of a recorder.
        bagged: the last step whose messages reached it.
        active: it may work: nobody has deactivated it, or paused the plant.
        passes: resets of the plant that it has taken in, of a recorder.
        waiting: what it waits for in the middle of a run, empty while it waits for nothing.
    """

    def __init__(self, name: str, start: Callable[[int, int], Process]) -> None:
        """Let `start` make the process, given its ends of two pipes: for orders, for reports."""
        self.name, self.fault, self.waiting = name, "", ""
        self.active, self.ready, self.gone, self.fatal = True, False, False, False
        self.step = self.recorded = self.bagged = self.passes = 0
        self.summary: dict[str, Any] | None = None
        control, self._control = os.pipe()
        self.reports, report = os.pipe()
        self._process = start(control, report)
        os.close(control)
        os.close(report)
        self._rest, self._cause = b"", ""

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    def order(self, line: str) -> None:
        """Send one line to the node; one that is gone is noticed where its reports are read."""
        try:
            os.write(self._control, line.encode() + b"\n")
        except BrokenPipeError:
            return

    def read(self) -> None:
        """Take in what the node has reported."""
        data = os.read(self.reports, 65536)
        if not data:
            self._on_exit()
            return
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            self._take(json.loads(line))

    def close_control_pipe(self) -> None:
        """Close the pipe of its orders: the node sees it and shuts down."""
        os.close(self._control)

    def send_signal(self, number: int) -> None:
        """Send a signal to the process, if it lives."""
        self._process.send_signal(number)

    def ended_by(self, instant: float) -> bool:
        """Whether the process has ended; waits for that until an instant [s] of the monotonic clock."""
        try:
            self._process.wait(max(instant - time.monotonic(), 0.0))
        except subprocess.TimeoutExpired:
            return False
        return True

    def close(self) -> None:
        """Wait for the end of the process, and close the pipe of its reports."""
        self._process.wait()
        os.close(self.reports)

    def wait_started(self) -> None:
        """Hear of the process of a child that was being forked when its end came."""
        while not (self.pid or self.gone) and select.select([self.reports], [], [], _START_TIMEOUT)[0]:
            self.read()

    def _take(self, event: dict[str, Any]) -> None:
        match event:
            case {"event": "born", "pid": int(pid)} if isinstance(self._process, ForkedProcess):
                self._process.on_started(pid)
            case {"event": "ended", "code": int(code)} if isinstance(self._process, ForkedProcess):
                self._process.on_exit(code)
            case {"event": "ready"}:
                self.ready = True
            case {"event": "active", "active": bool(active)}:
                self.active = active
            case {"event": "progress", "step": int(step), **more}:
                self.step = step
                self.recorded, self.bagged, self.passes = (more.get(key, 0) for key in ("recorded", "bagged", "passes"))
            case {"event": "waiting", "why": str(why)}:
                self.waiting = why
            case {"event": "resumed"}:
                self.waiting = ""
            case {"event": "done", "summary": dict(summary)}:
                self.summary = summary
            case {"event": "fault", "why": str(why)}:
                self.fault, self.fatal = why, True
            case {"event": "failed", "why": str(why)}:
                self._cause = f": {why}"

    def _on_exit(self) -> None:
        self.gone = True
        code = self._process.wait()
        if code is None:
            ending = "ended, nobody knows how" if self.pid else "could not be started"
        else:
            ending = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        self.fault = self.fault or f"it {ending}{self._cause}"
