"""Goals and the topic of trajectories in the controller, without control_msgs and without DDS."""

from types import SimpleNamespace
from typing import Any

import pytest
from builtin_interfaces.msg import Duration
from fake_node import FakeNode, fake_sources
from speed_trolley import DOCUMENT
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from crane_control.nodes.controller_node import ControllerNode
from crane_sim import load_scene
from crane_sim.ros.common.serialization import STATE, JointStateCodec
from crane_sim.ros.controller import trajectory_action

__all__ = ["fake_sources"]

CODEC = JointStateCodec(load_scene(DOCUMENT).joint_names, STATE)
PERIOD_NS = 10_000_000


def path_to(position: float) -> JointTrajectory:
    """Return a path of the trolley that rests at a position [m] in four seconds."""
    point = JointTrajectoryPoint(
        positions=[position], velocities=[0.0], time_from_start=Duration(sec=4)
    )
    return JointTrajectory(joint_names=["trolley"], points=[point])


class FakeHandle:
    """A goal of the action, with its end and the line of its result."""

    def __init__(self, position: float) -> None:
        """Go to a position [m]."""
        empty = {
            f"{kind}_tolerance": [] for kind in ("path", "goal", "component_path", "component_goal")
        }
        fields: dict[str, Any] = {
            "multi_dof_trajectory": SimpleNamespace(joint_names=[], points=[])
        } | empty
        self.request = SimpleNamespace(
            trajectory=path_to(position), goal_time_tolerance=Duration(), **fields
        )
        self.is_cancel_requested, self.ended, self.line = False, "", ""

    def execute(self) -> None:
        """Do nothing."""

    def publish_feedback(self, message: Any) -> None:
        """Do nothing."""

    def abort(self) -> None:
        """End as aborted."""
        self.ended = "aborted"

    def canceled(self) -> None:
        """End as cancelled."""
        self.ended = "cancelled"


class FakeServer:
    """The action's server."""

    def __init__(self, node: Any, action: Any, name: str, on_goal: Any, on_accepted: Any) -> None:
        """Pass accepted goals on through the node."""
        node.callbacks[name] = on_accepted

    def complete(self, handle: FakeHandle, result: Any) -> None:
        """Record the line of a goal's result."""
        handle.line = result.error_string


def feedback(**fields: Any) -> SimpleNamespace:
    """Return an empty message of feedback."""
    points = {name: JointTrajectoryPoint() for name in ("desired", "actual", "error")}
    return SimpleNamespace(header=Header(), **points, **fields)


@pytest.fixture
def node(fake_sources: None, monkeypatch: pytest.MonkeyPatch) -> FakeNode:
    """Return the node of an active controller whose scene has neither a target nor a path."""
    action = SimpleNamespace(Result=SimpleNamespace, Feedback=feedback)
    monkeypatch.setattr(
        trajectory_action, "import_module", lambda _: SimpleNamespace(FollowJointTrajectory=action)
    )
    monkeypatch.setattr(trajectory_action, "DeferredServer", FakeServer)
    settings = SimpleNamespace(
        scene=DOCUMENT, law="", mode="lockstep", expected_recorders=0, stop_time=2.0
    )
    node = FakeNode()
    ControllerNode(node, settings).set_active(True)  # type: ignore[arg-type]
    return node


def send_state(node: FakeNode, step: int) -> None:
    """Send the state before a step, at rest at the origin."""
    node.callbacks["joint_states"](
        CODEC.encode((step + 1) * PERIOD_NS, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    )


def send_goal(node: FakeNode, position: float) -> FakeHandle:
    """Send a goal; return its handle."""
    handle = FakeHandle(position)
    node.callbacks[trajectory_action.NAME](handle)
    return handle


def references(node: FakeNode) -> list[float]:
    """Return the published references [m]."""
    return [message.points[0].positions[0] for message in node.published["joint_trajectory"]]


def test_the_reference_of_a_scene_without_one_is_that_of_a_goal(node: FakeNode) -> None:
    """Where the scene has no target nothing is published as one until a goal has one."""
    send_state(node, 0)
    assert references(node) == []
    send_goal(node, 0.5)
    send_state(node, 1)
    assert references(node) == [0.5]


def test_a_path_of_the_topic_ends_a_goal_at_once(node: FakeNode) -> None:
    """A topic's path ends the goal at the same state: a later cancellation does not stop it."""
    send_state(node, 0)
    goal = send_goal(node, 0.5)
    send_state(node, 1)
    node.callbacks["joint_trajectory"](path_to(-0.5))
    send_state(node, 2)
    assert goal.ended == "aborted" and "joint_trajectory has taken over" in goal.line
    goal.is_cancel_requested = True
    send_state(node, 3)
    assert goal.ended == "aborted"
    assert references(node) == pytest.approx([0.5, -0.5], abs=1e-12)  # rounding of the polynomials


def test_a_cancelled_goal_stops_the_path(node: FakeNode) -> None:
    """Without a topic's path a cancellation brings the joints to rest, not at the goal or start."""
    send_state(node, 0)
    goal = send_goal(node, 0.5)
    send_state(node, 1)
    goal.is_cancel_requested = True
    send_state(node, 200)
    assert goal.ended == "cancelled" and 0.0 < references(node)[-1] < 0.5
