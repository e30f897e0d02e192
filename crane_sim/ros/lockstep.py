"""Lockstep: every step waits for the controller's answer."""

import time
from types import SimpleNamespace
from typing import Any

from sensor_msgs.msg import JointState

from crane_sim.ros.commands import Commands
from crane_sim.ros.companions import Companions
from crane_sim.ros.process import Host
from crane_sim.ros.stepper import Stepper
from crane_sim.ros.wire import JointWire

_AGAIN = 0.05  # s between two messages of the same state while nobody answers, or it is not clear who does
_COMPANY = 0.5  # s between two messages of the same state while another crane on the same clock is behind
_TURN = 0.005  # s between two looks at services while messages come through inboxes
_BLOCK = 4000  # steps between two waits for a recorder, each up to 20 ms: under half the depth of the streams


class Lockstep:
    """Publishes state k, waits for the command with exactly its stamp, steps; wall time changes no number."""

    def __init__(self, host: Host, stepper: Stepper, settings: SimpleNamespace) -> None:
        """Listen to `joint_commands`."""
        self._host, self._stepper, self._settings = host, stepper, settings
        self._wire = JointWire(stepper.scene.actuated, effort=True)
        self._companions = Companions(host.node, settings.beside)
        self._answer: tuple[float, ...] | None = None  # to the present state, while something keeps it waiting
        self._sent, self._resends = 0.0, 0
        takers = {"joint_commands": (JointState, self._on_command)}
        self._commands = Commands(host, stepper, takers, settings.command_lease)

    def missing(self) -> str:
        """See `Pace`."""
        number = self._settings.expected_controllers - self._commands.count()
        return f"{number} more publisher(s) of {self._commands.topics}" if number > 0 else self._companions.missing()

    def run(self) -> None:
        """See `Pace`; a state that stays without a valid answer is sent again and again, and nothing moves."""
        stepper = self._stepper
        self._commands.begin()
        stepper.begin()
        self._sent = time.monotonic()
        while stepper.running and not self._host.stopping and not self._host.brake:
            self._serve()
            self._proceed()
            stepper.heartbeat()
            doubtful = stepper.waiting or self._commands.several
            patience = min(_AGAIN, self._settings.step_timeout) if doubtful else self._settings.step_timeout
            if time.monotonic() - self._sent > patience and self._answer is None:
                self._resend()
            elif self._answer is not None and not stepper.paused and time.monotonic() - self._sent > _COMPANY:
                stepper.publish_state()  # another crane is behind: it may have missed this one's state
                self._sent = time.monotonic()

    def step_once(self) -> bool:
        """See `Pace`; waits a little for the controller's answer to the present state."""
        deadline = time.monotonic() + self._settings.step_timeout
        while self._answer is None and time.monotonic() < deadline:
            if time.monotonic() - self._sent > _AGAIN:  # whoever should answer may have come since
                self._stepper.publish_state()
                self._sent = time.monotonic()
            if not self._commands.fetch():
                time.sleep(1e-4)
        if self._answer is None:
            return False
        self._step(self._answer)
        return True

    def go_on(self) -> None:
        """See `Pace`."""
        self._sent, self._resends = time.monotonic(), 0
        self._proceed()

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
        gate, now = stepper.gate, stepper.stamp
        command = gate.opened(self._wire.decode, data)
        effort = command and gate.screen(command.stamp, command.names, command.effort, now=now, oldest=now)
        if effort is None:
            return
        if stepper.waiting:
            stepper.wait("")
        self._answer = effort
        self._proceed()

    def _serve(self) -> None:
        """Serve everyone until something has come; commands move the crane on the way."""
        self._commands.look()
        if self._commands.several:
            self._commands.wait(_TURN)
            self._commands.poll()
            self._host.spin(0.0)
        else:
            self._host.spin()

    def _proceed(self) -> None:
        """Take the step whose command is at hand, unless the run is paused or a crane on the same clock is behind."""
        stepper = self._stepper
        if self._answer is not None and not stepper.paused and self._companions.level(stepper.stamp):
            self._step(self._answer)

    def _step(self, effort: tuple[float, ...]) -> None:
        self._answer = None
        self._stepper.step(effort)
        self._stepper.let_catch_up(_BLOCK)
        self._sent, self._resends = time.monotonic(), 0

    def _resend(self) -> None:
        stepper = self._stepper
        if self._resends == self._settings.resends and not stepper.waiting:
            waited = self._settings.step_timeout * (self._resends + 1)
            refusal = stepper.gate.last_refusal or "none"
            state = stepper.plant.k + 1
            stepper.wait(f"no valid command for state {state} within {waited:g} s; last refusal: {refusal}")
        self._resends += 1
        stepper.publish_state()
        self._sent = time.monotonic()
