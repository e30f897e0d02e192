"""Real time: every step waits for its instant on the wall clock."""

import time
from types import SimpleNamespace
from typing import Any

from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from crane_sim.ros.common import messages
from crane_sim.ros.common.choices import (
    COMMAND_TIMEOUT_ACTIONS,
    CommandStamps,
    CommandTimeoutAction,
)
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.command_stamps import realtime_range
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.serialization import decode_array
from crane_sim.ros.common.timing import StepTiming, describe_violation, minimize_timer_slack
from crane_sim.ros.plant.command_arbiter import CommandArbiter, CommandLease, CommandTopic
from crane_sim.ros.plant.command_publishers import AcceptedCommands
from crane_sim.ros.plant.scheduler import Scheduler
from crane_sim.ros.plant.simulation_run import SimulationRun

_UPDATE_PERIOD = 0.05  # s between two updates of the publishers of commands
_MARGIN = 0.0004  # s; spin_once comes back up to 0.3 ms late, a plain sleep does not
_BATCH = 100  # messages taken before a single step: a flood on the topic does not hold it up
_STEP_POLL = 1e-4  # s between two polls for the answer to a single step


class Watchdog:
    """Timer of the wall time since the newest command, less the time that is skipped.

    Attributes:
        timeout: time without a command after which the watchdog expires, s; 0: never.
    """

    def __init__(self, timeout: float, wall_period: float) -> None:
        """Start with a time-out [s] of at least two periods of wall time [s].

        A slowed-down run publishes no faster.
        """
        self.timeout = max(timeout, 2.0 * wall_period) if timeout else 0.0
        self._elapsed, self._last_update = 0.0, time.monotonic()

    @property
    def expired(self) -> bool:
        """Whether the elapsed time is beyond the time-out."""
        return 0.0 < self.timeout < self._elapsed

    def reset(self) -> None:
        """Restart the time-out: a command has arrived, or a run begins."""
        self._elapsed, self._last_update = 0.0, time.monotonic()

    def update(self) -> None:
        """Add the time since the last reset, update or skip."""
        now = time.monotonic()
        self._elapsed, self._last_update = self._elapsed + now - self._last_update, now

    def skip(self) -> None:
        """Discard the time since then: the run was paused."""
        self._last_update = time.monotonic()


class Realtime(Scheduler):
    """Scheduler that steps at absolute wall-clock deadlines with the newest valid command held."""

    def __init__(
        self, host: NodeHost, simulation: SimulationRun, settings: SimpleNamespace
    ) -> None:
        """Subscribe to `joint_commands`, and to an array topic unless drives differ.

        A scene without commands has neither.
        """
        super().__init__(host, simulation)
        self._settings = settings
        self._idle = simulation.scene.idle_command
        # the newest command, and whether it came after the last step
        self._held, self._answered = self._idle, False
        self._period = simulation.scene.period / settings.rate  # s of wall time
        self._watchdog = Watchdog(settings.command_timeout, self._period)
        self._timed_out, self._command_timeouts = False, 0
        # all, and those without a new command before a time-out
        self._steps, self._unanswered_steps = 0, 0
        self._due = 0.0  # s of the monotonic clock, of the next step
        self._timing = StepTiming()
        self._codec = CommandCodec(simulation.scene)
        topics = {"joint_commands": CommandTopic(JointState, self._on_command)}
        if self._codec.kind:
            topics[f"{self._codec.kind}_controller/commands"] = CommandTopic(
                Float64MultiArray, self._on_array
            )
        sampled, lease = (
            simulation.scene.sampled,
            CommandLease(settings.command_lease, lambda: simulation.paused),
        )
        self._commands = CommandArbiter(host, simulation, topics, lease) if sampled else None
        self._accepted = AcceptedCommands(host.node, self._codec) if sampled else None

    def commanding_nodes(self) -> set[str]:
        """See `Scheduler`."""
        return self._commands.publishing_nodes() if self._commands else set()

    def missing(self) -> str:
        """See `Scheduler`."""
        return self._commands.missing(self._settings.expected_controllers) if self._commands else ""

    def run(self) -> None:
        """See `Scheduler`; a late step is counted, and the next ones catch up with the schedule."""
        simulation, period = self._simulation, self._period
        minimize_timer_slack()
        if self._commands:
            self._commands.start()
        simulation.start()
        self._due = time.monotonic()
        self._watchdog.reset()
        while self._goes_on:
            self._due += period
            self._serve_until_due()
            if simulation.paused:
                self._host.spin()
                self._due = time.monotonic()
                self._timing.pause()
                self._watchdog.skip()
            else:
                self._timing.note(self._due, time.monotonic())
                self._step()
                simulation.deadline_misses += time.monotonic() > self._due + period
            simulation.heartbeat()

    def step_once(self) -> str:
        """See `Scheduler`; the controller has a period to answer, then the last command holds.

        The wait for an answer counts towards the time-out, as in the run; after the time-out there
        is none.
        """
        if self._commands:
            self._watchdog.skip()
            self._wait_for_answer(self._commands)
        self._step()
        return ""

    def resume(self) -> None:
        """See `Scheduler`; the pause does not count, and the time-out goes on where it was."""
        self._watchdog.skip()

    def reset(self) -> None:
        """See `Scheduler`; the controller has a whole period to answer the first state."""
        self._held, self._answered = self._idle, False
        self._due = time.monotonic() + self._period
        self._watchdog.reset()
        self._set_timed_out(False)
        self._timing = StepTiming()
        self._steps = self._unanswered_steps = 0

    def metrics(self) -> dict[str, Any]:
        """See `Scheduler`; timing of steps, number of command time-outs, and what was late."""
        counts = {"silences": self._command_timeouts}
        if self._commands:
            counts["unanswered_steps"] = self._unanswered_steps
        # a node of the user's may be slower
        unanswered = 0 if self._settings.commanded else self._unanswered_steps
        violation = describe_violation(self._steps, self._simulation.deadline_misses, unanswered)
        return (
            self._timing.metrics()
            | counts
            | ({"real_time_violation": violation} if violation else {})
        )

    def _serve_until_due(self) -> None:
        self._host.spin(0.0)
        self._update_publishers()
        while (remaining := self._due - time.monotonic()) > _MARGIN and not self._host.stop_reason:
            self._host.spin(min(remaining - _MARGIN, _UPDATE_PERIOD))
            self._update_publishers()
        if remaining > 0.0 and not self._host.stop_reason:
            time.sleep(remaining)

    def _update_publishers(self) -> None:
        if self._commands:
            self._commands.update()

    def _wait_for_answer(self, commands: CommandArbiter) -> None:
        """Take pending commands; if none came since the last step, wait for one for a period."""
        deadline = time.monotonic() + self._period
        commands.update()
        for _ in range(_BATCH):
            if not commands.take_one():
                break
        while not (
            self._answered or self._timed_out or time.monotonic() >= deadline or self._should_stop()
        ):
            if not commands.take_one():
                time.sleep(_STEP_POLL)

    def _step(self) -> None:
        self._steps += 1
        excused = self._timed_out or self._simulation.plant.braking
        self._unanswered_steps += not (self._answered or excused)
        effort, self._answered = self._next_effort(), False
        self._simulation.step(effort)

    def _next_effort(self) -> tuple[float, ...] | None:
        if not self._commands:
            return None
        self._watchdog.update()
        self._set_timed_out(self._watchdog.expired)
        zero = self._timed_out and self._settings.on_silence == CommandTimeoutAction.ZERO
        return self._simulation.scene.zero_command(self._held) if zero else self._held

    def _set_timed_out(self, timed_out: bool) -> None:
        """Begin or end the action at a time-out of commands, with its warning."""
        if timed_out == self._timed_out:
            return
        timeout, action = self._watchdog.timeout, self._settings.on_silence
        self._timed_out = timed_out
        self._command_timeouts += timed_out
        self._simulation.brake(timed_out and action == CommandTimeoutAction.BRAKE, "time-out")
        self._simulation.warn(
            f"no valid command for {timeout:g} s: {COMMAND_TIMEOUT_ACTIONS[action]}"
            if timed_out
            else "",
            "commands",
        )

    def _on_command(self, data: bytes) -> bool:
        simulation = self._simulation
        validator, self.commands_have_come = simulation.validator, True
        command = (
            validator.decode(self._codec.decode, data)
            if simulation.stamp and simulation.running
            else None
        )
        if command is None:
            return False
        policy, now = self._settings.command_stamps, simulation.stamp
        real = self._watchdog.timeout * messages.NS_PER_S
        timeouts = round(real * self._settings.rate), round(real)
        possible = realtime_range(policy, command.stamp, now, time.time_ns(), timeouts)
        effort = validator.validate(
            command.stamp, command.names, self._codec.values(command), possible
        )
        return self._hold(command.stamp if policy == CommandStamps.STATE else now, effort)

    def _on_array(self, data: bytes) -> bool:
        simulation = self._simulation
        validator, self.commands_have_come = simulation.validator, True
        efforts = (
            validator.decode(decode_array, data)
            if simulation.stamp and simulation.running
            else None
        )
        return efforts is not None and self._hold(
            simulation.stamp, validator.validate_array(efforts)
        )

    def _hold(self, stamp: int, effort: tuple[float, ...] | None) -> bool:
        """Hold an accepted command that answers the state at a stamp [ns]; publish it."""
        if effort is None:
            return False
        if self._accepted:
            self._accepted.publish(stamp, effort)
        self._held, self._answered = effort, True
        self._watchdog.reset()
        self._set_timed_out(False)
        return True
