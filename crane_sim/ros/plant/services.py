"""The plant's services of ordinary types, with the semantics of simulation_interfaces 2.1, and those for faults."""

from functools import partial
from types import SimpleNamespace

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from crane_sim.ros.plant.run_control import RunControl
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
    """Services `~/set_pause`, `~/set_brakes`, `~/step_simulation` and `~/reset_simulation`.

    The parameters `step_count`, `reset_positions` and `reset_velocities` fix the number of steps and the state after a
    reset.
    """

    def __init__(self, node: Node, control: RunControl, settings: SimpleNamespace) -> None:
        """Offer the services; `settings` holds the current values of the node's parameters."""
        self._control, self._settings = control, settings
        node.create_service(SetBool, "~/set_pause", self._set_pause)
        node.create_service(SetBool, "~/set_brakes", self._set_brakes)
        node.create_service(Trigger, "~/step_simulation", self._step)
        node.create_service(Trigger, "~/reset_simulation", self._reset)

    def _set_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = self._control.set_paused(request.data)
        response.success = not response.message
        if response.success and not self._control.paused:
            response.message = self._control.why_waiting()  # the pause is over, and yet nothing moves
        return response

    def _set_brakes(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = self._control.set_brakes(request.data)
        response.success = not response.message
        return response

    def _step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._control.take_steps(self._settings.step_count)
        response.success = not response.message
        return response

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._control.reset()
        response.success = not response.message
        return response
