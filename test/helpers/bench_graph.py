"""Nodes as processes of their own, and a node of the test beside them in the ROS graph."""

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from process_helpers import LIMIT, end, wait_until
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt8
from std_srvs.srv import SetBool, Trigger

from crane_sim.orchestration.ros_environment import node_environment, reserve_domain
from crane_sim.process_signals import set_parent_death_signal

_JOIN_TIMEOUT = 10.0  # s for a thread of a test to end
JOINTS = ["slew", "boom", "jib", "rope"]
PERIOD = 10_000_000  # ns, of the default scene


class NodeProcess:
    """One of our nodes with pipes, as a supervisor starts it.

    Attributes:
        events: its reports.
    """

    def __init__(self, module: str, domain_env: dict[str, str], *arguments: str) -> None:
        """Start the module in the namespace of the default scene with `name:=value` parameters."""
        control, self._control = os.pipe()
        reports, report = os.pipe()
        parameters = [f"control_fd:={control}", f"report_fd:={report}", *arguments]
        command = [sys.executable, "-m", module, "--ros-args", "-r", "__ns:=/knuckle"]
        command += [part for parameter in parameters for part in ("-p", parameter)]
        self.process = subprocess.Popen(
            command,
            env=domain_env,
            pass_fds=(control, report),
            process_group=0,
            preexec_fn=set_parent_death_signal(),
        )
        os.close(control)
        os.close(report)
        self.events: list[dict[str, Any]] = []
        self._reader = threading.Thread(target=self._read, args=(reports,), daemon=True)
        self._reader.start()

    def send(self, line: str) -> None:
        """Send one request."""
        os.write(self._control, line.encode() + b"\n")

    def await_event(self, name: str) -> dict[str, Any]:
        """Wait for the first event of this name and return it; fails if the process exits."""
        events: list[dict[str, Any]] = []

        def has_come() -> bool:
            over = not self._reader.is_alive()
            events.extend(event for event in list(self.events) if event["event"] == name)
            assert events or not over, (
                f"{self.process.args} exited without {name}; it reported {self.events}"
            )
            return bool(events)

        wait_until(has_come, f"{name} of {self.process.args}")
        return events[0]

    def __enter__(self) -> Self:
        """Enter the block."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the control pipe, at which the process exits; kill it after 5 s."""
        os.close(self._control)
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(5.0)
        end(self.process)
        self._reader.join(_JOIN_TIMEOUT)

    def _read(self, reports: int) -> None:
        with os.fdopen(reports) as lines:
            self.events.extend(json.loads(line) for line in lines)


class Remote:
    """A node that commands, subscribes to and calls the plant; it spins in a thread of its own.

    Attributes:
        states, positions, velocities, efforts, modes, warnings: received in this order: stamps
        [ns], positions and
            velocities of joint states, applied efforts, values of simulation_state, and of the
            plant's diagnostics (time, message).
        answers: joint states are answered with these efforts, unless None.
    """

    def __init__(self, domain: int, name: str = "remote", **options: Any) -> None:
        """Join the crane's namespace."""
        self.context = Context()
        self.context.init(domain_id=domain)
        self.node = rclpy.create_node(name, namespace="knuckle", context=self.context, **options)
        self.states: list[int] = []
        self.positions: list[list[float]] = []
        self.velocities: list[list[float]] = []
        self.modes: list[int] = []
        self.warnings: list[tuple[float, str]] = []
        self.efforts: list[list[float]] = []
        self.answers: list[float] | None = None
        self._clients: dict[str, Any] = {}
        latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(
            UInt8, "simulation_state", lambda message: self.modes.append(message.data), latched
        )
        self.node.create_subscription(JointState, "joint_states", self._on_state, 1000)
        self.node.create_subscription(
            JointState,
            "applied_effort",
            lambda message: self.efforts.append(list(message.effort)),
            1000,
        )
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 100)
        self.commands = self.node.create_publisher(JointState, "joint_commands", 10)
        self._closing = False
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Destroy the node."""
        self._closing = True
        self._thread.join(_JOIN_TIMEOUT)
        assert not self._thread.is_alive(), (
            f"{self.node.get_name()} did not stop spinning within {_JOIN_TIMEOUT:g} s"
        )
        self.node.destroy_node()
        self.context.shutdown()

    def send(self, stamp: int, efforts: list[float]) -> None:
        """Send one command."""
        message = JointState(name=JOINTS, effort=efforts)
        message.header.stamp = Time(sec=stamp // 10**9, nanosec=stamp % 10**9)
        self.commands.publish(message)

    def pause(self, paused: bool) -> str:
        """Pause or resume; return the answer's message, "ok" where it succeeded."""
        return self.call(SetBool, "plant/set_pause", SetBool.Request(data=paused))

    def step(self) -> str:
        """Take as many steps as the parameter `step_count`."""
        return self.call(Trigger, "plant/step_simulation", Trigger.Request())

    def take_steps(self, number: int) -> None:
        """Let a paused run take steps, in several calls where a busy machine delays commands."""
        while number:
            assert self.set(step_count=number) == ""
            answer = self.step()
            assert answer == "ok" or "has not come yet" in answer, answer
            done, of, _ = answer.partition(" of ")
            number -= number if answer == "ok" else int(done) if of else 0

    def reset(self) -> str:
        """Return to the state of the parameters."""
        return self.call(Trigger, "plant/reset_simulation", Trigger.Request())

    def set(self, **values: int | list[float]) -> str:
        """Set parameters of the plant; return why not, an empty string where it is done."""
        parameters = [Parameter(name=name, value=_value(value)) for name, value in values.items()]
        request = SetParametersAtomically.Request(parameters=parameters)
        return self.request(
            SetParametersAtomically, "plant/set_parameters_atomically", request
        ).result.reason

    def call(self, kind: Any, name: str, request: Any) -> str:
        """Call a service; return the answer's message, "ok" where it succeeded."""
        answer = self.request(kind, name, request)
        return "ok" if answer.success else answer.message

    def request(self, kind: Any, name: str, request: Any) -> Any:
        """Call a service and return its answer; each service has one client, matched once."""
        client = self._clients.get(name) or self._clients.setdefault(
            name, self.node.create_client(kind, name)
        )
        assert client.wait_for_service(LIMIT), f"{name}: there is no such service"
        future = client.call_async(request)
        wait_until(future.done, f"the answer of {name}")
        return future.result()

    def _on_state(self, message: JointState) -> None:
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        self.positions.append(list(message.position))
        self.velocities.append(list(message.velocity))
        self.states.append(stamp)  # last: a test that waits for it reads the others then
        if self.answers is not None:
            self.send(stamp, self.answers)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.warnings += [
            (time.monotonic(), status.message)
            for status in message.status
            if "plant" in status.name
        ]

    def _spin(self) -> None:
        while not self._closing:
            self._executor.spin_once(timeout_sec=0.05)


@contextmanager
def graph(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield an unused domain and the environment of its nodes, which this process gets, too."""
    with reserve_domain() as domain:
        env = node_environment(domain, folder)
        for key, value in env.items():
            monkeypatch.setenv(key, value)
        yield domain, env


@contextmanager
def remote(domain: int, name: str = "remote", **options: Any) -> Iterator[Remote]:
    """Yield a node of this process."""
    node = Remote(domain, name, **options)
    try:
        yield node
    finally:
        node.close()


def _value(value: int | list[float]) -> ParameterValue:
    if isinstance(value, int):
        return ParameterValue(type=2, integer_value=value)
    return ParameterValue(type=8, double_array_value=value)
