"""The plant's services `~/faults/NAME`, one for each fault of the scene: true lets it be there, false ends it."""

from functools import partial

from rclpy.node import Node
from std_srvs.srv import SetBool

from crane_sim.plant import Plant


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
