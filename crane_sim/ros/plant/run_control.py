"""What services do to the run: pause, steps, reset; each returns why it failed, "" for success."""

from functools import partial
from types import SimpleNamespace

from crane_sim.ros.common.choices import RunMode
from crane_sim.ros.common.node_host import QUIT, NodeHost
from crane_sim.ros.plant.scheduler import BLOCK, Scheduler, should_stop
from crane_sim.ros.plant.simulation_run import SimulationRun


class RunControl:
    """Control of a run by the services of the node `plant`.

    Attributes:
        USER: source of the pauses and brakes that services order.
    """

    USER = "user"

    def __init__(
        self,
        host: NodeHost,
        simulation: SimulationRun,
        scheduler: Scheduler,
        settings: SimpleNamespace,
    ) -> None:
        """Control a run; `settings` holds the current values of the node's parameters."""
        self._host, self._simulation, self._scheduler, self._settings = (
            host,
            simulation,
            scheduler,
            settings,
        )

    @property
    def paused(self) -> bool:
        """Whether the run is paused."""
        return self._simulation.paused

    @property
    def begun(self) -> bool:
        """Whether the run has begun."""
        return bool(self._simulation.stamp)

    @property
    def steps_in_all(self) -> int:
        """Steps since the start, those before resets included."""
        return self._simulation.steps_before_reset + self._simulation.plant.k

    def set_paused(self, paused: bool) -> str:
        """Begin or end the user's pause."""
        why_not = self.why_not_running()
        if not why_not and paused != self._simulation.paused:
            self._simulation.pause(paused, self.USER)
            if not paused:
                self._scheduler.resume()
        return why_not

    def take_steps(self, number: int) -> str:
        """Take that many steps of a paused run; the answer has the number if fewer were taken."""
        if why_not := self.why_not_running() or self._why_not_paused():
            return why_not
        simulation = self._simulation
        for done in range(number):
            if obstacle := self._take_step():
                return f"{done} of {number} steps: {obstacle}" if number > 1 else obstacle
            simulation.throttle_for_recorder(BLOCK, partial(should_stop, self._host))
            simulation.heartbeat()
        return simulation.failure

    def reset(self) -> str:
        """Return to the scene's start, or to the joints of two parameters.

        They are `reset_positions` and `reset_velocities`.
        """
        why_not = self.why_not_running()
        if not why_not:
            settings = self._settings
            try:
                self._simulation.restart(
                    settings.reset_positions or None, settings.reset_velocities or None
                )
                self._scheduler.reset()
            except ValueError as error:
                return str(error)
        return why_not

    def set_brakes(self, on: bool) -> str:
        """Apply the brakes of all actuated joints, or release them; no command releases them."""
        why_not = self.why_not_running()
        if not why_not and self._settings.mode != RunMode.REALTIME:
            why_not = "only in real time: in lockstep the controller decides about every step"
        if not why_not:
            self._simulation.brake(on, self.USER)
            self._simulation.warn("the brakes act, by ~/set_brakes" if on else "", "brakes")
        return why_not

    def quit(self) -> None:
        """End the run before its time, on purpose: no fault."""
        self._host.stop(QUIT)

    def why_waiting(self) -> str:
        """Return why nothing moves although the run is not paused, empty where it moves."""
        waiting = self._simulation.waiting
        return f"the simulation is not paused, it waits: {waiting}" if waiting else ""

    def why_not_running(self) -> str:
        """Return why the run cannot be controlled, empty where it can."""
        if not self._simulation.stamp:
            return "the run has not begun"
        if not self._host.active:
            return "the node is inactive"
        if self._simulation.ending:
            return f"the run is ending: {self._simulation.ending}"
        return "" if self._simulation.running else "the run is over"

    def _why_not_paused(self) -> str:
        return (
            "" if self._simulation.paused else self.why_waiting() or "the simulation is not paused"
        )

    def _take_step(self) -> str:
        if should_stop(self._host) or not self._simulation.running:
            return self._simulation.failure or "the run is over"
        return self._scheduler.step_once()
