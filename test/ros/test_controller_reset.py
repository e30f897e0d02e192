"""Reset of a two-rate law's inner loop, without DDS: the previous run's setpoints are dropped."""

from types import SimpleNamespace

import pytest
from fake_node import FakeNode, fake_sources
from trajectory_msgs.msg import JointTrajectory
from two_rate_messages import make_setpoint_fixture, make_setpoint_message, make_state

from crane_control.nodes.controller_node import ControllerNode
from crane_sim import load_scene
from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import STATE, JointStateCodec

__all__ = ["fake_sources"]

pytestmark = pytest.mark.usefixtures("fake_sources")

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
    # the outer loop received the state after the reset first
    node.callback(make_setpoint_message(0, 5.0))
    setpoints.reset()
    assert setpoints.apply_to(outer, make_state(0)) and outer.demand[0] == 5.0
    assert setpoints.metrics()["late"] == 0


def setpoint_at_first_state(x: float) -> JointTrajectory:
    """Return the tracker's setpoint at the first state: the point at tip_x = `x` [m], at rest."""
    names = SCENE.law.outer_loop.names  # type: ignore[union-attr]
    message = messages.setpoint_message(names)
    messages.set_setpoint(message, SCENE.period_ns, (x,) + (0.0,) * (3 * len(names) - 1))
    return message


def test_every_new_run_waits_for_its_own_setpoint() -> None:
    """A plant that is reset twice gets no command of a setpoint of the previous run.

    The resets go to other states.
    """
    node, codec = FakeNode(), JointStateCodec(SCENE.joint_names, STATE)
    settings = SimpleNamespace(scene=SCENE.name, law="", mode="lockstep", expected_recorders=0)
    controller = ControllerNode(node, settings)  # type: ignore[arg-type]
    controller.set_active(True)
    for run in range(3):
        velocity = (0.01 * run, *SCENE.initial_v[1:])
        node.callbacks["joint_states"](
            codec.encode(SCENE.period_ns, SCENE.initial_q, velocity, velocity)
        )
        assert len(node.published["joint_commands"]) == run
        node.callbacks["tip_demand"](setpoint_at_first_state(0.1 * run))
        assert len(node.published["joint_commands"]) == run + 1
    assert len(set(node.published["joint_commands"])) == 3
