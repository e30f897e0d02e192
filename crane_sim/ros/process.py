"""What every node of the simulator shares: parameters, pipes to an orchestrator, signals and the spin loop."""

import json
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import rclpy
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import InvalidParameterValueException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import try_shutdown

_POLL = 0.05  # s between looks at the control pipe
_COMMON = {"control_fd": -1, "report_fd": -1}
_OF_ROS = {"use_sim_time", "start_type_description_service"}  # declared by rclpy itself


class Fault(RuntimeError):
    """A run cannot go on; the message is one line that names the culprit."""


class Pipes:
    """The two inherited pipe ends to an orchestrator; -1 where a user started the node by hand."""

    def __init__(self, control_fd: int, report_fd: int) -> None:
        """Take over both ends."""
        self.attached = control_fd >= 0
        self._control, self._report = control_fd, report_fd
        self._rest = b""

    def report(self, event: str, **fields: Any) -> None:
        """Send one event; an orchestrator that is gone is noticed by `orders`."""
        if self._report < 0:
            return
        line = memoryview((json.dumps({"event": event, **fields}) + "\n").encode())
        try:
            while line:
                line = line[os.write(self._report, line) :]
        except BrokenPipeError:
            self._report = -1

    def orders(self) -> list[str]:
        """Return the lines that have arrived since the last call; "orphaned" where the other end is closed."""
        if self._control < 0 or not select.select([self._control], [], [], 0)[0]:
            return []
        data = os.read(self._control, 65536)
        if not data:
            self._control = -1
            return ["orphaned"]
        *lines, self._rest = (self._rest + data).split(b"\n")
        return [line.decode() for line in lines]


class Host:
    """A node with its executor and pipes.

    Attributes:
        started: the orchestrator said "go", or there is none.
        stopping: why the node is to end ("interrupted", "orphaned", "finish …"), empty while it is not.
    """

    def __init__(self, node: Node, pipes: Pipes) -> None:
        """Serve `node`; from here on SIGINT and SIGTERM ask it to end."""
        self.node, self.pipes = node, pipes
        self.started = not pipes.attached
        self.stopping = ""
        self._executor = EventsExecutor()
        self._executor.add_node(node)
        self._next_poll = 0.0
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: self._stop("interrupted"))

    def spin(self, timeout: float = _POLL) -> None:
        """Serve callbacks for at most about `timeout` seconds, and look at the pipe now and then."""
        self._executor.spin_once(timeout_sec=timeout)  # never spin(): it does not return on a signal
        if (now := time.monotonic()) >= self._next_poll:
            self._next_poll = now + _POLL
            self.poll()

    def poll(self) -> None:
        """Take the orchestrator's orders."""
        for line in self.pipes.orders():
            if line == "go":
                self.started = True
            else:
                self._stop(line)

    def wait(self, obstacle: Callable[[], str]) -> None:
        """Spin until `obstacle` returns nothing, or the node is to stop; log what it waits for every 5 s."""
        next_log = time.monotonic() + 5.0
        while not self.stopping and (why := obstacle()):
            self.spin(0.005)
            if time.monotonic() >= next_log:
                next_log += 5.0
                self.node.get_logger().info(f"waiting for {why}")

    def close(self) -> None:
        """Release the node."""
        self._executor.shutdown()
        self.node.destroy_node()

    def _stop(self, why: str) -> None:
        self.stopping = self.stopping or why


def parameters(node: Node, defaults: Mapping[str, Any]) -> SimpleNamespace:
    """Declare `defaults` read-only and return the values in force.

    The node must have been created with `automatically_declare_parameters_from_overrides`.

    Raises:
        ValueError: a parameter is unknown or of another type than its default; one line.
    """
    given = _given(node)
    known = {**_COMMON, **defaults}
    if unknown := sorted(given.keys() - known.keys()):
        raise ValueError(f"unknown parameter {', '.join(unknown)}; this node has {', '.join(sorted(known))}")
    for name in given:
        node.undeclare_parameter(name)
    for name, default in known.items():
        known[name] = _converted(name, given.get(name, default), default)
        node.declare_parameter(name, known[name], ParameterDescriptor(read_only=True), ignore_override=True)
    return SimpleNamespace(**known)


def _given(node: Node) -> dict[str, Any]:
    names = [name for name in node.get_parameters_by_prefix("") if name not in _OF_ROS]
    return {parameter.name: parameter.value for parameter in node.get_parameters(names)}


def _converted(name: str, value: Any, default: Any) -> Any:
    if isinstance(default, float) and type(value) is int:
        return float(value)
    if type(value) is not type(default):
        raise ValueError(f"parameter {name} is {value!r}; it must be a {type(default).__name__}")
    return value


def main(name: str, defaults: Mapping[str, Any], body: Callable[[Host, SimpleNamespace], None]) -> int:
    """Run one node as a process of its own and return its exit code.

    The code is 0 after a complete run, 1 after a `Fault`, 2 for bad input (a ValueError); both errors go as one line
    to the orchestrator, or to the log where there is none.
    """
    rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node(name, automatically_declare_parameters_from_overrides=True)
    given = _given(node)
    control, report = (given.get(fd, default) for fd, default in _COMMON.items())
    host = Host(node, Pipes(control, report))
    try:
        body(host, parameters(node, defaults))
        return 0
    except (ValueError, InvalidParameterValueException, Fault) as error:
        if not host.pipes.attached:
            node.get_logger().fatal(str(error))
        host.pipes.report("fault", why=str(error))
        return 1 if isinstance(error, Fault) else 2
    finally:
        host.close()
        try_shutdown()
