"""What the servo of a law in halves forgets when the plant begins anew, without DDS."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from trajectory_msgs.msg import JointTrajectory
from two_rate_messages import heard, message, state

from crane_control.nodes.controller_node import ControllerNode
from crane_sim import load_scene
from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import JointWire

SCENE = load_scene("offshore_two_rate")


def test_a_reset_forgets_the_demand_of_the_run_before() -> None:
    """With every reset a state waits for its own demand, although one with its stamp is there; one of its own stays."""
    node, _, demands, half = heard(patient=True)
    node.callback(message(0, 1.0))
    assert demands.given_to(half, state(0))
    for x in (2.0, 3.0):
        demands.forget()
        assert not demands.given_to(half, state(0))
        node.callback(message(0, x))
        assert demands.given_to(half, state(0)) and half.demand[0] == x
    node.callback(message(10, 4.0))
    node.callback(message(0, 5.0))  # the slow half saw the reset first
    demands.forget()
    assert demands.given_to(half, state(0)) and half.demand[0] == 5.0


class DeafNode:
    """A node without a middleware.

    Attributes:
        callbacks: of its subscriptions, by topic.
        commands: what was published.
    """

    def __init__(self) -> None:
        """Have neither said nor heard anything."""
        self.callbacks: dict[str, Callable[[Any], None]] = {}
        self.commands: list[bytes] = []
        self.get_name, self.get_namespace = (lambda: "controller"), (lambda: "/pendulum")

    def create_publisher(self, _kind: type, topic: str, _qos: Any) -> SimpleNamespace:
        """Return what keeps commands."""
        ours = self.commands.append if topic == "joint_commands" else (lambda _: None)
        return SimpleNamespace(publish=ours)

    def create_subscription(self, _kind: type, topic: str, callback: Any, _qos: Any, **_: Any) -> None:
        """Keep the callback."""
        self.callbacks[topic] = callback


def demand(x: float) -> JointTrajectory:
    """Return what the tracker demands at the first state: that the suspension point is here."""
    names = SCENE.law.slow_half.names  # type: ignore[union-attr]
    made = messages.demand_message(names)
    messages.set_demand(made, SCENE.period_ns, (x,) + (0.0,) * (3 * len(names) - 1))
    return made


def test_every_new_run_waits_for_its_own_demand() -> None:
    """A paused plant that is reset twice, to two places, gets no answer of the servo to a demand for another place."""
    node, wire = DeafNode(), JointWire(SCENE.joint_names, effort=False)
    settings = SimpleNamespace(scene=SCENE.name, law="", mode="lockstep", expected_recorders=0)
    controller = ControllerNode(node, settings)  # type: ignore[arg-type]
    controller.activate(True)
    for run in range(3):
        velocity = (0.01 * run, *SCENE.initial_v[1:])
        node.callbacks["joint_states"](wire.encode(SCENE.period_ns, SCENE.initial_q, velocity))
        assert len(node.commands) == run
        node.callbacks["tip_demand"](demand(0.1 * run))
        assert len(node.commands) == run + 1
    assert len(set(node.commands)) == 3
