"""Child processes that are ROS nodes: their environment, their pipes, and an end that leaves no orphan; no rclpy."""

import json
import os
import selectors
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from crane_sim.catalogue import config_folder

DOMAINS = range(1, 102)  # above 101 the ports of a domain meet those that the kernel hands out
_PATIENCE = (5.0, 2.0)  # s until SIGTERM, then until SIGKILL


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
    """Return the environment of a node in `domain`: Fast DDS over the loopback interface, this very package."""
    package_root = Path(__file__).parents[2]
    profile = str(config_folder() / "fastdds_loopback.xml")
    path = os.environ.get("PYTHONPATH")
    ours = {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",  # LOCALHOST would override the profile's transports
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "FASTRTPS_DEFAULT_PROFILES_FILE": profile,  # Jazzy
        "FASTDDS_DEFAULT_PROFILES_FILE": profile,  # Kilted
        "PYTHONPATH": os.pathsep.join([str(package_root), *([path] if path else [])]),
    }
    defaults = {"AMENT_PREFIX_PATH": sys.prefix, "ROS_LOG_DIR": str(log_folder)}
    inherited = {key: value for key, value in os.environ.items() if key != "ROS_LOCALHOST_ONLY"}
    return defaults | inherited | ours


class Child:
    """One node as an OS process.

    Attributes:
        ready: it has matched its peers.
        summary: what it reported when it was done, None before.
        fault: one line on what went wrong, empty while nothing did.
        gone: it has ended.
        step: the last step it reported.
    """

    def __init__(self, name: str, command: list[str], env: Mapping[str, str]) -> None:
        """Start `command` with its ends of the two pipes as node parameters."""
        self.name, self.ready, self.gone, self.fault, self.step = name, False, False, "", 0
        self.summary: dict[str, Any] | None = None
        control, self._control = os.pipe()
        self.reports, report = os.pipe()
        command = [*command, "-p", f"control_fd:={control}", "-p", f"report_fd:={report}"]
        # A session of its own: Ctrl-C reaches the orchestrator alone, which then ends its children in order.
        self._process = subprocess.Popen(
            command, env=env, pass_fds=(control, report), start_new_session=True, stdin=subprocess.DEVNULL, stdout=2
        )
        os.close(control)
        os.close(report)
        self._rest = b""

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

    def end(self) -> None:
        """Close the pipes and make sure that the process ends."""
        os.close(self._control)  # the node sees it and shuts down
        for patience, number in zip(_PATIENCE, (signal.SIGTERM, signal.SIGKILL), strict=True):
            try:
                self._process.wait(patience)
                break
            except subprocess.TimeoutExpired:
                self._process.send_signal(number)
        self._process.wait()
        os.close(self.reports)

    def _take(self, event: dict[str, Any]) -> None:
        match event:
            case {"event": "ready"}:
                self.ready = True
            case {"event": "progress", "step": int(step)}:
                self.step = step
            case {"event": "done", "summary": dict(summary)}:
                self.summary = summary
            case {"event": "fault", "why": str(why)}:
                self.fault = why

    def _depart(self) -> None:
        self.gone = True
        code = self._process.wait()
        ending = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        self.fault = self.fault or f"it {ending}"


class Crew:
    """The children of one run; leaving the block ends them all."""

    def __init__(self, env: Mapping[str, str]) -> None:
        """Start nobody yet; `env` is the environment of all."""
        self.children: list[Child] = []
        self._env = env
        self._selector = selectors.DefaultSelector()

    def __enter__(self) -> Self:
        """Enter the block."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """End every child."""
        for child in self.children:
            child.order("finish")
        for child in self.children:
            child.end()
        self._selector.close()

    def start(self, name: str, module: str, namespace: str, settings: Mapping[str, object]) -> Child:
        """Start the node of `module` in `namespace` with the given parameters."""
        command = [sys.executable, "-m", module, "--ros-args", "-r", f"__ns:=/{namespace}"]
        for key, value in settings.items():
            command += ["-p", f"{key}:={json.dumps(value)}"]
        child = Child(name, command, self._env)
        self.children.append(child)
        self._selector.register(child.reports, selectors.EVENT_READ, child)
        return child

    def listen(self, timeout: float) -> bool:
        """Read what the children report within `timeout` seconds; whether there was anything."""
        if not self._selector.get_map():
            time.sleep(timeout)
        heard = self._selector.select(timeout)
        for key, _ in heard:
            key.data.read()
            if key.data.gone:
                self._selector.unregister(key.fd)
        return bool(heard)
