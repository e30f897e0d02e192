"""Goals of FollowJointTrajectory without that package or DDS: refusals, tolerances, stopping."""

from math import inf, nan
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from trajectory_msgs.msg import (
    JointTrajectory,
    JointTrajectoryPoint,
    MultiDOFJointTrajectory,
    MultiDOFJointTrajectoryPoint,
)

from crane_sim import load_scene
from crane_sim.ros.controller.coordinate_motion import (
    VelocityErrorDifferentiator,
    coordinate_names,
    make_motion_reader,
)
from crane_sim.ros.controller.states import State
from crane_sim.ros.controller.trajectory_goal import (
    Goal,
    GoalCode,
    GoalError,
    Tolerances,
    read_goal,
)
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import in_base
from crane_sim.simulation.rollout import simulate
from crane_sim.trajectories.minimum_jerk import MinimumJerk
from crane_sim.trajectories.polynomials import Array, evaluate, max_derivatives
from crane_sim.trajectories.replanning import stop_trajectory, to_piecewise_polynomial
from crane_sim.trajectories.trajectory import compile_trajectory

NAMES = ("trolley", "hoist")
PERIOD, PERIOD_NS = 0.01, 10_000_000


def request(**changes: Any) -> Any:
    """Return a good request for two joints, with changes."""
    points = [JointTrajectoryPoint(positions=[float(i), 2.0]) for i in range(2)]
    points[1].time_from_start.sec = 3
    fields: dict[str, Any] = {
        "trajectory": JointTrajectory(joint_names=["hoist", "trolley"], points=points)
    }
    fields |= {"multi_dof_trajectory": MultiDOFJointTrajectory(), "goal_time_tolerance": Duration()}
    fields |= {
        f"{kind}_tolerance": [] for kind in ("path", "goal", "component_path", "component_goal")
    }
    return SimpleNamespace(**fields | changes)


def tolerance(
    name: str = "hoist", position: float = 0.0, velocity: float = 0.0, acceleration: float = 0.0
) -> Any:
    """Return a tolerance."""
    return SimpleNamespace(
        name=name, position=position, velocity=velocity, acceleration=acceleration
    )


def read(now: float = 1.0, **changes: Any) -> Goal:
    """Return the goal of a request at time `now` [s]."""
    return read_goal(request(**changes), NAMES, now, PERIOD, PERIOD_NS)


def trajectory(stamp: int = 0, **changes: Any) -> JointTrajectory:
    """Return the good request's trajectory with a stamp [ns] and changes of its first point."""
    message = request().trajectory
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    for key, value in changes.items():
        setattr(message.points[0], key, value)
    return message


def test_a_goal_is_read_as_it_is_meant() -> None:
    """Without a stamp a goal begins with the next state; tolerances are sorted by joint.

    0 and -1 are no limits.
    """
    goal = read(
        path_tolerance=[
            tolerance(position=0.1, velocity=-1.0),
            tolerance("trolley", acceleration=0.5),
        ],
        goal_time_tolerance=Duration(sec=2),
    )
    assert goal.immediate and goal.end == 4.0 and goal.leeway == 2.0
    assert (
        goal.on_the_way == ((inf, 0.1), (inf, inf), (0.5, inf))
        and goal.on_the_way.limited
        and not goal.at_the_end.limited
    )
    stamped = read(trajectory=trajectory(2 * 10**9 + PERIOD_NS))
    assert (
        not stamped.immediate
        and stamped.end == pytest.approx(5.0, abs=1e-12)
        and stamped.leeway == inf
    )


WIDE = MultiDOFJointTrajectory(points=[MultiDOFJointTrajectoryPoint()])


@pytest.mark.parametrize(
    ("changes", "code", "line"),
    [
        ({"multi_dof_trajectory": WIDE}, GoalCode.INVALID_GOAL, "several degrees of freedom"),
        ({"component_goal_tolerance": [0]}, GoalCode.INVALID_GOAL, "several degrees of freedom"),
        (
            {"trajectory": JointTrajectory()},
            GoalCode.INVALID_JOINTS,
            "joint_names = none: must be trolley, hoist",
        ),
        (
            {"trajectory": trajectory(positions=[1.0])},
            GoalCode.INVALID_GOAL,
            r"points\[0\].positions has 1 values",
        ),
        ({"trajectory": trajectory(positions=[1.0, nan])}, GoalCode.INVALID_GOAL, "positions"),
        (
            {"trajectory": trajectory(velocities=[1.0, 0.0])},
            GoalCode.INVALID_GOAL,
            "velocities has 0 values",
        ),
        (
            {"trajectory": trajectory(time_from_start=Duration(sec=3))},
            GoalCode.INVALID_GOAL,
            "times must increase",
        ),
        (
            {"trajectory": trajectory(time_from_start=Duration(sec=-1))},
            GoalCode.INVALID_GOAL,
            "time_from_start",
        ),
        (
            {"trajectory": trajectory(PERIOD_NS), "now": 3.01},
            GoalCode.OLD_HEADER_TIMESTAMP,
            "the last point is 0.01 s ago",
        ),
        (
            {"trajectory": trajectory(-2 * 10**9)},
            GoalCode.INVALID_GOAL,
            "stamp of -2 s and 0 ns: must be at least 0",
        ),
        (
            {"goal_tolerance": [tolerance("hook")]},
            GoalCode.INVALID_JOINTS,
            "goal_tolerance: 'hook' is no joint",
        ),
        (
            {"path_tolerance": [tolerance(position=-2.0)]},
            GoalCode.INVALID_GOAL,
            "hoist: position = -2: must be",
        ),
        (
            {"path_tolerance": [tolerance(velocity=nan)]},
            GoalCode.INVALID_GOAL,
            "hoist: velocity = nan: must be",
        ),
        (
            {"goal_tolerance": [tolerance(acceleration=-0.5)]},
            GoalCode.INVALID_GOAL,
            "hoist: acceleration = -0.5: must be",
        ),
    ],
)
def test_wrong_goals_have_a_code_and_a_line(
    changes: dict[str, Any], code: GoalCode, line: str
) -> None:
    """What cannot be followed is refused with the code of its kind, and one line on the cause."""
    with pytest.raises(GoalError, match=line) as error:
        read(**changes)
    assert error.value.code == code and "\n" not in str(error.value)


def test_the_first_joint_beyond_its_tolerance_is_named() -> None:
    """A deviation at the tolerance is within it, one beyond it is not, and NaN is beyond any."""
    limits = Tolerances((0.5, inf), (inf, 0.25), (inf, 2.0))

    def violation(*error: float) -> str:
        return limits.describe_violation(NAMES, np.array([*error, 0.0, 0.0][:6]).reshape(3, 2))

    assert not violation(-0.5, 1e9, 1e9, 0.25)
    assert violation(0.6, 0.0, 0.0, 1.0) == "trolley: the position deviates by 0.6, tolerance 0.5"
    assert violation(0.0, 0.0, 0.0, -0.3) == "hoist: the velocity deviates by -0.3, tolerance 0.25"
    assert violation(0.0, nan, 0.0, 0.0)
    assert (
        violation(0.0, 0.0, 0.0, 0.0, 9.0, 2.5)
        == "hoist: the acceleration deviates by 2.5, tolerance 2"
    )


def test_accelerations_are_means_over_a_period() -> None:
    """The error of an acceleration is the change of the velocity's error over a period.

    It is zero at the first state.
    """
    rate = VelocityErrorDifferentiator()
    errors = [
        rate.update(State(k * PERIOD_NS, 0.0, (), ()), np.array([0.3 * k, -0.1 * k * k]))
        for k in (4, 5, 6)
    ]
    assert errors[0].tolist() == [0.0, 0.0]
    assert errors[1:] == [pytest.approx([30.0, -90.0]), pytest.approx([30.0, -110.0])]


@pytest.mark.parametrize("name", ["knuckle_tracking", "offshore_obstacle"])
def test_a_payload_on_its_path_is_measured_from_the_joints(name: str) -> None:
    """Coordinates of a payload's path are the payload's in the base frame, with their rates."""
    scene = load_scene(name)
    run, n = simulate(load_scene(name, {"duration": 0.2})), 10
    assert scene.trajectory is not None
    names, measure = (
        coordinate_names(scene.trajectory, scene),
        make_motion_reader(scene.trajectory, scene),
    )
    assert names in (("x", "y"), ("x", "y", "z"))

    def at(k: int) -> Array:
        return measure(State(0, 0.0, tuple(run.q[k].tolist()), tuple(run.v[k].tolist())))

    aboard = (
        in_base(scene.model.base, run.t[n : n + 1], run.payload[n : n + 1])[0]
        if has_base(scene)
        else run.payload[n]
    )
    assert at(n)[0] == pytest.approx(aboard[: len(names)], abs=1e-12)  # rounding
    rate = (at(n + 1)[0] - at(n - 1)[0]) / (run.t[n + 1] - run.t[n - 1])
    # third derivatives of some m/s³, times the period squared
    assert at(n)[1] == pytest.approx(rate, abs=1e-3)


def has_base(scene: Scene) -> bool:
    """Return whether the base of a crane moves."""
    return getattr(scene.model, "base", None) is not None


def test_stopping_is_smooth_and_ends_at_rest() -> None:
    """A stop continues the old motion, ends at rest in time, and does not swing out.

    The old motion is position, velocity and acceleration.
    """
    old = compile_trajectory(
        MinimumJerk(((0.0, 1.0), (2.0, -1.0)), (0.0, 4.0)).to_polynomials(), of_joints=True
    )
    stop = stop_trajectory(old, 1.5, 0.8)
    before, now = to_piecewise_polynomial(old), to_piecewise_polynomial(stop)

    def at(path: Any, t: float, order: int) -> Array:
        return evaluate(path, np.array([t]), order)[0]

    for order in range(3):
        assert at(now, 1.5, order) == pytest.approx(at(before, 1.5, order), abs=1e-12)  # rounding
    for order in (1, 2):
        # a moment before the end
        assert at(now, 2.3 - 1e-12, order) == pytest.approx(0.0, abs=1e-9)
    v, a = at(before, 1.5, 1), at(before, 1.5, 2)
    expected = at(before, 1.5, 0) + v * 0.8 / 2.0 + a * 0.8**2 / 12.0  # the integral of the cubic
    assert at(now, 9.0, 0) == pytest.approx(expected, abs=1e-12)
    assert stop.of_joints and np.all(max_derivatives(now, 1) < 1.1 * np.abs(v))
