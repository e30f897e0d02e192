"""Reset of a two-rate law's inner loop, without DDS: the outer loop's setpoints of the previous run are dropped."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from trajectory_msgs.msg import JointTrajectory
from two_rate_messages import make_setpoint_fixture, make_setpoint_message, make_state

from crane_control.nodes.controller_node import ControllerNode
from crane_sim import load_scene
from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import STATE, JointStateCodec

SCENE = load_scene("offshore_two_rate")


def test_a_reset_drops_the_setpoint_of_the_previous_run() -> None:
    """After a reset a setpoint of the previous run is not used, though its stamp matches.

    One of the new run that arrived before the reset is kept.
    """
    node, _, setpoints, outer = make_setpoint_fixture(lockstep=True)
    node.callback(make_setpoint_message(0, 1.0))
    assert setpoints.apply_to(outer, make_state(0))
    for x in (2.0, 3.0):
        setpoints.reset()
        assert not setpoints.apply_to(outer, make_state(0))
        node.callback(make_setpoint_message(0, x))
        assert setpoints.apply_to(outer, make_state(0)) and outer.demand[0] == x
    node.callback(make_setpoint_message(10, 4.0))
    node.callback(make_setpoint_message(0, 5.0))  # the outer loop received the state after the reset first
    setpoints.reset()
    assert setpoints.apply_to(outer, make_state(0)) and outer.demand[0] == 5.0
    assert setpoints.metrics()["late"] == 0


class FakeNode:
    """A node without a middleware.

    Attributes:
        callbacks: of its subscriptions, by topic.
        commands: what was published.
    """

    def __init__(self) -> None:
        """Create it without topics."""
        self.callbacks: dict[str, Callable[[Any], None]] = {}
        self.commands: list[bytes] = []
        self.get_name, self.get_namespace = (lambda: "controller"), (lambda: "/pendulum")

    def create_publisher(self, _kind: type, topic: str, _qos: Any) -> SimpleNamespace:
        """Return a publisher, which records commands."""
        publish = self.commands.append if topic == "joint_commands" else (lambda _: None)
        return SimpleNamespace(publish=publish)

    def create_subscription(self, _kind: type, topic: str, callback: Any, _qos: Any, **_: Any) -> None:
        """Record the callback."""
        self.callbacks[topic] = callback


def setpoint_at_first_state(x: float) -> JointTrajectory:
    """Return the tracker's setpoint at the first state: the suspension point at tip_x = `x` [m], at rest."""
    names = SCENE.law.outer_loop.names  # type: ignore[union-attr]
    message = messages.setpoint_message(names)
    messages.set_setpoint(message, SCENE.period_ns, (x,) + (0.0,) * (3 * len(names) - 1))
    return message


def test_every_new_run_waits_for_its_own_setpoint() -> None:
    """A plant that is reset twice, to other states, gets no command that a setpoint of the previous run would give."""
    node, codec = FakeNode(), JointStateCodec(SCENE.joint_names, STATE)
    settings = SimpleNamespace(scene=SCENE.name, law="", mode="lockstep", expected_recorders=0)
    controller = ControllerNode(node, settings)  # type: ignore[arg-type]
    controller.set_active(True)
    for run in range(3):
        velocity = (0.01 * run, *SCENE.initial_v[1:])
        node.callbacks["joint_states"](codec.encode(SCENE.period_ns, SCENE.initial_q, velocity, velocity))
        assert len(node.commands) == run
        node.callbacks["tip_demand"](setpoint_at_first_state(0.1 * run))
        assert len(node.commands) == run + 1
    assert len(set(node.commands)) == 3
