"""The plant's services, with the semantics of simulation_interfaces 2.1, and services for the scene's faults."""

from functools import partial
from types import SimpleNamespace

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.scheduler import BLOCK, StepScheduler, should_stop
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.simulation.plant import Plant


class FaultServices:
    """Services `~/faults/NAME`: true begins a fault with the next period, false ends it; either overrides its schedule.

    A reset of the run clears the overrides.
    """

    def __init__(self, node: Node, plant: Plant) -> None:
        """Offer the services."""
        self._plant = plant
        for name in plant.faults:
            node.create_service(SetBool, f"~/faults/{name}", partial(self._set_fault, name))

    def _set_fault(self, name: str, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._plant.set_fault(name, request.data)
        response.success = True
        response.message = f"{name} is {'on' if request.data else 'off'} from t = {self._plant.t:g} s on"
        return response


class PlantServices:
    """Services `~/set_pause`, `~/step_simulation` and `~/reset_simulation`.

    The parameters `step_count`, `reset_positions` and `reset_velocities` fix the number of steps and the state after a
    reset.
    """

    def __init__(
        self, host: NodeHost, simulation: SimulationRun, scheduler: StepScheduler, settings: SimpleNamespace
    ) -> None:
        """Offer the services; `settings` holds the current values of the node's parameters."""
        self._host, self._simulation, self._scheduler, self._settings = host, simulation, scheduler, settings
        node = host.node
        node.create_service(SetBool, "~/set_pause", self._set_pause)
        node.create_service(Trigger, "~/step_simulation", self._step)
        node.create_service(Trigger, "~/reset_simulation", self._reset)

    def _set_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = self._why_not_running()
        response.success = not response.message
        if response.success and request.data != self._simulation.paused:
            self._simulation.pause(request.data, "user")
            if not request.data:
                self._scheduler.resume()
        if response.success and not self._simulation.paused:
            response.message = self._why_waiting()  # the pause is over, and yet nothing moves
        return response

    def _step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._why_not_running() or self._why_not_paused()
        if not response.message:
            response.message = self._take_steps(self._settings.step_count)
        response.success = not response.message
        return response

    def _take_steps(self, number: int) -> str:
        """Take that many steps; return why fewer were taken, an empty string where none is missing."""
        simulation = self._simulation
        for done in range(number):
            if obstacle := self._take_step():
                return f"{done} of {number} steps: {obstacle}" if number > 1 else obstacle
            simulation.throttle_for_recorder(BLOCK, partial(should_stop, self._host))
            simulation.heartbeat()
        return simulation.failure

    def _take_step(self) -> str:
        """Take a step; return why it could not be taken, an empty string where it was."""
        if should_stop(self._host) or not self._simulation.running:
            return self._simulation.failure or "the run is over"
        return self._scheduler.step_once()

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._why_not_running()
        if not response.message:
            settings = self._settings
            try:
                self._simulation.restart(settings.reset_positions or None, settings.reset_velocities or None)
                self._scheduler.reset()
            except ValueError as error:
                response.message = str(error)
        response.success = not response.message
        return response

    def _why_not_paused(self) -> str:
        """Return why no single step can be taken, empty where the run is paused."""
        return "" if self._simulation.paused else self._why_waiting() or "the simulation is not paused"

    def _why_waiting(self) -> str:
        waiting = self._simulation.waiting
        return f"the simulation is not paused, it waits: {waiting}" if waiting else ""

    def _why_not_running(self) -> str:
        if not self._simulation.stamp:
            return "the run has not begun"
        if not self._host.active:
            return "the node is inactive"
        if self._simulation.ending:
            return f"the run is ending: {self._simulation.ending}"
        return "" if self._simulation.running else "the run is over"
