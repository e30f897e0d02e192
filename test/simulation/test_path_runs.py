"""Runs along a path: their tracking errors, and laws that are given a new path during a run."""

import subprocess
import sys
from typing import Any, NamedTuple

import numpy as np
import pytest
from process_helpers import next_line, started_program
from scipy.spatial.transform import Rotation
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from two_rate_messages import OneTopicNode

import crane_sim
from crane_sim import orchestration
from crane_sim.ros.common.messages import reference_message
from crane_sim.ros.controller.trajectory_input import TrajectoryInput
from crane_sim.simulation.derived import in_base
from crane_sim.trajectories.base_motion import Base
from crane_sim.trajectories.joint_trajectory import Point, Waypoints
from crane_sim.trajectories.minimum_jerk import MinimumJerk
from crane_sim.trajectories.polynomials import evaluate
from crane_sim.trajectories.replanning import (
    join_trajectory,
    to_piecewise_polynomial,
    with_trajectory,
)
from crane_sim.trajectories.trajectory import Trajectory, compile_trajectory, sample_trajectory

TRACKING_METRICS = ("tracking_mse", "tracking_mae", "tracking_peak", "peak_tip_acceleration")
SCENE = crane_sim.load_scene("offshore_obstacle", {"duration": 20.0})


@pytest.fixture(scope="module")
def run() -> crane_sim.Rollout:
    """Return a run of the payload along waypoints."""
    return crane_sim.simulate(SCENE)


def test_metrics_are_their_definitions(run: crane_sim.Rollout) -> None:
    """Errors are the payload's at all instants of the run; tip accelerations are as commanded."""
    error = np.linalg.norm(
        run.payload[:, :2] - sample_trajectory(SCENE.trajectory, run.t)[:, 0], axis=1
    )
    expected = (
        np.mean(error**2),
        np.mean(error),
        np.max(error),
        np.max(np.linalg.norm(run.u[:-1], axis=1)),
    )
    actual = [run.summary[name] for name in TRACKING_METRICS]
    assert actual[:3] == pytest.approx(expected[:3], rel=1e-12)  # rounding of sums in another order
    assert actual[3] == pytest.approx(expected[3], abs=1e-7)  # second difference over a millisecond


def test_metrics_are_of_the_crane_with_its_payload_as_it_is() -> None:
    """With another payload from the start, all metrics of a path are those of its own scene.

    The other scene has that payload.

    The laws and what they know are the same, and so are the motions.
    """
    changes = {"duration": 1.0, "control.law": "cartesian"}
    other = crane_sim.load_scene(
        "knuckle_tracking",
        changes | {"faults": {"drop": {"kind": "payload", "mass": 0.5, "at": 0}}},
    )
    load = crane_sim.load_scene("knuckle_tracking", changes).document["payload"]
    own = changes | {"payload.mass": 0.5, "control.nominal": {"payload": load}}
    actual, expected = (
        crane_sim.simulate(scene).summary
        for scene in (other, crane_sim.load_scene("knuckle_tracking", own))
    )
    for name in TRACKING_METRICS:
        # of the start: the change is a step of its own
        assert actual[name] == pytest.approx(expected[name], rel=1e-9)


def test_errors_are_seen_from_the_base() -> None:
    """A point fixed to a moving base has constant coordinates in the axes of the base."""
    amplitudes = np.array([0.3, 0.5, 0.7, 0.2, 0.1, 0.4])
    base = Base(np.zeros(6), amplitudes[:, None], np.ones((6, 1)), np.zeros((6, 1)))
    t, point = np.array([0.0, 0.4, 1.9]), np.array([1.3, -0.2, -1.0])
    angles = np.outer(np.sin(t), amplitudes[:2:-1])
    world = np.outer(np.sin(t), amplitudes[:3]) + Rotation.from_euler("ZYX", angles).apply(point)
    assert np.max(np.abs(in_base(base, t, world) - point)) < 1e-14  # rounding


class Follower(NamedTuple):
    """A law with a path in `inner`, perhaps nested, and an internal state."""

    inner: Any
    state: Any


NAMES = ("x", "y")
OLD = compile_trajectory(MinimumJerk(((0.0, 1.0), (2.0, -1.0)), (0.0, 4.0)).to_polynomials())
POINTS = (
    Point((5.0, 5.0), 2.0, (1.0, 0.0), (0.0, 0.0)),
    Point((6.0, 7.0), 5.0, (0.0, 0.0), (0.0, 0.0)),
)


def test_a_new_path_goes_on_from_the_old_one() -> None:
    """Position, velocity, acceleration are continuous at the change.

    Past points are left out, joints are sorted.
    """
    first = Point((9.0, 9.0), 0.5, (0.0, 0.0), (0.0, 0.0))
    new = join_trajectory(Waypoints(("y", "x"), (first, *POINTS), 0.5), OLD, NAMES, 1.5)
    before, after = (
        evaluate(to_piecewise_polynomial(OLD), np.array([1.5])),
        evaluate(to_piecewise_polynomial(new), np.array([1.5])),
    )
    assert after == pytest.approx(before, abs=1e-12)  # rounding
    for k in (1, 2):
        old, now = (
            evaluate(to_piecewise_polynomial(path), np.array([1.5]), k) for path in (OLD, new)
        )
        assert now == pytest.approx(old, abs=1e-12)
    ends = evaluate(to_piecewise_polynomial(new), np.array([2.5, 5.5, 99.0]))
    assert ends == pytest.approx(
        np.array([[5.0, 5.0], [7.0, 6.0], [7.0, 6.0]]), abs=1e-9
    )  # rounding of powers of t up to 5 s


def test_replacing_the_path_keeps_the_internal_state() -> None:
    """The path nested inside a law is replaced, and its internal state is the same array."""
    law = Follower(Follower(OLD, 2.0), np.ones(3))
    new = join_trajectory(Waypoints(NAMES, POINTS), OLD, NAMES, 0.0)
    actual = with_trajectory(law, new)
    assert actual.inner.inner is new and actual.state is law.state and actual.inner.state == 2.0


def message(positions: list[list[float]], names: tuple[str, ...] = NAMES) -> JointTrajectory:
    """Return a trajectory with a point every second from t = 1 s on."""
    points = [JointTrajectoryPoint(positions=row) for row in positions]
    for i, point in enumerate(points):
        point.time_from_start.sec = i + 1
    return JointTrajectory(joint_names=list(names), points=points)


def test_trajectories_from_the_topic() -> None:
    """A message replaces the law's path once.

    The node's own messages, and what does not fit, change nothing.
    """
    node, law, published = (
        OneTopicNode("joint_trajectory"),
        Follower(OLD, None),
        reference_message(SCENE.actuated, ()),
    )
    trajectory_input = TrajectoryInput(node, SCENE, law)  # pyright: ignore[reportArgumentType]
    assert trajectory_input.apply_to(law, 1.0) is law
    for ignored in (published, message([[1.0, 2.0]], ("x", "z")), message([[1.0]]), message([])):
        node.callback(ignored)
        assert trajectory_input.apply_to(law, 1.0) is law
    assert len(node.lines) == 3 and all(
        line.startswith("joint_trajectory: refused: ") for line in node.lines
    )
    node.callback(message([[3.0, 4.0], [5.0, 6.0]]))
    new = trajectory_input.apply_to(law, 1.0).inner
    assert isinstance(new, Trajectory)
    actual = evaluate(to_piecewise_polynomial(new), np.array([1.0, 2.0, 3.0, 9.0]))
    start = evaluate(to_piecewise_polynomial(OLD), np.array([1.0]))[0]
    # rounding
    assert actual == pytest.approx(np.array([start, [3.0, 4.0], [5.0, 6.0], [5.0, 6.0]]), abs=1e-12)
    assert trajectory_input.apply_to(Follower(new, None), 1.1).inner is new


def test_a_law_without_a_path_does_not_subscribe() -> None:
    """A node whose law follows no path has no subscription."""
    node = OneTopicNode("joint_trajectory")
    TrajectoryInput(node, SCENE, Follower(1.0, None))  # pyright: ignore[reportArgumentType]
    assert node.callback is None


SENDER = """
import time, rclpy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rclpy.init()
node = rclpy.create_node("sender", namespace="pendulum")
publisher = node.create_publisher(JointTrajectory, "joint_trajectory", 10)
point = JointTrajectoryPoint(positions=[1.35, 1.0], velocities=[0.0, 0.0])
point.time_from_start.sec = 4
while rclpy.ok() and not publisher.get_subscription_count():
    time.sleep(0.02)
publisher.publish(JointTrajectory(joint_names=["x", "y"], points=[point]))
publisher.wait_for_all_acked()
print("received", flush=True)
rclpy.spin(node)
"""


@pytest.mark.long
def test_a_run_follows_a_received_trajectory(
    domain_id: int, ros_environment: dict[str, str]
) -> None:
    """A trajectory sent to plant and controller, in two processes, leads the payload off its path.

    It is sent as soon as the controller listens, and leads to (1.35, 1), from which the scene's
    path is 1 m and more.
    """
    with started_program(
        [sys.executable, "-c", SENDER], env=ros_environment, stdout=subprocess.PIPE
    ) as sender:

        def wait_for_message(role: str, _: int) -> None:
            if role == "controller":  # the run begins when all nodes are ready
                assert next_line(sender) == "received\n"

        summary = orchestration.run(
            SCENE, record=None, domain_id=domain_id, on_activated=wait_for_message
        )
    assert summary["tracking_peak"] > 0.98  # within the law's own error; 0.006 without the message
