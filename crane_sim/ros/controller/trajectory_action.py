"""The action `joint_trajectory_controller/follow_joint_trajectory` of a law that follows a path.

The path is one of the joints or, for a law whose path is the payload's, of its coordinates in the
base frame.

A goal's trajectory becomes the law's path, joined to the old one, at the goal's start: at the next
state, or at the first one that is not before its stamp. What a goal does depends on the states
alone, so in lockstep a run with goals that come early enough for their stamps is the same every
time.
"""

from collections.abc import Callable
from importlib import import_module
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

from crane_sim.ros.common import messages
from crane_sim.ros.controller.coordinate_motion import (
    VelocityErrorDifferentiator,
    coordinate_names,
    make_motion_reader,
)
from crane_sim.ros.controller.states import State
from crane_sim.ros.controller.trajectory_goal import Goal, GoalCode, GoalError, read_goal
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.polynomials import MIN_INTERVAL, Array, PiecewisePolynomial, evaluate
from crane_sim.trajectories.replanning import (
    join_trajectory,
    stop_trajectory,
    to_piecewise_polynomial,
    trajectory_of_law,
    with_trajectory,
)
from crane_sim.trajectories.trajectory import Trajectory

NAME = "joint_trajectory_controller/follow_joint_trajectory"
_PACKAGE = "control_msgs"
_FEEDBACK_PERIOD = 0.05  # s of the scene's time
# of the executor at the end: each serves one event, such as the completion of a goal
_LAST_SPINS = 20


class _Accepted(NamedTuple):
    """A goal that has been accepted."""

    handle: ServerGoalHandle
    goal: Goal


class _Followed(NamedTuple):
    """The goal that is followed."""

    handle: ServerGoalHandle
    goal: Goal
    trajectory: Trajectory  # the law's, until another one replaces it
    polynomials: PiecewisePolynomial  # the same
    first_stamp: int  # ns, of the state with which it began


class DeferredServer(ActionServer):
    """An action server whose goals the node that follows them ends; every goal may be cancelled.

    rclpy's own runs a callback to the end of a goal; one that waits would keep its executor busy.
    """

    def __init__(
        self,
        node: Node,
        action: Any,
        name: str,
        on_goal: Callable[[Any], GoalResponse],
        on_accepted: Callable[[ServerGoalHandle], None],
    ) -> None:
        """Offer an action; `on_goal` decides whether it accepts a goal, `on_accepted` gets it."""
        super().__init__(
            node,
            action,
            name,
            lambda _: None,
            goal_callback=on_goal,
            handle_accepted_callback=on_accepted,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def notify_execute(self, goal_handle: ServerGoalHandle, execute_callback: Any) -> None:
        """Execute nothing: the goal's owner does."""

    def complete(self, handle: ServerGoalHandle, result: Any) -> None:
        """Give a goal whose state is final its result."""
        super().notify_execute(handle, lambda _: result)


class TrajectoryAction:
    """The goals of the action: one is followed, and a newer one may wait for its start.

    Attributes:
        missing_package: one line on why there is no action although the law follows a trajectory,
            else empty.
    """

    def __init__(self, node: Node, scene: Scene, law: Any, settings: SimpleNamespace) -> None:
        """Offer nothing yet; joints stop within `settings.stop_time` [s] after a goal."""
        self._node, self._scene, self._settings = node, scene, settings
        self._every = max(1, round(_FEEDBACK_PERIOD / scene.period))
        self.missing_package = ""
        self._now = 0.0  # s, of the newest state
        self._accepts = self._stops = False
        self._pending: _Accepted | None = None
        self._followed: _Followed | None = None
        self._server: DeferredServer | None = None
        self._action: Any = None
        self._rate = VelocityErrorDifferentiator()
        path = trajectory_of_law(law)
        if path is not None:
            self._names, self._measure = (
                coordinate_names(path, scene),
                make_motion_reader(path, scene),
            )
            self._find_action()

    def set_active(self, active: bool) -> None:
        """Accept goals from now on, or end them; a standby offers no server until activation."""
        self._accepts = active
        if not active:
            self._end_all("the controller is inactive")
        elif self._server is None and self._action is not None:
            self._server = DeferredServer(
                self._node, self._action, NAME, self._answer_goal, self._on_accepted
            )

    def apply_to(self, law: Any, state: State) -> Any:
        """Return the law that answers a new state, with the path of a new goal or of a stop."""
        # a walk through the law, of each state
        path = trajectory_of_law(law) if self._server is not None else None
        if path is None:
            return law
        self._now = state.t
        self.serve_cancellations()
        law = self._begin(law, path, state) if self._is_due(state.t) else law
        if self._followed and self._follow(self._followed, state):
            self._stops = True
        if self._stops:
            self._stops, path = False, trajectory_of_law(law)
            law = (
                with_trajectory(law, stop_trajectory(path, state.t, self._settings.stop_time))
                if path
                else law
            )
        return law

    def abort_replaced(self, law: Any) -> None:
        """End the followed goal if the law has another path.

        It ends at once, or a cancellation would stop the other path.
        """
        if self._followed and self._followed.trajectory is not trajectory_of_law(law):
            self._abort_followed("a trajectory of the topic joint_trajectory has taken over")

    def serve_cancellations(self) -> None:
        """End the goals that are to be cancelled; the joints stop from the next state on."""
        if self._followed and self._followed.handle.is_cancel_requested:
            handle, self._followed, self._stops = self._followed.handle, None, True
            self._complete(
                handle, handle.canceled, GoalCode.SUCCESSFUL, "cancelled: the joints come to rest"
            )
        if self._pending and self._pending.handle.is_cancel_requested:
            handle, self._pending = self._pending.handle, None
            self._complete(
                handle, handle.canceled, GoalCode.SUCCESSFUL, "cancelled before its start"
            )

    def reset(self) -> None:
        """End the followed goal: the run begins anew. One that waits for its start waits on."""
        self._now, self._stops = 0.0, False
        self._abort_followed("the simulation was reset")

    def finish(self) -> None:
        """End all goals: there are no further states."""
        if self._followed or self._pending:
            self._end_all("the run is over")
            if executor := self._node.executor:
                for _ in range(_LAST_SPINS):
                    executor.spin_once(timeout_sec=0.0)

    def _find_action(self) -> None:
        try:
            self._action = import_module(f"{_PACKAGE}.action").FollowJointTrajectory
        except ImportError:
            self.missing_package = messages.describe_missing(_PACKAGE)

    def _answer_goal(self, _: Any) -> GoalResponse:
        """Accept a goal; a wrong one ends at once with the code that says why.

        A rejection has no code.
        """
        return GoalResponse.ACCEPT if self._accepts else GoalResponse.REJECT

    def _on_accepted(self, handle: ServerGoalHandle) -> None:
        handle.execute()
        scene = self._scene
        try:
            goal = read_goal(handle.request, self._names, self._now, scene.period, scene.period_ns)
        except GoalError as error:
            self._complete(handle, handle.abort, error.code, str(error))
            return
        if self._pending:
            self._preempt(self._pending.handle)
        self._pending = _Accepted(handle, goal)

    def _is_due(self, t: float) -> bool:
        pending = self._pending
        return pending is not None and (
            pending.goal.immediate or pending.goal.waypoints.start <= t + MIN_INTERVAL
        )

    def _begin(self, law: Any, path: Trajectory, state: State) -> Any:
        """Return the law on the path of the waiting goal; unchanged where that is too late."""
        assert self._pending is not None
        (handle, goal), self._pending = self._pending, None
        if goal.immediate:
            goal = goal._replace(waypoints=goal.waypoints._replace(start=state.t))
        try:
            new = join_trajectory(goal.waypoints, path, self._names, state.t)
        except ValueError as error:
            self._complete(handle, handle.abort, GoalCode.OLD_HEADER_TIMESTAMP, str(error))
            return law
        if self._followed:
            self._preempt(self._followed.handle)
        self._rate = VelocityErrorDifferentiator()
        self._stops, self._followed = (
            False,
            _Followed(handle, goal, new, to_piecewise_polynomial(new), state.stamp),
        )
        return with_trajectory(law, new)

    def _follow(self, followed: _Followed, state: State) -> bool:
        """Publish feedback, and end the goal when it is due; return whether the joints stop.

        A goal ends at its end, or as soon as a joint is out of its tolerances.
        """
        handle, goal = followed.handle, followed.goal
        ended = state.t > goal.end - MIN_INTERVAL
        due = (state.stamp - followed.first_stamp) // self._scene.period_ns % self._every == 0
        if not (due or ended or goal.on_the_way.limited or goal.at_the_end.limited):
            return False
        desired = np.concatenate(
            [evaluate(followed.polynomials, np.array([state.t]), k) for k in range(2)]
        )
        actual = self._measure(state)
        if due:
            self._publish_feedback(followed, state, desired, actual)
        tolerances, error = goal.at_the_end if ended else goal.on_the_way, desired - actual
        violation = tolerances.describe_violation(
            self._names, np.vstack([error, self._rate.update(state, error[1])])
        )
        if not violation and ended:
            self._followed = None
            self._complete(handle, handle.succeed, GoalCode.SUCCESSFUL, "the joints are there")
        elif violation and (not ended or state.t > goal.end + goal.leeway):
            code = GoalCode.GOAL_TOLERANCE_VIOLATED if ended else GoalCode.PATH_TOLERANCE_VIOLATED
            self._followed = None
            self._complete(handle, handle.abort, code, f"at t = {state.t:g} s {violation}")
            return True
        return False

    def _publish_feedback(
        self, followed: _Followed, state: State, desired: Array, actual: Array
    ) -> None:
        feedback = self._action.Feedback(joint_names=list(self._names))
        messages.set_stamp(feedback.header.stamp, state.stamp)
        elapsed = round((state.t - followed.goal.waypoints.start) * messages.NS_PER_S)
        for point, rows in (
            (feedback.desired, desired),
            (feedback.actual, actual),
            (feedback.error, desired - actual),
        ):
            _fill_point(point, rows, max(elapsed, 0))
        followed.handle.publish_feedback(feedback)

    def _preempt(self, handle: ServerGoalHandle) -> None:
        self._complete(handle, handle.abort, GoalCode.INVALID_GOAL, "preempted by a newer goal")

    def _abort_followed(self, why: str) -> None:
        if self._followed:
            handle, self._followed = self._followed.handle, None
            self._complete(handle, handle.abort, GoalCode.INVALID_GOAL, why)

    def _end_all(self, why: str) -> None:
        self._abort_followed(why)
        if self._pending:
            handle, self._pending = self._pending.handle, None
            self._complete(handle, handle.abort, GoalCode.INVALID_GOAL, why)

    def _complete(
        self, handle: ServerGoalHandle, change: Callable[[], None], code: GoalCode, line: str
    ) -> None:
        """End a goal by a change of its state, with its result."""
        assert self._server is not None
        change()
        self._server.complete(handle, self._action.Result(error_code=int(code), error_string=line))


def _fill_point(point: JointTrajectoryPoint, rows: Array, elapsed: int) -> None:
    """Fill a point from positions and velocities (2, nu), at a time [ns] from the start."""
    point.positions, point.velocities = rows[0].tolist(), rows[1].tolist()
    point.time_from_start.sec, point.time_from_start.nanosec = divmod(elapsed, messages.NS_PER_S)
