"""Lockstep: every step waits for the controller's answer."""

import time
from types import SimpleNamespace
from typing import Any

from sensor_msgs.msg import JointState

from crane_sim.ros import messages
from crane_sim.ros.process import Host
from crane_sim.ros.stepper import Stepper
from crane_sim.ros.wire import JointWire

_BLOCK = 4000  # steps between two waits for a recorder, each up to 20 ms: under half the depth of the streams


class Lockstep:
    """Publishes state k, waits for the command with exactly its stamp, steps; wall time changes no number."""

    def __init__(self, host: Host, stepper: Stepper, settings: SimpleNamespace) -> None:
        """Listen to `joint_commands`."""
        self._host, self._stepper, self._settings = host, stepper, settings
        self._wire = JointWire(stepper.scene.actuated, effort=True)
        self._answer: tuple[float, ...] | None = None  # to the present state, while the run is paused
        self._sent, self._resends = 0.0, 0
        self._commands = host.node.create_subscription(
            JointState, "joint_commands", self._on_command, messages.STREAM, raw=True
        )

    def missing(self) -> str:
        """See `Pace`."""
        number = self._settings.expected_controllers - self._commands.get_publisher_count()
        return f"{number} more publisher(s) of {self._commands.topic_name}" if number > 0 else ""

    def run(self) -> None:
        """See `Pace`; the run is at fault when a state stays without a valid answer."""
        self._stepper.begin()
        self._sent = time.monotonic()
        while self._stepper.running and not self._host.stopping:
            self._host.spin()
            self._stepper.heartbeat()
            if time.monotonic() - self._sent > self._settings.step_timeout and self._answer is None:
                self._resend()

    def step_once(self) -> bool:
        """See `Pace`; waits a little for the controller's answer to the present state."""
        deadline = time.monotonic() + self._settings.step_timeout
        while self._answer is None and time.monotonic() < deadline:
            self._fetch()
        if self._answer is None:
            return False
        self._step(self._answer)
        return True

    def go_on(self) -> None:
        """See `Pace`."""
        self._sent, self._resends = time.monotonic(), 0
        if self._answer is not None:
            self._step(self._answer)

    def forget(self) -> None:
        """See `Pace`."""
        self._answer = None
        self._sent, self._resends = time.monotonic(), 0

    def figures(self) -> dict[str, Any]:
        """See `Pace`; nothing is due at any time."""
        return {}

    def _on_command(self, data: bytes) -> None:
        stepper = self._stepper
        if not stepper.stamp or not stepper.running:
            return  # the answer to the final state moves nothing
        command = self._wire.decode(data)
        effort = stepper.gate.screen(
            command.stamp, command.names, command.effort, now=stepper.stamp, oldest=stepper.stamp
        )
        if effort is None:
            return
        if stepper.paused:
            self._answer = effort
        else:
            self._step(effort)

    def _fetch(self) -> None:
        """Take a command without the executor, which is busy with the service that asked for this step."""
        with self._commands.handle:
            taken = self._commands.handle.take_message(JointState, True)
        if taken:
            self._on_command(taken[0])
        else:
            time.sleep(1e-4)

    def _step(self, effort: tuple[float, ...]) -> None:
        self._answer = None
        self._stepper.step(effort)
        self._stepper.let_catch_up(_BLOCK)
        self._sent, self._resends = time.monotonic(), 0

    def _resend(self) -> None:
        if self._resends == self._settings.resends:
            waited = self._settings.step_timeout * (self._resends + 1)
            refusal = self._stepper.gate.last_refusal or "none"
            state = self._stepper.plant.k + 1
            self._stepper.fault = f"no valid command for state {state} within {waited:g} s; last refusal: {refusal}"
            return
        self._resends += 1
        self._stepper.publish_state()
        self._sent = time.monotonic()
