"""Speeds for drives that follow them: an operator's, shaped against swing, or to a target.

Those to a target have feedback of the swing.

Below a joint that moves the suspension point at the commanded speed v, the payload swings by l a''
+ g a = -v' (a: its angle, positive where it is ahead; l: the rope's length). With v = v_0 + k a, k
= 2 z sqrt(g l), the swing is damped: s² + 2 z w s + w² = 0, w² = g / l. On the way to a target, v_0
= h (x* - x) and the poles solve l (s² + w²) (s + h) + k s² = 0, by Routh's criterion stable for all
h > 0, k > 0.
"""

from collections.abc import Mapping
from math import sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import Field

from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_settings
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import derive
from crane_sim.trajectories.inputs import Table
from crane_sim.trajectories.shaping import Shaping, impulses

TIME_TOLERANCE = 1e-9  # s, of instants that differ by rounding
STEP = 1e-4  # rad or m, of differences: their error is its square
# -, of singular values: above the rounding of directions that are parallel, below that of a short
# lever
CUTOFF = 1e-4


class Settings(NamedTuple):
    """Speeds of all actuated joints, for `drive: velocity` and winches with `drive: rate`."""

    speeds: dict[str, Table] | None = None  # by joint: the operator's, in the joint's unit/s; left
    # out: to `reference.q`; joints that are not named stand still
    shaping: Shaping | None = None  # of the operator's speeds, against the swing of the nominal
    # rope; left out: none
    damping: Annotated[NonNegative, Field(le=1.0)] = 0.2  # -, ratio z that the feedback gives the
    # swing; 0: none
    position_gain: Positive = 0.3  # 1/s, h: speed for a deviation from `reference.q`


SETTINGS = {"control": Settings}


class SpeedCommand(NamedTuple):
    """The speed of one joint."""

    joint: int  # its number among all joints
    table: Table | None  # the operator's
    target: float  # m or rad, where there is no operator
    gain: float  # 1/s, of the deviation from it
    feedback: npt.NDArray[np.float64]  # (nq,), of the joints' positions


class AntiSwingLaw(NamedTuple):
    """The law."""

    joints: tuple[SpeedCommand, ...]  # (nu,)
    weights: tuple[float, ...]  # of the shaper's impulses
    delays: tuple[float, ...]  # s
    commands: tuple[str, ...]  # what each joint is commanded, of `laws.Law`

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the speeds (nu,) at joint positions q, nq or more."""
        return tuple(self._speed(joint, t, q) for joint in self.joints)

    def _speed(self, joint: SpeedCommand, t: float, q: tuple[float, ...]) -> float:
        swing = sum(gain * q[j] for j, gain in enumerate(joint.feedback) if gain)
        if joint.table is None:
            return swing + joint.gain * (joint.target - q[joint.joint])
        return swing + sum(
            weight * float(np.interp(t - delay, joint.table.times, joint.table.values))
            for weight, delay in zip(self.weights, self.delays, strict=True)
            if delay <= t + TIME_TOLERANCE  # before the run nothing was commanded
        )


def build(settings: Mapping[str, Any], nominal: Scene) -> AntiSwingLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is wrong, there is a path, neither a target nor a speed, or nothing
            swings.
    """
    options = read_settings(Settings, settings)
    if nominal.trajectory is not None:
        raise SceneError(
            "reference.path: control.law = 'anti_swing' follows no path, "
            "it goes to reference.q or takes control.speeds; leave the path out"
        )
    length, gains = swing_gains(nominal)
    frequency = sqrt(gravity(nominal) / length)
    tables = _tables(options, nominal)
    weights, delays = _shaper_impulses(options.shaping, frequency)
    feedback = 2.0 * options.damping * frequency * length * gains
    targets = [0.0] * len(feedback) if tables else nominal.reference or ()
    driven = zip(nominal.actuated, targets, feedback, strict=True)
    joints = tuple(
        SpeedCommand(
            nominal.joint_names.index(name),
            tables[i] if tables else None,
            target,
            options.position_gain,
            gains,
        )
        for i, (name, target, gains) in enumerate(driven)
    )
    kinds = tuple("effort" if unit == "m/s" else "velocity" for unit in nominal.effort_units)
    return AntiSwingLaw(joints, tuple(weights), tuple(delays), kinds)


def _shaper_impulses(shaping: Shaping | None, frequency: float) -> tuple[list[float], list[float]]:
    """Return (weights, delays [s]) of a shaper; `frequency`: of the swing [rad/s], for `auto`."""
    if shaping is None:
        return [1.0], [0.0]
    own = frequency if shaping.frequency == "auto" else shaping.frequency
    return impulses(shaping.kind, own, shaping.damping)


def swing_gains(scene: Scene) -> tuple[float, npt.NDArray[np.float64]]:
    """Return (l [m], angles of the swing ahead of each joint by positions (nu, nq)).

    The joints are the actuated ones; the motions are small.

    The angle of a joint that turns is counted as the distance that it moves the tip: it is divided
    by the radius.

    Raises:
        SceneError: the payload hangs on nothing that swings.
    """
    length, ahead, moved = swing_geometry(scene)
    gains = ahead @ moved.T / length
    gains = np.where(np.abs(gains) > STEP, gains, 0.0)
    positions = [unit == "m" for unit in scene.joint_units]
    if not np.any(gains) or np.any(gains[:, positions]):
        raise SceneError(
            "control.law = 'anti_swing': no actuated joint moves a rope that swings by angles"
        )
    return length, gains


class SwingGeometry(NamedTuple):
    """The swing below a suspension point, horizontally."""

    length: float  # m, from the suspension point to the payload
    ahead: npt.NDArray[np.float64]  # (nu, 2) joint's unit/m: times a horizontal offset (2,) of the
    # payload from the point, how far each actuated joint has to move for the point to follow
    moved: npt.NDArray[np.float64]  # (nq, 2) m/joint's unit, horizontal motion of the payload
    # relative to the point by each passive joint


def swing_geometry(scene: Scene, t: float = 0.0) -> SwingGeometry:
    """Return the swing's geometry at a scene's initial posture at t [s], by differences.

    The load hangs at rest.
    """
    n, nu = len(scene.joint_names), len(scene.actuated)
    actuated = [scene.joint_names.index(name) for name in scene.actuated]
    hanging = np.array(scene.initial_q)
    angles = [i for i in range(n) if i not in actuated and scene.joint_units[i] == "rad"]
    hanging[angles] = 0.0
    q = np.concatenate([hanging + STEP * np.eye(n), hanging - STEP * np.eye(n), [hanging]])
    derived = derive(scene, np.full(2 * n + 1, t), q, np.zeros_like(q), np.zeros((2 * n + 1, nu)))
    offset = derived.payload - derived.tip
    moved = (offset[:n] - offset[n : 2 * n])[:, :2] / (2.0 * STEP)
    directions = (derived.tip[:n] - derived.tip[n : 2 * n])[actuated, :2] / (2.0 * STEP)
    moved[actuated] = 0.0
    sizes = np.sum(directions**2, axis=1, keepdims=True)
    ahead = np.linalg.pinv(np.where(sizes > STEP, directions, 0.0).T, rcond=CUTOFF)
    return SwingGeometry(float(np.linalg.norm(offset[-1])), ahead, moved)


def gravity(scene: Scene) -> float:
    """Return the acceleration of free fall [m/s²]; raises SceneError where there is none."""
    file: Any = scene.file
    if not file.gravity > 0.0:
        raise SceneError(
            f"control.law = 'anti_swing': nothing swings at gravity = {file.gravity:g}"
        )
    return file.gravity


def _tables(options: Settings, scene: Scene) -> list[Table]:
    """Return the operator's speeds of all actuated joints; none where there is a target."""
    if options.speeds is None:
        if scene.reference is None:
            raise SceneError("control.speeds: is missing, and so is reference.q: give one of them")
        if options.shaping is not None:
            raise SceneError("control.shaping: shapes control.speeds, which is missing")
        return []
    for name, table in options.speeds.items():
        if name not in scene.actuated:
            raise SceneError(f"control.speeds: {unknown_key(name, scene.actuated, 'joint')}")
        if error := table.find_error():
            raise SceneError(f"control.speeds.{name}: {error}")
    return [options.speeds.get(name, Table((0.0,), (0.0,))) for name in scene.actuated]
