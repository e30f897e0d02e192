"""One simulation run as the node `plant` sees it: steps, publishes, keeps the books; knows nothing of pace."""

import time
from collections.abc import Callable, Sequence
from typing import Any

from crane_sim.ros.common import messages
from crane_sim.ros.common.command_filter import CommandValidator
from crane_sim.ros.common.node_host import Pipes
from crane_sim.ros.plant.topics import PlantTopics
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant, SimulationError

_PROGRESS = 0.1  # s of wall time between two progress reports
_DIAGNOSTICS = 1.0  # s of wall time between two diagnostic messages


class SimulationRun:
    """Advances the plant and tells everyone about it.

    Attributes:
        stamp: of the newest published state, ns; 0 before the run begins.
        waiting: why nothing moves although the run is not paused: nobody commands; one line, or empty.
        ending: why the run is on its way to its end, one line, or empty.
        fault: why the run cannot go on, one line, or empty.
        deadline_misses: real-time steps that came too late.
    """

    def __init__(self, scene: Scene, plant: Plant, topics: PlantTopics, pipes: Pipes, largest: Sequence[float]) -> None:
        """Prepare a run of `scene`, whose efforts are at most `largest` (nu,) [N m or N]; nothing is published yet."""
        self.scene, self.plant, self._largest = scene, plant, largest
        self.gate = CommandValidator(scene.actuated, largest)
        self.stamp, self.deadline_misses = 0, 0
        self.waiting = self.ending = self.fault = ""
        self._pauses: set[str] = set()  # whose they are
        self._topics, self._pipes = topics, pipes
        self._warnings: dict[str, str] = {}
        self._began = self._ended = 0.0
        self._next_progress = self._next_diagnostics = 0.0
        self._told = 0  # stamp of the clock's last message that came from here

    @property
    def finished(self) -> bool:
        """Whether the scene's last step is done."""
        return self.plant.k >= self.scene.steps

    @property
    def running(self) -> bool:
        """Whether there are steps still to take."""
        return not self.finished and not self.fault

    @property
    def paused(self) -> bool:
        """Whether commands and the wall clock move nothing for now."""
        return bool(self._pauses)

    @property
    def acknowledged(self) -> bool:
        """See `PlantTopics`."""
        return self._topics.acknowledged

    def pause(self, paused: bool, whose: str) -> None:
        """Begin or end the pause of somebody, and say what comes of it: the run stands while there is one."""
        (self._pauses.add if paused else self._pauses.discard)(whose)
        self._tell_mode()

    def go_on(self) -> None:
        """End all pauses, and say so."""
        self._pauses.clear()
        self._tell_mode()

    def wait(self, why: str) -> None:
        """Say at once that the run waits for somebody, or with an empty line that it does no more."""
        self.waiting = why
        self._tell_mode()
        self.warn(why, "commands")
        self._pipes.report("waiting" if why else "resumed", why=why)

    @property
    def warning(self) -> str:
        """What the diagnostics warn of, one line, empty while there is nothing."""
        return "; ".join(filter(None, self._warnings.values()))

    def warn(self, line: str, subject: str) -> None:
        """Warn of a subject in the diagnostics, at once where the line is new; an empty line ends the warning."""
        if line == self._warnings.get(subject, ""):
            return
        self._warnings[subject] = line
        self._tell(time.monotonic())

    def restart(self, q: Sequence[float] | None = None, v: Sequence[float] | None = None) -> None:
        """Return to the scene's initial state, or to another one, with new books; arguments as of `Plant.reset`."""
        self.plant.reset(q, v)
        self.gate = CommandValidator(self.scene.actuated, self._largest)
        self.deadline_misses = 0
        self.begin()

    def begin(self) -> None:
        """Publish the first state."""
        self._tell_mode()
        self._began = time.monotonic()
        self._topics.look_around()
        self.publish_state()
        self._publish_rest()

    def publish_state(self) -> None:
        """Publish the present state, for the first time or again."""
        plant = self.plant
        self.stamp = (plant.k + 1) * self.scene.period_ns
        self._topics.publish_state(self.stamp, *plant.seen)

    def step(self, effort: Sequence[float] | None) -> None:
        """Advance one period with `effort` (nu,) held; the state leaves first, so that the controller can go on."""
        stamp = self.stamp
        try:
            self.plant.advance(effort)
        except SimulationError as error:
            self.fault = str(error)
            return
        self.publish_state()
        if self._topics.effort_heard:
            self._topics.publish_effort(stamp, self.plant.applied)
        self._publish_rest()

    def throttle_for_recorder(self, block: int, given_up: Callable[[], bool]) -> None:
        """Wait for a recorder every `block` steps, unless that is `given_up`: writers keep only so many messages."""
        if self.plant.k % block == 0 and self._topics.effort_heard:
            self._topics.flush(given_up)

    def heartbeat(self) -> None:
        """Report progress, publish diagnostics and the clock when they are due."""
        now = time.monotonic()
        if now < self._next_progress:
            return
        self.publish_clock_if_due()
        self._pipes.report("progress", step=self.plant.k)
        if now >= self._next_diagnostics:
            self._tell(now)

    def publish_clock_if_due(self) -> None:
        """Publish the clock now and then, also before the run begins and while it stands: somebody may have come."""
        now = time.monotonic()
        if now < self._next_progress:
            return
        self._next_progress = now + _PROGRESS
        self._topics.look_around()
        stamp = (self.plant.k + 1) * self.scene.period_ns
        if stamp == self._told or not self.stamp:
            self._topics.publish_clock(stamp)
        self._told = stamp

    def end(self) -> None:
        """Say that the run is over, with zero effort where it ends early."""
        self._ended = time.monotonic()
        self._topics.publish_simulation_state(messages.QUITTING)
        if self.stamp and not self.finished:  # behind QUITTING: it belongs to no step
            self._topics.publish_effort(self.stamp, (0.0,) * len(self.scene.actuated))
        self._topics.publish_simulation_state(messages.STOPPED)

    def summary(self, mode: str) -> dict[str, Any]:
        """Return the run's summary, without what only the recorder knows."""
        wall = self._ended - self._began if self._began else 0.0
        steps = self.plant.k
        head = {"scene": self.scene.name, "law": self.scene.law_name, "mode": mode, "seed": self.scene.seed}
        speed = {
            "wall_time": wall,
            "real_time_factor": steps * self.scene.period / wall if wall else 0.0,
            "steps_per_second": steps / wall if wall else 0.0,
            "deadline_misses": self.deadline_misses,
            "publish_us": self._topics.publishing.figures(),
            "commands": self.gate.summary(),
        }
        return head | self.plant.summary() | speed

    def _publish_rest(self) -> None:
        if self._topics.clock_heard:
            self._topics.publish_clock(self.stamp)
        if self._topics.payload_heard:
            self._topics.publish_payload(self.stamp, self.plant.payload)

    def _tell_mode(self) -> None:
        standing = self.paused or self.waiting
        self._topics.publish_simulation_state(messages.PAUSED if standing else messages.PLAYING)
        self._pipes.report("active", active=not self.paused)

    def _tell(self, now: float) -> None:
        self._next_diagnostics = now + _DIAGNOSTICS
        self._topics.publish_diagnostics(self.stamp, self.warning, self._health(now))

    def _health(self, now: float) -> dict[str, object]:
        physics = self.plant.summary()
        return {
            "step": self.plant.k,
            "real_time_factor": self.plant.k * self.scene.period / max(now - self._began, 1e-9),
            "deadline_misses": self.deadline_misses,
            "saturated_steps": physics["saturated_steps"],
            "min_rope_tension": physics["min_rope_tension"],
            **{f"commands {name}": number for name, number in self.gate.summary().items()},
            **{f"refused: {reason}": number for reason, number in self.gate.refused.items()},
        }
