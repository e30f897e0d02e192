"""A child process that is a ROS node: its control pipe, its reports, its exit; no rclpy."""

import json
import os
import select
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

# s for the report of a process that was just forked, unless it was killed with the fork server
_START_TIMEOUT = 0.5


class Child:
    """One node as an OS process.

    Attributes:
        ready: it has matched its peers.
        summary: its report at the end of its work, None before.
        fault: why it has failed, one line; empty while it has not.
        exited: whether the process has exited.
        fatal: it has reported bad input or a run that cannot go on (event "fault"): a restart would
            fail, too.
        step: the last step it reported.
        recorded: steps that reached the disk, of a recorder.
        lost_commands: how many of those lack their command.
        last_bag_step: the last step whose messages have reached the bag on the disk, of a recorder.
        report_fd: file descriptor of the pipe from which its reports are read.
        active: it is neither deactivated nor, as the plant, paused.
        resets: number of resets of the plant that it has recorded, of a recorder.
        waiting: what it waits for in the middle of a run, empty while it waits for nothing.
        notices: lines that it has said, until the supervisor passes them on.
        panel: what an operator's node shows, as it reported last.
        pid: process id, 0 before its start is reported.
    """

    def __init__(self, name: str, start: Callable[[int, int], object]) -> None:
        """Create it by `start(control_fd, report_fd)`: its pipe ends for requests and reports."""
        self.name, self.fault, self.waiting = name, "", ""
        self.active, self.ready, self.exited, self.fatal = True, False, False, False
        self.step = self.recorded = self.lost_commands = self.last_bag_step = self.resets = 0
        self.summary: dict[str, Any] | None = None
        self.panel: dict[str, Any] = {}
        self.notices: list[str] = []
        control_fd, self._control_fd = os.pipe()
        self.report_fd, node_report_fd = os.pipe()
        self.pid, self._pidfd = 0, -1
        self._code: int | None = None  # of its exit, negative for a signal; None: unknown
        start(control_fd, node_report_fd)
        os.close(control_fd)
        os.close(node_report_fd)
        self._incomplete_line, self._exception = b"", ""

    def send(self, line: str) -> None:
        """Send one request to the node; an exited one is detected where its reports are read."""
        try:
            os.write(self._control_fd, line.encode() + b"\n")
        except BrokenPipeError:
            return

    def read(self) -> None:
        """Read the reports that have arrived."""
        data = os.read(self.report_fd, 65536)
        if not data:
            self._on_exit()
            return
        *lines, self._incomplete_line = (self._incomplete_line + data).split(b"\n")
        for line in lines:
            self._handle_report(json.loads(line))

    def close_control_pipe(self) -> None:
        """Close the pipe of its requests: the node detects it and shuts down."""
        os.close(self._control_fd)

    def send_signal(self, number: int) -> None:
        """Send a signal to the process, if it is alive."""
        if self._pidfd >= 0:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._pidfd, number)

    def wait_for_exit(self, deadline: float) -> bool:
        """Wait for the exit until an instant [s] of the monotonic clock; return whether it came."""
        return self._wait(max(deadline - time.monotonic(), 0.0))

    def close(self) -> None:
        """Wait for the exit of the process, and close the pipe of its reports."""
        self._wait(None)
        os.close(self.report_fd)

    def _wait(self, timeout: float | None) -> bool:
        if self._pidfd >= 0:
            if not select.select([self._pidfd], [], [], timeout)[0]:
                return False
            os.close(self._pidfd)
            self._pidfd = -1
        return True

    def wait_for_start(self) -> None:
        """Wait for the report of its process id: it may be forked during the shutdown."""
        while (
            not (self.pid or self.exited)
            and select.select([self.report_fd], [], [], _START_TIMEOUT)[0]
        ):
            self.read()

    def _handle_report(self, event: dict[str, Any]) -> None:
        match event:
            case {"event": "started", "pid": int(pid)}:
                self._on_start(pid)
            case {"event": "exited", "code": int(code)}:
                self._code = code
            case {"event": "ready"}:
                self.ready = True
            case {"event": "active", "active": bool(active)}:
                self.active = active
            case {"event": "progress", "step": int(step), **more}:
                self._on_progress(step, more)
            case {"event": "waiting" | "resumed", "why": str(why)}:
                self.waiting = why
            case {"event": "notice", "line": str(line)}:
                self.notices.append(line)
            case {"event": "panel", **shown}:
                self.panel = shown
            case {"event": "done", "summary": dict(summary)}:
                self.summary = summary
            case {"event": "fault", "why": str(why)}:
                self.fault, self.fatal = why, True
            case {"event": "exception", "why": str(why)}:  # its exit follows, and is the fault
                self._exception = f": {why}"

    def _on_progress(self, step: int, more: dict[str, Any]) -> None:
        self.step = step
        self.recorded, self.resets = more.get("recorded", 0), more.get("resets", 0)
        self.last_bag_step = more.get("last_bag_step", 0)
        self.lost_commands = more.get("lost_commands", 0)

    def _on_start(self, pid: int) -> None:
        self.pid = pid
        with suppress(ProcessLookupError):  # it may have exited by now
            self._pidfd = os.pidfd_open(pid)

    def _on_exit(self) -> None:
        self.exited = True
        self._wait(None)
        code = self._code
        if code is None:
            ending = "ended, its exit code is unknown" if self.pid else "could not be started"
        else:
            ending = (
                f"was killed by {signal.Signals(-code).name}"
                if code < 0
                else f"ended with exit code {code}"
            )
        self.fault = self.fault or f"it {ending}{self._exception}"
