"""The plant's services, with the meanings of simulation_interfaces 2.1."""

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from crane_sim.ros.pacing import Pace
from crane_sim.ros.stepper import Stepper


class PlantServices:
    """Serves `~/set_pause`, `~/step_simulation` and `~/reset_simulation`."""

    def __init__(self, node: Node, stepper: Stepper, pace: Pace) -> None:
        """Offer the services."""
        self._stepper, self._pace = stepper, pace
        node.create_service(SetBool, "~/set_pause", self._set_pause)
        node.create_service(Trigger, "~/step_simulation", self._step)
        node.create_service(Trigger, "~/reset_simulation", self._reset)

    def _set_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = self._idle()
        response.success = not response.message
        if response.success and request.data != self._stepper.paused:
            self._stepper.pause(request.data)
            if not request.data:
                self._pace.go_on()
        return response

    def _step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._idle() or ("" if self._stepper.paused else "the simulation is not paused")
        if not response.message and not self._pace.step_once():
            response.message = f"the command for state {self._stepper.plant.k + 1} has not come yet"
        response.message = response.message or self._stepper.fault
        response.success = not response.message
        return response

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._idle()
        response.success = not response.message
        if response.success:
            self._pace.forget()
            self._stepper.restart()
        return response

    def _idle(self) -> str:
        if not self._stepper.stamp:
            return "the run has not begun"
        return "" if self._stepper.running else "the run is over"
