"""Goals of control_msgs/FollowJointTrajectory: checks on arrival and while they are followed.

A request is read by its fields, so that nothing here needs the package.
"""

from collections.abc import Iterable, Sequence
from enum import IntEnum
from math import inf
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError
from trajectory_msgs.msg import JointTrajectory

from crane_sim.files.errors import one_line
from crane_sim.ros.common import messages
from crane_sim.ros.common.messages import MalformedMessage
from crane_sim.trajectories.joint_trajectory import Waypoints
from crane_sim.trajectories.polynomials import Array

_FORM = TypeAdapter(Waypoints)
_KINDS = ("position", "velocity", "acceleration")
_NO_LIMIT = -1.0  # value of a tolerance; 0 is the server's own, which has no limit either


class GoalCode(IntEnum):
    """Error codes of the action's result."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


class GoalError(ValueError):
    """A goal that cannot be followed: a one-line message, and the code of the action's result."""

    def __init__(self, code: GoalCode, line: str) -> None:
        """Give the reason."""
        super().__init__(line)
        self.code = code


class Tolerances(NamedTuple):
    """Largest deviations of the joints (nu,), inf for none."""

    positions: tuple[float, ...]  # joint's unit
    velocities: tuple[float, ...]  # joint's unit/s
    accelerations: tuple[float, ...]  # joint's unit/s², mean over the last period

    @property
    def limited(self) -> bool:
        """Whether there is a limit at all."""
        return min(*self.positions, *self.velocities, *self.accelerations) < inf

    def describe_violation(self, names: Sequence[str], error: Array) -> str:
        """Return a line on the first joint beyond its tolerance, empty for none; error (3, nu)."""
        for kind, limits, deviations in zip(_KINDS, self, error.tolist(), strict=True):
            for name, limit, deviation in zip(names, limits, deviations, strict=True):
                if not abs(deviation) <= limit:
                    return f"{name}: the {kind} deviates by {deviation:.6g}, tolerance {limit:g}"
        return ""


class Goal(NamedTuple):
    """A goal that can be followed."""

    waypoints: Waypoints
    immediate: bool  # it begins with the next state; else at the waypoints' start
    on_the_way: Tolerances
    at_the_end: Tolerances
    leeway: float  # s after the last point, within which the joints must be there; inf: any

    @property
    def end(self) -> float:
        """Time [s] of the last point."""
        return self.waypoints.start + self.waypoints.points[-1].time_from_start


def waypoints_of(message: JointTrajectory, now: float, period: float, period_ns: int) -> Waypoints:
    """Return the points of a message; stamps are on the clock of joint states, zero is now [s].

    Raises:
        ValidationError: they are no numbers, or there are none.
        MalformedMessage: the stamp is out of range.
    """
    stamp = messages.nanoseconds(message.header.stamp)
    points = [
        {
            "positions": tuple(point.positions),
            "velocities": tuple(point.velocities),
            "accelerations": tuple(point.accelerations),
            "time_from_start": point.time_from_start.sec
            + point.time_from_start.nanosec / messages.NS_PER_S,
        }
        for point in message.points
    ]
    start = (stamp / period_ns - 1.0) * period if stamp else now
    return _FORM.validate_python(
        {"joint_names": message.joint_names, "points": points, "start": start}
    )


def read_goal(
    request: Any, names: Sequence[str], now: float, period: float, period_ns: int
) -> Goal:
    """Return the goal of a request for the joints, or coordinates, `names` (n,) at time `now` [s].

    Raises:
        GoalError: it cannot be followed.
    """
    trajectory = request.trajectory
    _check_joints(request, names)
    try:
        waypoints = waypoints_of(trajectory, now, period, period_ns)
    except ValidationError as error:
        raise GoalError(GoalCode.INVALID_GOAL, one_line(error, Waypoints)) from None
    except MalformedMessage as error:
        raise GoalError(GoalCode.INVALID_GOAL, str(error)) from None
    if error := waypoints.describe_mismatch() or waypoints.describe_end_velocity():
        raise GoalError(GoalCode.INVALID_GOAL, error)
    immediate = not messages.nanoseconds(trajectory.header.stamp)
    leeway = request.goal_time_tolerance
    on_the_way = _tolerances("path_tolerance", request.path_tolerance, names)
    at_the_end = _tolerances("goal_tolerance", request.goal_tolerance, names)
    seconds = leeway.sec + leeway.nanosec / messages.NS_PER_S
    goal = Goal(waypoints, immediate, on_the_way, at_the_end, seconds if seconds > 0.0 else inf)
    if not goal.end > now:
        line = f"the last point is {now - goal.end:g} s ago"
        raise GoalError(GoalCode.INVALID_GOAL if immediate else GoalCode.OLD_HEADER_TIMESTAMP, line)
    return goal


def _check_joints(request: Any, names: Sequence[str]) -> None:
    """Raise GoalError where a request is not of exactly the joints `names`."""
    if (
        request.multi_dof_trajectory.points
        or request.component_path_tolerance
        or request.component_goal_tolerance
    ):
        raise GoalError(
            GoalCode.INVALID_GOAL, "joints with several degrees of freedom: the crane has none"
        )
    if sorted(request.trajectory.joint_names) != sorted(names):
        given = ", ".join(request.trajectory.joint_names) or "none"
        raise GoalError(
            GoalCode.INVALID_JOINTS,
            f"joint_names = {given}: must be {', '.join(names)}, in any order",
        )


def _tolerances(key: str, given: Iterable[Any], names: Sequence[str]) -> Tolerances:
    limits = {name: (inf, inf, inf) for name in names}
    for tolerance in given:
        if tolerance.name not in limits:
            line = f"{key}: {tolerance.name!r} is no joint of the trajectory: {', '.join(names)}"
            raise GoalError(GoalCode.INVALID_JOINTS, line)
        of_name = [
            _limit(f"{key}: {tolerance.name}: {kind}", getattr(tolerance, kind)) for kind in _KINDS
        ]
        limits[tolerance.name] = of_name[0], of_name[1], of_name[2]
    return Tolerances(*zip(*limits.values(), strict=True))


def _limit(what: str, value: float) -> float:
    if value == 0.0 or value == _NO_LIMIT:
        return inf
    if not value > 0.0:
        raise GoalError(GoalCode.INVALID_GOAL, f"{what} = {value:g}: must be positive, 0 or -1")
    return value
