"""Messages of plant and tracker, as the servo of a law in halves gets them."""

from types import SimpleNamespace
from typing import Any

from trajectory_msgs.msg import JointTrajectory

from crane_sim.ros.common import messages
from crane_sim.ros.controller.setpoints import Setpoints
from crane_sim.ros.controller.states import State

PERIOD = 0.004  # s


class OneTopicNode:
    """A node that keeps the callback of its subscription, and its log."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.callback: Any = None
        self.lines: list[str] = []

    def create_subscription(self, _type: type, topic: str, callback: Any, _qos: Any) -> None:
        """Keep the callback."""
        assert topic == "tip_demand"
        self.callback = callback

    def get_logger(self) -> SimpleNamespace:
        """Return what keeps warnings."""
        return SimpleNamespace(warning=lambda line, **_: self.lines.append(line))


class Half:
    """A fast half's room for demands, that wants one every ten steps."""

    interval, names = 0.04, ("tip_x", "tip_y")

    def __init__(self) -> None:
        """Begin without a demand."""
        self.demand: tuple[float, ...] = ()

    def due(self, t: float) -> bool:
        """Return whether it is one of the tenth steps."""
        return round(t / PERIOD) % 10 == 0

    def take(self, demand: tuple[float, ...]) -> None:
        """Keep the demand."""
        self.demand = demand


def message(step: int, x: float) -> JointTrajectory:
    """Return a demand that was made for a step."""
    demand = messages.demand_message(Half.names)
    messages.set_demand(demand, (step + 1) * 4_000_000, (x, 0.0, 0.0, 0.0, 0.0, 0.0))
    return demand


def state(step: int) -> State:
    """Return the state before a step."""
    return State((step + 1) * 4_000_000, step * PERIOD, (), ())


def heard(patient: bool) -> tuple[OneTopicNode, list[State], Setpoints, Half]:
    """Return a node, the states whose answers were asked for, the demands, and who takes them."""
    node, answered = OneTopicNode(), []
    return node, answered, Setpoints(node, Half.names, patient, answered.append), Half()  # type: ignore[arg-type]
