"""A child process that is a ROS node: its environment, its pipes, and an end that leaves no orphan; no rclpy."""

import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from crane_sim.catalogue import config_folder
from crane_sim.orchestration.processes import Forked, Process

DOMAINS = range(1, 102)  # above 101 the ports of a domain meet those that the kernel hands out
_RERUN_SAYS = "warn,re_log_encoding::rrd::file_sink=error"  # not that a long recording has no footer: that is meant
_BIRTH = 0.5  # s in which a process that was just forked says so, or is ended with its nursery


@contextmanager
def reserved_domain(wanted: int | None = None) -> Iterator[int]:
    """Yield a ROS domain id: `wanted`, or one that nobody on this machine uses until the block ends.

    Raises:
        RuntimeError: all are taken; one line.
    """
    if wanted is not None:
        yield wanted
        return
    first = os.getpid() % len(DOMAINS)
    for domain in (*DOMAINS[first:], *DOMAINS[:first]):
        with closing(socket.socket(socket.AF_UNIX)) as mark:
            try:
                mark.bind(f"\0crane_sim domain {domain}")  # an abstract name: gone with this process, however it ends
            except OSError:
                continue
            if not _in_use(domain):
                yield domain
                return
    raise RuntimeError(f"no free ROS domain id between {DOMAINS[0]} and {DOMAINS[-1]}")


def _in_use(domain: int) -> bool:
    base = 7400 + 250 * domain  # discovery: the multicast port, then one unicast port per participant
    for port in (base, *range(base + 10, base + 20, 2)):
        with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
            try:
                probe.bind(("", port))
            except OSError:
                return True
    return False


def environment(domain: int, log_folder: Path) -> dict[str, str]:
    """Return the environment of a node in `domain`: Fast DDS over the loopback interface, this very package.

    Raises:
        RuntimeError: the environment names another profile of Fast DDS, and there is no such file; one line.
    """
    package_root = Path(__file__).parents[2]
    profile = os.path.abspath(os.environ.get("CRANE_SIM_DDS") or config_folder() / "fastdds_loopback.xml")
    if not os.path.isfile(profile):  # Fast DDS would silently speak on every interface
        raise RuntimeError(f"CRANE_SIM_DDS = {profile}: there is no such file")
    folder, name = os.path.split(profile)  # Fast DDS 3 drops a file of 2 as a whole, for one element's name
    newer = os.path.join(folder, name.replace("fastdds_", "fastdds3_", 1))
    path = os.environ.get("PYTHONPATH")
    ours = {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",  # LOCALHOST would override the profile's transports
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "FASTRTPS_DEFAULT_PROFILES_FILE": profile,  # Jazzy
        "FASTDDS_DEFAULT_PROFILES_FILE": newer if os.path.isfile(newer) else profile,  # Kilted and later
        "PYTHONPATH": os.pathsep.join([str(package_root), *([path] if path else [])]),
    }
    defaults = {"AMENT_PREFIX_PATH": sys.prefix, "ROS_LOG_DIR": str(log_folder), "RUST_LOG": _RERUN_SAYS}
    inherited = {key: value for key, value in os.environ.items() if key != "ROS_LOCALHOST_ONLY"}
    return defaults | inherited | ours


class Child:
    """One node as an OS process.

    Attributes:
        ready: it has matched its peers.
        summary: what it reported when it was done, None before.
        fault: one line on what went wrong, empty while nothing did.
        gone: it has ended.
        gave_up: it told the fault itself: another one like it would meet the same.
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
        self.active, self.ready, self.gone, self.gave_up = True, False, False, False
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
            self._depart()
            return
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            self._take(json.loads(line))

    def let_go(self) -> None:
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

    def await_birth(self) -> None:
        """Hear of the process of a child that was being forked when its end came."""
        while not (self.pid or self.gone) and select.select([self.reports], [], [], _BIRTH)[0]:
            self.read()

    def _take(self, event: dict[str, Any]) -> None:
        match event:
            case {"event": "born", "pid": int(pid)} if isinstance(self._process, Forked):
                self._process.born(pid)
            case {"event": "ended", "code": int(code)} if isinstance(self._process, Forked):
                self._process.ended(code)
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
                self.fault, self.gave_up = why, True
            case {"event": "failed", "why": str(why)}:
                self._cause = f": {why}"

    def _depart(self) -> None:
        self.gone = True
        code = self._process.wait()
        if code is None:
            ending = "ended, nobody knows how" if self.pid else "could not be started"
        else:
            ending = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        self.fault = self.fault or f"it {ending}{self._cause}"
