"""One run of the node `plant`: steps, publications, counters; schedulers decide when it steps."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from crane_sim.description.transforms import payload_orientation
from crane_sim.ros.common.command_filter import CommandValidator
from crane_sim.ros.common.command_stamps import clock_lag
from crane_sim.ros.common.messages import SimulationState
from crane_sim.ros.common.node_host import Pipes
from crane_sim.ros.common.refused_messages import refused_entry
from crane_sim.ros.plant.command_publishers import HeldCommands
from crane_sim.ros.plant.state_publisher import StatePublisher
from crane_sim.ros.plant.topics import PlantTopics
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant, SimulationError
from crane_sim.tracing.compile_time import compile_time

_PROGRESS_PERIOD = 0.1  # s of wall time between two progress reports
_DIAGNOSTICS_PERIOD = 1.0  # s of wall time between two diagnostic messages


class SimulationRun:
    """A run: advances the plant, and publishes its states, clock, mode and diagnostics.

    Attributes:
        validator: of the run's commands.
        stamp: of the newest published state, ns; 0 before the run begins.
        waiting: why no step is taken although the run is not paused: no command arrives; one line,
            or empty.
        ending: why the run is on its way to its end, one line, or empty.
        failure: why the run cannot go on, one line, or empty.
        deadline_misses: real-time steps that came too late.
        steps_before_reset: taken before the last reset.
        remarks: further entries of the diagnostics.
        refused_messages: number of commands refused since another publisher owns the crane, by
            topic and node.
    """

    def __init__(
        self,
        scene: Scene,
        plant: Plant,
        topics: PlantTopics,
        pipes: Pipes,
        largest: Sequence[float],
        clock_leads: bool = False,
        further: Sequence[StatePublisher] = (),
        held_commands: HeldCommands | None = None,
        notify: Callable[[str], object] = lambda line: None,
    ) -> None:
        """Prepare a run; nothing is published yet.

        Args:
            scene, plant, topics, pipes: what runs, and where it is published and reported.
            largest: bounds (nu,) of efforts, N m or N.
            clock_leads: the scheduler publishes the clock, by `advance_clock`, before the state of
                that time.
            further: what is published of every state besides.
            held_commands: publisher of the command of each period, where they are published.
            notify: is called with a line for the terminal.
        """
        self.scene, self.plant, self._largest, self._clock_leads = (
            scene,
            plant,
            largest,
            clock_leads,
        )
        self._further, self.remarks, self._notify = further, dict[str, object](), notify
        self.refused_messages, self._refusals_described = Counter[str](), False
        self.validator = CommandValidator(scene.actuated, largest, scene.joint_names)
        self.stamp, self.deadline_misses, self.steps_before_reset = 0, 0, 0
        self.waiting = self.ending = self.failure = ""
        self._pauses: set[str] = set()  # by what ordered them
        self._brakes: set[str] = set()  # likewise
        self._held_commands, self._last_command = held_commands, scene.idle_command
        self._topics, self._pipes = topics, pipes
        self._warnings: dict[str, str] = {}
        self._start_time = self._end_time = 0.0
        self._next_progress = self._next_diagnostics = 0.0
        self._clock = scene.period_ns - (clock_lag(scene.period_ns) if clock_leads else 0)  # ns
        self._last_clock = 0  # ns, at the last call of `publish_clock_if_due`

    @property
    def finished(self) -> bool:
        """Whether the scene's last step is done."""
        return self.plant.k >= self.scene.steps

    @property
    def running(self) -> bool:
        """Whether there are steps still to take."""
        return not self.finished and not self.failure

    @property
    def paused(self) -> bool:
        """Whether the run is paused: commands and the wall clock move nothing."""
        return bool(self._pauses)

    def all_acknowledged(self, timeout: float = 0.0) -> bool:
        """See `PlantTopics`."""
        return self._topics.all_acknowledged(timeout)

    def pause(self, paused: bool, source: str) -> None:
        """Begin or end a source's pause, and publish the mode: any source pauses the run."""
        (self._pauses.add if paused else self._pauses.discard)(source)
        self._publish_mode()

    def brake(self, on: bool, source: str) -> None:
        """Apply or release a source's brakes, on all actuated joints while any applies them."""
        (self._brakes.add if on else self._brakes.discard)(source)
        self.plant.braking = bool(self._brakes)

    def resume(self) -> None:
        """End all pauses, and publish the mode."""
        self._pauses.clear()
        self._publish_mode()

    def set_waiting(self, why: str) -> None:
        """Publish and report that the run waits for a command, or with "" that it does not."""
        self.waiting = why
        self._publish_mode()
        self.warn(why, "commands")
        self._pipes.report("waiting" if why else "resumed", why=why)

    @property
    def warning(self) -> str:
        """The warnings of the diagnostics, one line, empty while there is none."""
        return "; ".join(filter(None, self._warnings.values()))

    def warn(self, line: str, subject: str) -> None:
        """Warn of a subject in the diagnostics, at once if new; an empty line ends the warning."""
        if line == self._warnings.get(subject, ""):
            return
        self._warnings[subject] = line
        self._publish_diagnostics(time.monotonic())

    def restart(self, q: Sequence[float] | None = None, v: Sequence[float] | None = None) -> None:
        """Return to the scene's initial state, or another, with new counters; see `Plant.reset`."""
        steps = self.plant.k
        self.plant.reset(q, v)
        self.steps_before_reset += steps
        self.plant.braking, self._last_command = bool(self._brakes), self.scene.idle_command
        self.validator = CommandValidator(
            self.scene.actuated, self._largest, self.scene.joint_names
        )
        self.deadline_misses = 0
        self.start()

    def start(self) -> None:
        """Publish the first state."""
        self._publish_mode()
        self._start_time = time.monotonic()
        self._update_subscribers()
        for publisher in self._further:
            publisher.update_subscribers()
        self.publish_state()
        self._publish_what_follows()

    def publish_state(self) -> None:
        """Publish the present state, for the first time or again."""
        plant = self.plant
        self.stamp = (plant.k + 1) * self.scene.period_ns
        self._topics.publish_state(self.stamp, *plant.seen, plant.applied)
        self._topics.publish_true_state(self.stamp, plant.q, plant.v, plant.applied)

    def step(self, effort: Sequence[float] | None) -> None:
        """Advance one period with `effort` (nu,) held.

        The state is published first: the controller waits for it.
        """
        stamp, command, braking = self.stamp, self._taken(effort), self.plant.braking
        try:
            self.plant.advance(command)
        except SimulationError as error:
            self.failure = str(error)
            return
        self.publish_state()
        if self._held_commands and command is not None:
            # before the effort, which completes a recorder's step
            self._held_commands.publish(stamp, command, braking)
        if self._topics.effort_subscribed:
            self._topics.publish_effort(stamp, self.plant.applied)
        self._publish_what_follows()

    def _taken(self, effort: Sequence[float] | None) -> Sequence[float] | None:
        """Return the command (nu,) of the drives: zero while brakes act, of positions the last.

        So a record of the commands and of the brakes determines the run.
        """
        if effort is None or not self.plant.braking:
            self._last_command = self._last_command if effort is None else tuple(effort)
            return effort
        return self.scene.zero_command(self._last_command)

    def throttle_for_recorder(self, block: int, should_stop: Callable[[], bool]) -> None:
        """Wait for a recorder every `block` steps, unless `should_stop`: queues are limited."""
        if self.plant.k % block == 0 and self._topics.effort_subscribed:
            self._topics.flush(should_stop)

    def heartbeat(self) -> None:
        """Report progress, publish diagnostics and the clock when they are due."""
        now = time.monotonic()
        if now < self._next_progress:
            return
        self.publish_clock_if_due()
        self._pipes.report("progress", step=self.plant.k)
        if now >= self._next_diagnostics:
            self._publish_diagnostics(now)
            self._describe_refusals(now)

    def _describe_refusals(self, now: float) -> None:
        """Say once, at the terminal, that not one command was accepted in the first second."""
        refusals = "" if self._refusals_described else self.validator.describe_refusals()
        if refusals and now - self._start_time >= _DIAGNOSTICS_PERIOD:
            self._refusals_described = True
            self._notify(refusals)

    def publish_clock_if_due(self) -> None:
        """Publish the clock ten times a second for new subscribers, before a run or in a pause.

        A subscriber of the states that joins during a pause gets the present one.
        """
        now = time.monotonic()
        if now < self._next_progress:
            return
        self._next_progress = now + _PROGRESS_PERIOD
        if self._update_subscribers() and self.paused and self.stamp:
            self.publish_state()
        stands = self._clock == self._last_clock or not self.stamp
        if stands:
            self._topics.publish_clock(self._clock)
        for publisher in self._further:
            if publisher.update_subscribers() and stands:  # it would wait for the next step
                publisher.publish(self.stamp or self.scene.period_ns, self.plant)
        self._last_clock = self._clock

    def _update_subscribers(self) -> bool:
        """Update which topics of every step have subscribers.

        Returns whether the joint states have more than before.
        """
        if self._held_commands:
            self._held_commands.update_subscribers()
        return self._topics.update_subscribers()

    def end(self) -> None:
        """Publish the end of the run, with zero effort where it ends early."""
        self._end_time = time.monotonic()
        self._topics.publish_simulation_state(SimulationState.QUITTING)
        if self.stamp and not self.finished:  # after QUITTING: it belongs to no step
            self._topics.publish_effort(self.stamp, (0.0,) * len(self.scene.actuated))
        self._topics.publish_simulation_state(SimulationState.STOPPED)

    def summary(self, mode: str) -> dict[str, Any]:
        """Return the run's summary, without the recorder's entries."""
        wall = self._end_time - self._start_time if self._start_time else 0.0
        steps = self.plant.k
        head = {
            "scene": self.scene.name,
            "law": self.scene.law_name,
            "mode": mode,
            "seed": self.scene.seed,
        }
        speed = {
            "wall_time": wall,
            "compile_time": compile_time(),
            "real_time_factor": steps * self.scene.period / wall if wall else 0.0,
            "steps_per_second": steps / wall if wall else 0.0,
            "deadline_misses": self.deadline_misses,
            "publish_us": self._topics.publishing.metrics(),
            "commands": self.validator.summary(),
        }
        refused = {str(reason): number for reason, number in self.validator.refused.items()}
        speed |= {"refused_commands": refused} if refused else {}
        return head | self.plant.summary() | speed | refused_entry(self.refused_messages)

    def advance_clock(self, stamp: int) -> None:
        """Publish the clock at `stamp` [ns]."""
        self._clock = stamp
        if self._clock_leads or self._topics.clock_subscribed:
            self._topics.publish_clock(stamp)

    def _publish_what_follows(self) -> None:
        """Publish what follows from a state that has just been published."""
        if not self._clock_leads:
            self.advance_clock(self.stamp)
        if self._topics.payload_subscribed:
            plant = self.plant
            orientation = payload_orientation(self.scene, plant.t, plant.q)
            self._topics.publish_payload(self.stamp, plant.payload, orientation)
        for publisher in self._further:
            publisher.publish(self.stamp, self.plant)

    def _publish_mode(self) -> None:
        stands = self.paused or self.waiting
        self._topics.publish_simulation_state(
            SimulationState.PAUSED if stands else SimulationState.PLAYING
        )
        self._pipes.report("active", active=not self.paused)

    def _publish_diagnostics(self, now: float) -> None:
        self._next_diagnostics = now + _DIAGNOSTICS_PERIOD
        self._topics.publish_diagnostics(self.stamp, self.warning, self._health(now))

    def _health(self, now: float) -> dict[str, object]:
        physics = self.plant.summary()
        return {
            "step": self.plant.k,
            "real_time_factor": self.plant.k
            * self.scene.period
            / max(now - self._start_time, 1e-9),
            "deadline_misses": self.deadline_misses,
            "saturated_steps": physics["saturated_steps"],
            "min_rope_tension": physics["min_rope_tension"],
            **{f"warning: {subject}": line for subject, line in self._warnings.items() if line},
            **{f"commands {name}": number for name, number in self.validator.summary().items()},
            **{f"refused: {reason}": number for reason, number in self.validator.refused.items()},
            **self.remarks,
        }
