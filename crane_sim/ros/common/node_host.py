"""The host of a node: its parameters, pipes to a supervisor, signals and spin loop."""

import gc
import json
import os
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Sequence
from types import SimpleNamespace
from typing import Any

from crane_sim.files.installation import missing_package

try:
    import rclpy
except ModuleNotFoundError as error:  # of a process that is to be a node
    sys.exit(f"crane: {missing_package(str(error.name), 'a node')}")

from rclpy.exceptions import InvalidParameterValueException
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import try_shutdown

from crane_sim.process_signals import ignore_signals
from crane_sim.ros.common.nodes import MANAGED, ManagedNode, ServingNode
from crane_sim.ros.common.parameters import Option, common_parameters, declare_parameters
from crane_sim.ros.common.sender_subscription import MessageWithSender
from crane_sim.ros.common.served_subscription import ServedSubscription

RCLError: type[Exception] = rclpy_implementation.RCLError
QUIT = "quit"
"""Order that ends a run before its time, on purpose: no fault."""
_POLL = 0.05  # s between two reads of the control pipe
_TURN_PERIOD = 0.01  # s between two turns of the executor of a node with served subscriptions
_LONGEST_TURN = 0.005  # s, where services and other subscriptions have more to do than that
_IDLE = 1e-4  # s that a call of the executor waits: one that returns earlier had something to do
_MAX_NOTICES = 100  # lines: there may be thousands of publishers


class Fault(RuntimeError):
    """A run cannot go on; the message is one line that names the cause."""


class Pipes:
    """The two inherited pipe ends to a supervisor; -1 where a user started the node by hand.

    Attributes:
        attached: there is a supervisor.
    """

    def __init__(self, control_fd: int, report_fd: int) -> None:
        """Take over both ends."""
        self.attached = control_fd >= 0
        self._control_fd, self._report_fd = control_fd, report_fd
        self._incomplete_line = b""

    def report(self, event: str, **fields: Any) -> None:
        """Send one event; a supervisor that has exited is detected by `read_requests`."""
        if self._report_fd < 0:
            return
        line = memoryview((json.dumps({"event": event, **fields}) + "\n").encode())
        try:
            while line:
                line = line[os.write(self._report_fd, line) :]
        except BrokenPipeError:
            self._report_fd = -1

    def read_requests(self) -> list[str]:
        """Return the lines that came since the last call; "orphaned" if the other end is closed."""
        if self._control_fd < 0 or not select.select([self._control_fd], [], [], 0)[0]:
            return []
        data = os.read(self._control_fd, 65536)
        if not data:
            self._control_fd = -1
            return ["orphaned"]
        *lines, self._incomplete_line = (self._incomplete_line + data).split(b"\n")
        return [line.decode() for line in lines]


class NodeHost:
    """A node with its executor and pipes.

    Attributes:
        started: the supervisor has sent "go", or there is none.
        resume_state: the argument of that request.
        requests: further requests by their first word; each is called with the rest of the line.
        brake_reason: why there will be no more commands and the plant is to brake to rest, empty
            while it is not.
        stop_reason: why the node is to end ("interrupted", "orphaned", "finish …", "quit",
            "shutdown"), or empty.
    """

    def __init__(self, node: ServingNode, pipes: Pipes, executor: str = "events") -> None:
        """Serve `node` by the `executor` of that parameter; SIGINT and SIGTERM request its end."""
        self.node, self.pipes = node, pipes
        self.started = not pipes.attached
        self.resume_state = self.brake_reason = self.stop_reason = ""
        self._executor = SingleThreadedExecutor() if executor == "single" else EventsExecutor()
        # in a row, after which it has nothing to do
        self._idle_calls = 2 if executor == "single" else 1
        self._executor.add_node(node)
        self._next_poll = self._next_turn = 0.0
        self._notices = set[str]()
        self.requests: dict[str, Callable[[str], object]] = {}
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: self.stop("interrupted"))

    def manage(self, autostart: bool, on_change: Callable[[bool], None]) -> None:
        """Offer lifecycle transitions, see `ManagedNode.manage`; other nodes are always active."""
        if isinstance(self.node, ManagedNode):
            self.node.manage(autostart, on_change, self.stop)

    @property
    def active(self) -> bool:
        """Whether the node may work."""
        return self.node.active if isinstance(self.node, ManagedNode) else True

    def subscribe_with_sender(
        self,
        kind: Any,
        topic: str,
        callback: Callable[[Sequence[MessageWithSender]], object],
        qos: QoSProfile,
        on_incompatible: Callable[[Any], None] | None = None,
    ) -> ServedSubscription:
        """Return a subscription of the node; arguments: see `ServedSubscription`."""
        return ServedSubscription(self.node, kind, topic, callback, qos, on_incompatible)

    def report_ready(self) -> None:
        """Report that the node is ready for its run; exempt its objects from garbage collection.

        Its heap is large (messages, compiled code), and is needed to the end: each full collection
        would scan it, some milliseconds, several times a second.
        """
        gc.collect()
        gc.freeze()
        self.pipes.report("ready")

    def spin(self, timeout: float = _POLL) -> None:
        """Serve messages and callbacks for about `timeout` s; read the control pipe every 50 ms."""
        if self.node.served:
            self._serve_messages(min(timeout, _TURN_PERIOD))
        else:
            self._spin_executor(timeout)
        if (now := time.monotonic()) >= self._next_poll:
            self._next_poll = now + _POLL
            self.poll()

    def _serve_messages(self, timeout: float) -> None:
        """Deliver the messages of served subscriptions; spin the executor when that is due.

        A call of it takes 0.1 ms, also where it has nothing to do: as long as a step in lockstep.
        """
        # the epoll itself waits for whole milliseconds
        if select.select([self.node.arrivals], [], [], timeout)[0]:
            for file, _ in self.node.arrivals.poll(0):
                self.node.served[file].deliver()
        if (now := time.monotonic()) >= self._next_turn:
            self._next_turn = now + _TURN_PERIOD
            for subscription in self.node.served.values():
                subscription.deliver_rest()
            self._take_turn(now + _LONGEST_TURN)

    def _take_turn(self, end: float) -> None:
        """Let the executor work until it has nothing to do, or until `end` [s].

        A call may do something without a callback: events of messages that newer ones have pushed
        out, and, by the executor `single`, the guard condition behind each callback, after which
        its next call has something again.
        """
        idle = 0
        while idle < self._idle_calls and (began := time.monotonic()) < end:
            calls = self.node.calls
            self._spin_executor(_IDLE)
            is_idle = self.node.calls == calls and time.monotonic() - began >= _IDLE
            idle = idle + 1 if is_idle else 0

    def _spin_executor(self, timeout: float) -> None:
        try:
            # never spin(): it does not return on a signal
            self._executor.spin_once(timeout_sec=timeout)
        except RCLError as error:  # of a message or a request that the middleware cannot read
            self.node.get_logger().warning(str(error), throttle_duration_sec=1.0)

    def notify(self, line: str) -> None:
        """Say a line once, at the terminal of the supervisor, and in the log."""
        if line and line not in self._notices and len(self._notices) < _MAX_NOTICES:
            self._notices.add(line)
            self.pipes.report("notice", line=line)
            self.node.get_logger().warning(line)

    def notify_refused(self, refused: Iterable[str]) -> None:
        """Say once of each node that its messages are refused; `refused`: node names by topic."""
        for name in {each.partition(" of ")[2] for each in refused} - {""}:
            self.notify(f"messages of {name} on topics of the run's own nodes are refused")

    def poll(self) -> None:
        """Read and apply the supervisor's requests."""
        for line in self.pipes.read_requests():
            word, _, argument = line.partition(" ")
            if word == "go":
                self._start(argument)
            elif word in self.requests:
                self.requests[word](argument)
            elif word == "brake":
                self.brake_reason = self.brake_reason or argument or "no controller is left"
            else:
                self.stop(line)

    def wait(
        self, missing: Callable[[], str], meanwhile: Callable[[], None] = lambda: None
    ) -> None:
        """Spin until `missing` returns nothing, or the node is to stop; log the wait every 5 s.

        `meanwhile` is called again and again, some milliseconds apart.
        """
        next_log = time.monotonic() + 5.0
        while not self.stop_reason and (what := missing()):
            self.spin(0.005)
            meanwhile()
            if time.monotonic() >= next_log:
                next_log += 5.0
                self.node.get_logger().info(f"waiting for {what}")

    def close(self) -> None:
        """Release the node."""
        self._executor.shutdown()
        self.node.destroy_node()

    def _start(self, resume_state: str) -> None:
        self.started, self.resume_state = True, resume_state
        if isinstance(self.node, ManagedNode):
            self.node.activate()

    def stop(self, reason: str) -> None:
        """Request the node's end; of several reasons the first counts."""
        self.stop_reason = self.stop_reason or reason


def _report_unforeseen(host: NodeHost, error: Exception) -> None:
    """Log an error; the supervisor names it where it reports the exit."""
    host.node.get_logger().fatal(traceback.format_exc())
    why = traceback.format_exception_only(error)[-1].splitlines()[0]
    host.pipes.report("exception", why=why)


def main(
    name: str,
    options: dict[str, Option],
    body: Callable[[NodeHost, SimpleNamespace], None],
    managed: bool = False,
) -> int:
    """Run one node as a process of its own and return its exit code.

    The code is 0 after a complete run, 1 after a `Fault`, 2 for bad input (a ValueError); both
    errors go as one line to the supervisor (event "fault": a restart would fail, too), or to the
    log where there is none. Of any other error the last line goes to the supervisor (event
    "exception": a standby may succeed), the traceback to the log.

    Args:
        name: of the node.
        options: its parameters.
        body: what it does from start to end, with the parameters' values.
        managed: it is a lifecycle node.
    """
    try:
        rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
        make_node = ManagedNode if managed else ServingNode
        node = make_node(name, automatically_declare_parameters_from_overrides=True)
    # arguments that ROS cannot parse, or an invalid name
    except (ValueError, RuntimeError) as error:
        print(f"{name}: {str(error).splitlines()[0]}", file=sys.stderr)
        return 2
    common = common_parameters(node)
    host = NodeHost(node, Pipes(common.control_fd, common.report_fd), common.executor)
    try:
        body(host, declare_parameters(node, options | MANAGED if managed else options))
        return 0
    except (ValueError, InvalidParameterValueException, Fault) as error:
        if not host.pipes.attached:
            node.get_logger().fatal(str(error))
        host.pipes.report("fault", why=str(error))
        return 1 if isinstance(error, Fault) else 2
    except Exception as error:
        _report_unforeseen(host, error)
        return 1
    finally:
        host.close()
        try_shutdown()
        ignore_signals()
