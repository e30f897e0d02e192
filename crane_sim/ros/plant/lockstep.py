"""Lockstep: every step waits for the controller's answer.

Where commands are stamped with ROS time the clock leads: state k is published and acknowledged,
then /clock reads the time of state k + 1 less a lag, and the command with this time answers state
k. Nodes that use that time run in lockstep. A state that is sent again needs a later time: the
message of the first one may have been lost.

Before the run the clock stands one period earlier: ros2_control's loop waits for the first clock
message, then for a whole period, and only then begins. For a loop that is restarted during the run
the clock advances by periods while the state does not, until a command arrives, and stays ahead of
the states by these periods.
"""

import time
from math import inf
from types import SimpleNamespace

from sensor_msgs.msg import JointState

from crane_sim.ros.common.choices import CommandStamps
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.command_stamps import clock_lag, lockstep_range
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.acknowledgement import AcknowledgementMonitor
from crane_sim.ros.plant.command_arbiter import CommandArbiter, CommandLease, CommandTopic
from crane_sim.ros.plant.command_publishers import AcceptedCommands
from crane_sim.ros.plant.peers import ClockPeers
from crane_sim.ros.plant.scheduler import Scheduler
from crane_sim.ros.plant.simulation_run import SimulationRun

# s between two messages of the same state while the run waits, or there are several publishers
_RESEND = 0.05
# s between two messages of the same state while another crane on the same clock is behind
_RESEND_TO_PEERS = 0.5
_CHECK_PERIOD = 0.005  # s between two looks at what need not be done after every command
_ACKNOWLEDGEMENT = 0.001  # s of a wait for acknowledgements, in which no callbacks are served
# s for which a leading clock stands, published ten times a second, once all peers are connected
_STANDING = 0.35
_BLOCK = 4000  # steps between two waits for a recorder: under half the depth of the streams


class Lockstep(Scheduler):
    """Scheduler that publishes state k, waits for the command with its stamp, and steps.

    Wall time has no effect.
    """

    def __init__(
        self, host: NodeHost, simulation: SimulationRun, settings: SimpleNamespace
    ) -> None:
        """Subscribe to `joint_commands`."""
        super().__init__(host, simulation)
        self._settings, self._codec = settings, CommandCodec(simulation.scene)
        self._peers = ClockPeers(host, settings.beside)
        # that answers the present state, until the step is taken
        self._effort: tuple[float, ...] | None = None
        self._first_sent = self._last_sent = 0.0  # s, when the present state was published
        self._next_check = 0.0  # s, when progress is checked again
        self._runs = False  # a command that comes before or after the run moves nothing
        topics = {"joint_commands": CommandTopic(JointState, self._on_command)}
        lease = CommandLease(settings.command_lease, self._is_lease_suspended)
        self._commands = CommandArbiter(host, simulation, topics, lease, True, settings.commander)
        self._acknowledgements = AcknowledgementMonitor(settings.command_lease)
        self._lag = clock_lag(simulation.scene.period_ns)
        self._clock_leads, self._clock_due = settings.command_stamps == CommandStamps.ROS, False
        self._ahead = 0  # ns, by which the clock is ahead of its usual time
        self._ahead_before = 0  # ns, the same when the state was new
        by_state = settings.command_stamps == CommandStamps.STATE
        self._accepted = None if by_state else AcceptedCommands(host.node, self._codec)

    def commanding_nodes(self) -> set[str]:
        """See `Scheduler`."""
        return self._commands.publishing_nodes()

    def missing(self) -> str:
        """See `Scheduler`."""
        return self._commands.missing(self._settings.expected_controllers) or self._peers.missing()

    def run(self) -> None:
        """See `Scheduler`; a state without a valid answer is sent repeatedly, and nothing moves."""
        simulation, self._runs = self._simulation, True
        self._commands.start()
        if self._clock_leads:
            self._announce_clock()
        simulation.start()
        self._restart_clock()
        while self._goes_on:
            self._serve()
            self._step_if_possible()
            if (now := time.monotonic()) >= self._next_check:
                self._next_check = now + _CHECK_PERIOD
                self._check_progress(now)
        self._runs = False

    def in_sync(self) -> bool:
        """See `Scheduler`; sends the state again to a crane that is behind and may lack it."""
        behind = self._peers.behind(self._simulation.stamp)
        if behind and time.monotonic() - self._last_sent > _RESEND_TO_PEERS:
            self._resend()
        return not behind

    def step_once(self) -> str:
        """See `Scheduler`; waits briefly for the controller's answer, and for other cranes."""
        deadline = time.monotonic() + self._settings.step_timeout
        while obstacle := self._obstacle():
            if time.monotonic() > deadline:
                return obstacle
            if time.monotonic() - self._last_sent > _RESEND:
                # a subscriber may have been matched since
                self._resend()
            self._advance_clock_if_due()
            self._commands.update()
            if not (self._commands.take_one() or self._peers.take_one()):
                time.sleep(1e-4)
        self._step()
        return ""

    def resume(self) -> None:
        """See `Scheduler`."""
        self._first_sent = self._last_sent = time.monotonic()
        self._step_if_possible()

    def reset(self) -> None:
        """See `Scheduler`."""
        self._effort, self._ahead = None, 0
        self._restart_clock()

    def _on_command(self, data: bytes) -> bool:
        simulation = self._simulation
        self.commands_have_come = True
        if not simulation.stamp or not simulation.running:
            return False  # the answer to the final state moves nothing
        validator = simulation.validator
        ahead = self._ahead_before, self._ahead
        possible = lockstep_range(
            self._settings.command_stamps, simulation.stamp, simulation.scene.period_ns, ahead
        )
        command = validator.decode(self._codec.decode, data)
        effort = command and validator.validate(
            command.stamp, command.names, self._codec.values(command), possible
        )
        if effort is None:
            return False
        if self._accepted:
            self._accepted.publish(simulation.stamp, effort)
        if simulation.waiting:
            simulation.set_waiting("")
        self._effort = effort
        self._step_if_possible()
        return True

    def _serve(self) -> None:
        """Serve callbacks until a message has come; commands move the crane on the way."""
        if self._clock_due:
            self._host.spin(0.0)
            self._advance_clock_if_due()
        else:
            self._host.spin()

    def _check_progress(self, now: float) -> None:
        """Do at `now` [s] what is not needed after every command: reports and repeated states."""
        self._commands.update()
        self._simulation.heartbeat()
        if now - self._last_sent > self._resend_period():
            self._report_waiting()
            self._resend()

    def _step_if_possible(self) -> None:
        """Take the commanded step, unless paused or while a crane on the same clock is behind."""
        if (
            self._effort is not None
            and self._runs
            and not self._simulation.paused
            and not self._obstacle()
        ):
            self._step()

    def _obstacle(self) -> str:
        """Return why the present step cannot be taken, empty where it can."""
        if self._effort is None:
            return f"the command for state {self._simulation.plant.k + 1} has not come yet"
        behind = self._peers.names and self._peers.behind(self._simulation.stamp)
        return f"{behind}, on the same clock, is behind" if behind else ""

    def _step(self) -> None:
        if self._commands.contested:
            self._update_acknowledgements()
        effort, self._effort = self._effort, None
        self._simulation.step(effort)
        self._simulation.throttle_for_recorder(_BLOCK, self._should_stop)
        self._restart_clock()

    def _resend_period(self) -> float:
        """Return the time [s] after which the present state is sent again."""
        timeout = self._settings.step_timeout
        if self._effort is not None:  # a crane that is behind may have missed this one's state
            return inf if self._simulation.paused else _RESEND_TO_PEERS
        return (
            min(_RESEND, timeout)
            if self._simulation.waiting or self._commands.contested
            else timeout
        )

    def _report_waiting(self) -> None:
        """Report that no command came within the time-out; not in a pause, when none is needed."""
        simulation, settings = self._simulation, self._settings
        limit = settings.step_timeout * (settings.resends + 1)
        settled = self._effort is not None or simulation.waiting or simulation.paused
        if not settled and time.monotonic() - self._first_sent >= limit:
            refusal = simulation.validator.last_refusal or "none"
            state = simulation.plant.k + 1
            simulation.set_waiting(
                f"no valid command for state {state} within {limit:g} s; last refusal: {refusal}"
            )

    def _resend(self) -> None:
        self._simulation.publish_state()
        self._last_sent, self._clock_due = time.monotonic(), self._clock_leads
        self._lag = max(self._lag - 1, 0)
        if self._simulation.waiting and self._commands.has_newcomer:
            self._ahead += self._simulation.scene.period_ns

    def _restart_clock(self) -> None:
        """Begin to wait for the answer to a state that has just been published."""
        self._first_sent = self._last_sent = time.monotonic()
        self._ahead_before = self._ahead
        self._clock_due = self._clock_leads and self._simulation.running

    def _announce_clock(self) -> None:
        """Let every node that lives by the clock read it before it moves."""
        until = time.monotonic() + _STANDING
        while time.monotonic() < until and not self._host.stop_reason:
            self._host.spin(0.01)
            self._simulation.publish_clock_if_due()

    def _advance_clock_if_due(self) -> None:
        """Publish the time of the next state, if every subscriber has acknowledged this one."""
        if self._clock_due and self._simulation.all_acknowledged(_ACKNOWLEDGEMENT):
            self._clock_due = False
            ahead = self._simulation.scene.period_ns - self._lag + self._ahead
            self._simulation.advance_clock(self._simulation.stamp + ahead)

    def _is_lease_suspended(self) -> bool:
        """Return whether the owner has nothing to answer, or may be working on its answer."""
        self._update_acknowledgements()
        nothing_to_answer = self._simulation.paused or self._effort is not None
        return nothing_to_answer or self._acknowledgements.may_be_alive(self._first_sent)

    def _update_acknowledgements(self) -> None:
        self._acknowledgements.update(self._simulation.all_acknowledged(), time.monotonic())
