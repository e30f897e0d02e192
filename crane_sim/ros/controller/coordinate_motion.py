"""Motion of a trajectory's coordinates: the actuated joints, or the payload in the base frame."""

from collections.abc import Callable

import numpy as np

from crane_sim.description import urdf
from crane_sim.description.frame_motion import frame_motions_in_base
from crane_sim.description.transforms import PAYLOAD, TransformTree
from crane_sim.ros.common import messages
from crane_sim.ros.controller.states import State
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.reference import COORDINATES
from crane_sim.trajectories.polynomials import Array
from crane_sim.trajectories.replanning import to_piecewise_polynomial
from crane_sim.trajectories.trajectory import Trajectory


def coordinate_names(trajectory: Trajectory, scene: Scene) -> tuple[str, ...]:
    """Return the names of a trajectory's coordinates."""
    if trajectory.of_joints:
        return scene.actuated
    return COORDINATES[: to_piecewise_polynomial(trajectory).coefficients.shape[1]]


def make_motion_reader(trajectory: Trajectory, scene: Scene) -> Callable[[State], Array]:
    """Return a function from a measured state to a trajectory's positions and velocities (2, n)."""
    n = len(coordinate_names(trajectory, scene))
    if trajectory.of_joints:
        return lambda state: np.array([state.q[:n], state.v[:n]])
    tree = TransformTree(urdf(scene), scene.joint_names)

    def measure(state: State) -> Array:
        payload = frame_motions_in_base(tree, state.q, state.v)[PAYLOAD]
        return np.array([payload.position[:n], payload.velocity[:n]])

    return measure


class VelocityErrorDifferentiator:
    """Differentiates an error of velocities: the error of the mean acceleration over a period."""

    def __init__(self) -> None:
        """Begin without an error."""
        self._last: tuple[int, Array] | None = None

    def update(self, state: State, error: Array) -> Array:
        """Return the rate (n,) of the error (n,) of velocities up to a state; zero at the first."""
        last, self._last = self._last, (state.stamp, error)
        if last is None or state.stamp == last[0]:
            return np.zeros_like(error)
        return (error - last[1]) / ((state.stamp - last[0]) / messages.NS_PER_S)
