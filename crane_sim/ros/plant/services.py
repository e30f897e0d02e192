"""The plant's services, with the meanings of simulation_interfaces 2.1.

The plant's services `~/faults/NAME`, one for each fault of the scene: true lets it be there, false ends it.
"""

from functools import partial
from types import SimpleNamespace

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.scheduler import BLOCK, StepScheduler, should_stop
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.simulation.plant import Plant


class FaultServices:
    """Serves `~/faults/NAME`; what is ordered holds from the next period on, whatever the scene's times say."""

    def __init__(self, node: Node, plant: Plant) -> None:
        """Offer the services."""
        self._plant = plant
        for name in plant.faults:
            node.create_service(SetBool, f"~/faults/{name}", partial(self._order, name))

    def _order(self, name: str, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._plant.set_fault(name, request.data)
        response.success = True
        response.message = f"{name} is {'on' if request.data else 'off'} from t = {self._plant.t:g} s on"
        return response


class PlantServices:
    """Serves `~/set_pause`, `~/step_simulation` and `~/reset_simulation`.

    How many steps, and which state, are the parameters `step_count`, `reset_positions` and `reset_velocities`.
    """

    def __init__(self, host: NodeHost, stepper: SimulationRun, pace: StepScheduler, settings: SimpleNamespace) -> None:
        """Offer the services; `settings` follow the parameters."""
        self._host, self._stepper, self._pace, self._settings = host, stepper, pace, settings
        node = host.node
        node.create_service(SetBool, "~/set_pause", self._set_pause)
        node.create_service(Trigger, "~/step_simulation", self._step)
        node.create_service(Trigger, "~/reset_simulation", self._reset)

    def _set_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = self._idle()
        response.success = not response.message
        if response.success and request.data != self._stepper.paused:
            self._stepper.pause(request.data, "user")
            if not request.data:
                self._pace.go_on()
        if response.success and not self._stepper.paused:
            response.message = self._waits()  # what was asked for is done, and yet nothing moves
        return response

    def _step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._idle() or self._moving()
        if not response.message:
            response.message = self._steps(self._settings.step_count)
        response.success = not response.message
        return response

    def _steps(self, wanted: int) -> str:
        """Take steps; returns why it were fewer than wanted, empty where it were not."""
        stepper = self._stepper
        for taken in range(wanted):
            if obstacle := self._obstacle():
                return f"{taken} of {wanted} steps: {obstacle}" if wanted > 1 else obstacle
            stepper.throttle_for_recorder(BLOCK, partial(should_stop, self._host))
            stepper.heartbeat()
        return stepper.fault

    def _obstacle(self) -> str:
        """Take a step; returns why not, empty where it is done."""
        if should_stop(self._host) or not self._stepper.running:
            return self._stepper.fault or "the run is over"
        return self._pace.step_once()

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._idle()
        if not response.message:
            try:
                self._stepper.restart(self._settings.reset_positions or None, self._settings.reset_velocities or None)
                self._pace.forget()
            except ValueError as error:
                response.message = str(error)
        response.success = not response.message
        return response

    def _moving(self) -> str:
        """Return why no single step can be taken, empty where it is paused."""
        return "" if self._stepper.paused else self._waits() or "the simulation is not paused"

    def _waits(self) -> str:
        waiting = self._stepper.waiting
        return f"the simulation is not paused, it waits: {waiting}" if waiting else ""

    def _idle(self) -> str:
        if not self._stepper.stamp:
            return "the run has not begun"
        if not self._host.active:
            return "the node is inactive"
        if self._stepper.ending:
            return f"the run is ending: {self._stepper.ending}"
        return "" if self._stepper.running else "the run is over"
