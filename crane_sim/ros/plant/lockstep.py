"""Lockstep: every step waits for the controller's answer."""

import time
from functools import partial
from math import inf
from types import SimpleNamespace
from typing import Any

from sensor_msgs.msg import JointState

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.plant.acknowledgement import Acknowledgement
from crane_sim.ros.plant.command_arbiter import CommandArbiter
from crane_sim.ros.plant.peers import ClockPeers
from crane_sim.ros.plant.scheduler import should_stop
from crane_sim.ros.plant.simulation_run import SimulationRun

_AGAIN = 0.05  # s between two messages of the same state while nobody answers, or it is not clear who does
_COMPANY = 0.5  # s between two messages of the same state while another crane on the same clock is behind
_TURN = 0.005  # s between two looks at services while messages come through inboxes
_BLOCK = 4000  # steps between two waits for a recorder: under half the depth of the streams


class Lockstep:
    """Publishes state k, waits for the command with exactly its stamp, steps; wall time changes no number."""

    def __init__(self, host: NodeHost, stepper: SimulationRun, settings: SimpleNamespace) -> None:
        """Listen to `joint_commands`."""
        self._host, self._stepper, self._settings = host, stepper, settings
        self._wire = JointWire(stepper.scene.actuated, effort=True)
        self._called_away = partial(should_stop, host)
        self._companions = ClockPeers(host.node, settings.beside)
        self._answer: tuple[float, ...] | None = None  # to the present state, while something keeps it waiting
        self._since = self._sent = 0.0  # when the present state left for the first time, and the last
        takers = {"joint_commands": (JointState, self._on_command)}
        self._commands = CommandArbiter(host, stepper, takers, settings.command_lease, self._excused)
        self._acknowledgement = Acknowledgement(settings.command_lease)

    def missing(self) -> str:
        """See `StepScheduler`."""
        number = self._settings.expected_controllers - self._commands.count()
        return f"{number} more publisher(s) of {self._commands.topics}" if number > 0 else self._companions.missing()

    def run(self) -> None:
        """See `StepScheduler`; a state that stays without a valid answer is sent again and again, and nothing moves."""
        stepper = self._stepper
        self._commands.begin()
        stepper.begin()
        self._since = self._sent = time.monotonic()
        while stepper.running and not self._host.stopping and not self._host.brake:
            self._serve()
            self._proceed()
            stepper.heartbeat()
            if time.monotonic() - self._sent > self._patience():
                self._complain()
                self._repeat()

    def level(self) -> bool:
        """See `StepScheduler`; a crane that is behind may have missed this state, which is sent again now and then."""
        behind = self._companions.behind(self._stepper.stamp)
        if behind and time.monotonic() - self._sent > _COMPANY:
            self._repeat()
        return not behind

    def step_once(self) -> str:
        """See `StepScheduler`; waits briefly for the controller's answer to the present state, and for other cranes."""
        deadline = time.monotonic() + self._settings.step_timeout
        while obstacle := self._obstacle():
            if time.monotonic() > deadline:
                return obstacle
            if time.monotonic() - self._sent > _AGAIN:  # whoever should answer may have come since
                self._repeat()
            self._commands.look()
            if not (self._commands.fetch() or self._companions.fetch()):
                time.sleep(1e-4)
        self._step()
        return ""

    def go_on(self) -> None:
        """See `StepScheduler`."""
        self._since = self._sent = time.monotonic()
        self._proceed()

    def forget(self) -> None:
        """See `StepScheduler`."""
        self._answer = None
        self._since = self._sent = time.monotonic()

    def figures(self) -> dict[str, Any]:
        """See `StepScheduler`; nothing is due at any time."""
        return {}

    def _on_command(self, data: bytes) -> bool:
        stepper = self._stepper
        if not stepper.stamp or not stepper.running:
            return False  # the answer to the final state moves nothing
        gate, now = stepper.gate, stepper.stamp
        command = gate.decode(self._wire.decode, data)
        effort = command and gate.validate(command.stamp, command.names, command.effort, now=now, oldest=now)
        if effort is None:
            return False
        if stepper.waiting:
            stepper.wait("")
        self._answer = effort
        self._proceed()
        return True

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
        if not self._stepper.paused and not self._obstacle():
            self._step()

    def _obstacle(self) -> str:
        """Return why the present step cannot be taken, empty where it can."""
        if self._answer is None:
            return f"the command for state {self._stepper.plant.k + 1} has not come yet"
        behind = self._companions.behind(self._stepper.stamp)
        return f"{behind}, on the same clock, is behind" if behind else ""

    def _step(self) -> None:
        if self._commands.several:
            self._note_acknowledgement()
        effort, self._answer = self._answer, None
        self._stepper.step(effort)
        self._stepper.throttle_for_recorder(_BLOCK, self._called_away)
        self._since = self._sent = time.monotonic()

    def _patience(self) -> float:
        """Return the time [s] until the present state is sent again."""
        timeout = self._settings.step_timeout
        if self._answer is not None:
            return inf if self._stepper.paused else _COMPANY  # a crane that is behind may have missed this one's state
        return min(_AGAIN, timeout) if self._stepper.waiting or self._commands.several else timeout

    def _complain(self) -> None:
        """Say that nobody answers, as soon as that has lasted; where somebody paused the run, nobody has to."""
        stepper, settings = self._stepper, self._settings
        limit = settings.step_timeout * (settings.resends + 1)
        settled = self._answer is not None or stepper.waiting or stepper.paused
        if not settled and time.monotonic() - self._since >= limit:
            refusal = stepper.gate.last_refusal or "none"
            state = stepper.plant.k + 1
            stepper.wait(f"no valid command for state {state} within {limit:g} s; last refusal: {refusal}")

    def _repeat(self) -> None:
        self._stepper.publish_state()
        self._sent = time.monotonic()

    def _excused(self) -> bool:
        """Return whether the commander has nothing to answer, or may be alive and at work on its answer."""
        self._note_acknowledgement()
        nothing = self._stepper.paused or self._answer is not None
        return nothing or self._acknowledgement.excuses(self._since)

    def _note_acknowledgement(self) -> None:
        self._acknowledgement.note(self._stepper.acknowledged, time.monotonic())
