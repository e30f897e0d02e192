"""Trajectories on the topic `joint_trajectory`, which replace that of a running law."""

from collections import deque
from typing import Any

from pydantic import ValidationError
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory

from crane_sim.files.errors import one_line
from crane_sim.ros.common import messages
from crane_sim.ros.controller.coordinate_motion import coordinate_names
from crane_sim.ros.controller.trajectory_goal import waypoints_of
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.joint_trajectory import Point, Waypoints
from crane_sim.trajectories.polynomials import evaluate
from crane_sim.trajectories.replanning import (
    join_trajectory,
    to_piecewise_polynomial,
    trajectory_of_law,
    with_trajectory,
)

_OWN_REFERENCES = 16  # that may still be on their way


class TrajectoryInput:
    """The newest trajectory that was received, until the law follows it.

    A stamp of zero is now; any other is on the clock of the joint states. Coordinates are the
    actuated joints, or x, y (and z) of the payload in the base frame, whichever the law follows;
    others are refused in one line.
    """

    def __init__(self, node: Node, scene: Scene, law: Any) -> None:
        """Subscribe where the law follows a trajectory."""
        self._node, self._scene = node, scene
        self._own = deque(
            [messages.reference_message(scene.actuated, scene.reference or ())],
            maxlen=_OWN_REFERENCES,
        )
        self._pending: JointTrajectory | None = None
        trajectory = trajectory_of_law(law)
        if trajectory is None:
            return
        self._names = coordinate_names(trajectory, scene)
        start = tuple(
            evaluate(to_piecewise_polynomial(trajectory), trajectory.starts[:1])[0].tolist()
        )
        waypoints = Waypoints(self._names, (Point(start, 1.0),))
        join_trajectory(waypoints, trajectory, self._names, 0.0)  # imports slow packages
        node.create_subscription(
            JointTrajectory, "joint_trajectory", self._on_message, messages.STREAM_QOS
        )

    def ignore(self, reference: JointTrajectory) -> None:
        """Ignore messages with this reference from now on: the controller's own."""
        self._own.append(reference)

    def _on_message(self, message: JointTrajectory) -> None:
        if all(
            (message.joint_names, message.points) != (own.joint_names, own.points)
            for own in self._own
        ):
            self._pending = message

    def apply_to(self, law: Any, t: float) -> Any:
        """Return the law, with its new trajectory from time t [s] on if one was received."""
        message, self._pending = self._pending, None
        trajectory = trajectory_of_law(law) if message is not None else None
        if message is None or trajectory is None:
            return law
        scene = self._scene
        try:
            waypoints = waypoints_of(message, t, scene.period, scene.period_ns)
            return with_trajectory(law, join_trajectory(waypoints, trajectory, self._names, t))
        except ValidationError as error:
            self._refuse(one_line(error, Waypoints))
        except ValueError as error:
            self._refuse(str(error))
        return law

    def _refuse(self, line: str) -> None:
        self._node.get_logger().warning(
            f"joint_trajectory: refused: {line}", throttle_duration_sec=1.0
        )
