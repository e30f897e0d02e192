"""Real time: every step waits for its instant on the wall clock."""

import time
from types import SimpleNamespace
from typing import Any

from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from crane_sim.ros.common import messages
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.serialization import JointWire, decode_array
from crane_sim.ros.common.timing import StepTiming
from crane_sim.ros.plant.command_arbiter import CommandArbiter
from crane_sim.ros.plant.scheduler import should_stop
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.ros.plant.watchdog import COMMAND_TIMEOUT_ACTIONS, Watchdog

ACCEPTED = "accepted_command"  # each command that was not refused, with the stamp of the state that it answers
_ARRAYS = "effort_controller/commands"
_SERVED = 0.05  # s between two looks at who commands
_TURN = 0.001  # s between two looks into the inboxes, where there are some
_MARGIN = 0.0004  # s; spin_once comes back up to 0.3 ms late, a plain sleep does not
_MOST = 100  # messages taken before a single step: somebody who floods the topic does not hold it up
_NAP = 1e-4  # s between two looks for the answer to a single step


class Realtime:
    """Steps at absolute wall-clock deadlines with the newest valid command held."""

    def __init__(self, host: NodeHost, stepper: SimulationRun, settings: SimpleNamespace) -> None:
        """Listen to `joint_commands` and `effort_controller/commands`, if the scene takes commands at all."""
        self._host, self._stepper, self._settings = host, stepper, settings
        self._zero = (0.0,) * len(stepper.scene.actuated)
        self._held, self._answered = self._zero, False  # the newest command, and whether it came after the last step
        self._period = stepper.scene.period / settings.rate  # s of wall time
        self._watchdog = Watchdog(settings.command_timeout, self._period)
        self._silent, self._silences = False, 0
        self._punctuality = StepTiming()
        self._wire = JointWire(stepper.scene.actuated, effort=True)
        takers = {"joint_commands": (JointState, self._on_command), _ARRAYS: (Float64MultiArray, self._on_array)}
        sampled = stepper.scene.sampled
        lease = settings.command_lease
        self._commands = CommandArbiter(host, stepper, takers, lease, lambda: stepper.paused) if sampled else None
        self._accepted = host.node.create_publisher(JointState, ACCEPTED, messages.STREAM) if sampled else None

    def missing(self) -> str:
        """See `StepScheduler`."""
        number = self._settings.expected_controllers - self._commands.count() if self._commands else 0
        return f"{number} more publisher(s) of {self._commands.topics}" if self._commands and number > 0 else ""

    def run(self) -> None:
        """See `StepScheduler`; a late step is counted, and the next ones catch up with the schedule."""
        stepper, period = self._stepper, self._period
        if self._commands:
            self._commands.begin()
        stepper.begin()
        due = time.monotonic()
        self._watchdog.heard()
        while stepper.running and not self._host.stopping and not self._host.brake:
            due += period
            self._serve_until(due)
            if stepper.paused:
                self._host.spin()
                due = time.monotonic()
                self._punctuality.pause()
                self._watchdog.skip()
            else:
                self._punctuality.note(due, time.monotonic())
                self._step()
                stepper.deadline_misses += time.monotonic() > due + period
            stepper.heartbeat()

    def level(self) -> bool:
        """See `StepScheduler`; the wall clock waits for nobody."""
        return True

    def step_once(self) -> str:
        """See `StepScheduler`; the controller has a period for its answer, as in the run, and then the last one holds.

        What is waited for in vain counts as silence, as in the run; where `on_silence` acts, nobody is waited for.
        """
        if self._commands:
            self._watchdog.skip()
            self._await_answer(self._commands)
        self._step()
        return ""

    def go_on(self) -> None:
        """See `StepScheduler`; a pause ends no silence, and is none."""
        self._watchdog.skip()

    def forget(self) -> None:
        """See `StepScheduler`."""
        self._held, self._answered = self._zero, False
        self._watchdog.heard()
        self._note_silence(False)
        self._punctuality = StepTiming()

    def figures(self) -> dict[str, Any]:
        """See `StepScheduler`; how punctual the steps were, and how often nobody commanded."""
        return self._punctuality.figures() | {"silences": self._silences}

    def _serve_until(self, due: float) -> None:
        self._host.spin(0.0)
        turn = self._listen()
        while (left := due - time.monotonic()) > _MARGIN and not self._host.stopping:
            self._host.spin(min(left - _MARGIN, turn))
            turn = self._listen()
        if left > 0.0 and not self._host.stopping:
            time.sleep(left)

    def _listen(self) -> float:
        """Take what waits in inboxes; returns the time [s] until that is due again."""
        if self._commands is None:
            return _SERVED
        self._commands.look()
        if not self._commands.several:
            return _SERVED
        self._commands.poll()
        return _TURN

    def _await_answer(self, commands: CommandArbiter) -> None:
        """Take the commands that wait; where none has come since the last step, give the controller time for one."""
        deadline = time.monotonic() + self._period
        commands.look()
        for _ in range(_MOST):
            if not commands.fetch():
                break
        while not (self._answered or self._silent or time.monotonic() >= deadline or should_stop(self._host)):
            if not commands.fetch():
                time.sleep(_NAP)

    def _step(self) -> None:
        effort, self._answered = self._effort(), False
        self._stepper.step(effort)

    def _effort(self) -> tuple[float, ...] | None:
        if not self._commands:
            return None
        self._watchdog.count()
        self._note_silence(self._watchdog.silent)
        return self._zero if self._silent and self._settings.on_silence == "zero" else self._held

    def _note_silence(self, silent: bool) -> None:
        """Do and tell what follows where a silence begins or ends."""
        if silent == self._silent:
            return
        timeout, way = self._watchdog.timeout, self._settings.on_silence
        self._silent = silent
        self._silences += silent
        self._stepper.plant.braking = silent and way == "brake"
        self._stepper.warn(
            f"no valid command for {timeout:g} s: {COMMAND_TIMEOUT_ACTIONS[way]}" if silent else "", "commands"
        )

    def _on_command(self, data: bytes) -> bool:
        stepper = self._stepper
        command = stepper.gate.decode(self._wire.decode, data) if stepper.stamp and stepper.running else None
        if command is None:
            return False
        timeout = round(self._watchdog.timeout * self._settings.rate * messages.SECOND)  # in simulated time
        oldest = stepper.stamp - timeout if timeout else 0
        effort = stepper.gate.validate(command.stamp, command.names, command.effort, now=stepper.stamp, oldest=oldest)
        return self._hold(command.stamp, effort)

    def _on_array(self, data: bytes) -> bool:
        stepper = self._stepper
        efforts = stepper.gate.decode(decode_array, data) if stepper.stamp and stepper.running else None
        return efforts is not None and self._hold(stepper.stamp, stepper.gate.validate_array(efforts))

    def _hold(self, stamp: int, effort: tuple[float, ...] | None) -> bool:
        """Hold what the gate has accepted in answer to the state of a stamp [ns], and tell a recorder of it."""
        if effort is None:
            return False
        if self._accepted and self._accepted.get_subscription_count():
            self._accepted.publish(self._wire.encode(stamp, effort))
        self._held, self._answered = effort, True
        self._watchdog.heard()
        self._note_silence(False)
        return True
