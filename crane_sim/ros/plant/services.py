"""The plant's services of ordinary types, as in simulation_interfaces 2.1, and those for faults."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from crane_sim.ros.plant.run_control import RunControl
from crane_sim.simulation.plant import Plant


def offer_services(node: Node, control: RunControl, settings: SimpleNamespace) -> None:
    """Offer `~/set_pause`, `~/set_brakes`, `~/step_simulation` and `~/reset_simulation`.

    The parameters `step_count`, `reset_positions` and `reset_velocities`, whose current values are
    in `settings`, fix the number of steps and the state after a reset.
    """

    def set_pause(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = control.set_paused(request.data)
        response.success = not response.message
        if response.success and not control.paused:
            response.message = control.why_waiting()  # the pause is over, and yet nothing moves
        return response

    node.create_service(SetBool, "~/set_pause", set_pause)
    node.create_service(
        SetBool, "~/set_brakes", _answer(lambda request: control.set_brakes(request.data))
    )
    node.create_service(
        Trigger, "~/step_simulation", _answer(lambda _: control.take_steps(settings.step_count))
    )
    node.create_service(Trigger, "~/reset_simulation", _answer(lambda _: control.reset()))


def offer_faults(node: Node, plant: Plant) -> None:
    """Offer `~/faults/NAME`: true begins a fault with the next period, false ends it.

    Either overrides the fault's schedule.

    A reset of the run clears the overrides.
    """
    for name in plant.faults:

        def set_fault(request: Any, response: Any, name: str = name) -> Any:
            plant.set_fault(name, request.data)
            response.success = True
            response.message = (
                f"{name} is {'on' if request.data else 'off'} from t = {plant.t:g} s on"
            )
            return response

        node.create_service(SetBool, f"~/faults/{name}", set_fault)


def _answer(act: Callable[[Any], str]) -> Callable[[Any, Any], Any]:
    """Return the callback of a service that returns why it failed, or an empty string."""

    def answer(request: Any, response: Any) -> Any:
        response.message = act(request)
        response.success = not response.message
        return response

    return answer
