"""Messages of plant and tracker to a two-rate law's inner loop; doubles of node and outer loop."""

from types import SimpleNamespace
from typing import Any, NamedTuple

from trajectory_msgs.msg import JointTrajectory

from crane_sim.ros.common import messages
from crane_sim.ros.controller.setpoints import Setpoints
from crane_sim.ros.controller.states import State

PERIOD = 0.004  # s


class OneTopicNode:
    """A node that records the callback of its subscription, and its log."""

    def __init__(self, topic: str) -> None:
        """Create it without a subscription to its topic."""
        self.topic = topic
        self.callback: Any = None
        self.lines: list[str] = []

    def create_subscription(
        self, _type: type, topic: str, callback: Any, _qos: Any, **_: Any
    ) -> None:
        """Record the callback."""
        assert topic == self.topic
        self.callback = callback

    def get_logger(self) -> SimpleNamespace:
        """Return a logger that records warnings."""
        return SimpleNamespace(warning=lambda line, **_: self.lines.append(line))


class FakeOuterLoop:
    """An outer loop that is due every ten steps."""

    interval, names = 0.04, ("tip_x", "tip_y")

    def __init__(self) -> None:
        """Create it without a setpoint."""
        self.demand: tuple[float, ...] = ()

    def due(self, t: float) -> bool:
        """Return whether it is a tenth step."""
        return round(t / PERIOD) % 10 == 0

    def take(self, demand: tuple[float, ...]) -> None:
        """Record the setpoint."""
        self.demand = demand


def make_setpoint_message(step: int, x: float) -> JointTrajectory:
    """Return the outer loop's message for the state before a step: a setpoint, tip_x = `x` [m]."""
    setpoint = messages.setpoint_message(FakeOuterLoop.names)
    messages.set_setpoint(setpoint, (step + 1) * 4_000_000, (x, 0.0, 0.0, 0.0, 0.0, 0.0))
    return setpoint


def make_state(step: int) -> State:
    """Return the state before a step."""
    return State((step + 1) * 4_000_000, step * PERIOD, (), ())


class SetpointFixture(NamedTuple):
    """Setpoints with their surroundings."""

    node: OneTopicNode
    answered: list[State]  # states that had waited for their setpoint
    setpoints: Setpoints
    outer_loop: FakeOuterLoop


def make_setpoint_fixture(lockstep: bool) -> SetpointFixture:
    """Return setpoints with doubles of their surroundings."""
    node, answered = OneTopicNode("tip_demand"), []
    return SetpointFixture(
        node,
        answered,
        Setpoints(node, FakeOuterLoop.names, lockstep, answered.append),
        FakeOuterLoop(),
    )  # type: ignore[arg-type]
