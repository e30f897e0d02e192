"""Drives by speed or position, led along a path of the joints: the scene's, or a received one.

A drive that takes a position is commanded the path's, x*. One that takes a speed is commanded v* +
h (x* - x): the deviation of a joint that follows its speed exactly decays as exp(-h t). Without a
path the joints stay where they start.
"""

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative
from crane_sim.laws import read_settings
from crane_sim.numerics.jit import entry_point
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.polynomials import MIN_INTERVAL, with_rest_at_ends
from crane_sim.trajectories.trajectory import Trajectory, compile_trajectory, reference_at


class Settings(NamedTuple):
    """Cranes whose drives all take speeds or positions, winches with `drive: rate` too.

    A drive is `actuators.JOINT.drive`.
    """

    drive: Literal["velocity", "position"] = "velocity"  # what the drives take
    position_gain: NonNegative = 1.0  # 1/s, h: speed for a deviation from the path, of drives that
    # take speeds


SETTINGS = {"control": Settings}
WINCH_RATE = "m/s"  # unit of the command of a winch that imposes a velocity


class JointRow(NamedTuple):
    """The command of one actuated joint."""

    joint: int  # its number among all joints
    position: float  # -, share of the path's position
    velocity: float  # -, share of the path's velocity
    gain: float  # 1/s, of the deviation


class JointTrajectoryLaw(NamedTuple):
    """The law."""

    rows: tuple[JointRow, ...]  # (nu,)
    trajectory: Trajectory  # of the actuated joints
    commands: tuple[str, ...]  # what each joint is commanded, of `laws.Law`

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the commands (nu,) at joint positions q, nq or more."""
        return compute_commands(self.rows, self.trajectory, t, np.array(q))


@entry_point
def compute_commands(rows, trajectory, t, q):
    """Compiled commands (nu,) for calls from Python."""
    x, rate, _ = reference_at(trajectory, t)
    return tuple(
        [
            row.position * x[i] + row.velocity * rate[i] + row.gain * (x[i] - q[row.joint])
            for i, row in enumerate(rows)
        ]
    )


def build(settings: Mapping[str, Any], nominal: Scene) -> JointTrajectoryLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is wrong, no joint is actuated, or the path is the payload's.
    """
    options = read_settings(Settings, settings)
    if not nominal.actuated:
        raise SceneError("control.law = 'joint_trajectory': no joint of this crane is actuated")
    if nominal.trajectory is not None and not nominal.trajectory.of_joints:
        line = "control.law = 'joint_trajectory' follows paths of the joints only"
        raise SceneError(f"reference.path.of = 'payload': {line}")
    kinds = tuple(
        "effort" if unit == WINCH_RATE else options.drive for unit in nominal.effort_units
    )
    joints = [nominal.joint_names.index(name) for name in nominal.actuated]
    by_position, by_velocity = (1.0, 0.0, 0.0), (0.0, 1.0, options.position_gain)
    pairs = zip(joints, kinds, strict=True)
    rows = tuple(
        JointRow(i, *(by_position if kind == "position" else by_velocity)) for i, kind in pairs
    )
    return JointTrajectoryLaw(rows, nominal.trajectory or _rest(nominal), kinds)


def _rest(scene: Scene) -> Trajectory:
    """Return the path that stays where the actuated joints start."""
    at = dict(zip(scene.joint_names, scene.initial_q, strict=True))
    start = np.array([at[name] for name in scene.actuated])
    return compile_trajectory(
        with_rest_at_ends(np.array([0.0, MIN_INTERVAL]), start[None, :, None]), of_joints=True
    )
