"""LQR for any scene: u = u* - K (z - z*), the equations linearised where the target can be held.

z is what of the joint positions and velocities can move. A law that is sampled solves the discrete Riccati equation,
of the motion between two commands, with the same weights; a continuous one the continuous equation.

The weights are those of Bryson's rule where the scene gives none: a deviation of 0.2 m or 0.05 rad, a velocity of
0.2 m/s or 0.1 rad/s, and an effort that accelerates its own joint by 1 m/s² or 1 rad/s² weigh the same.

The equations are those at the mean of what disturbs the crane: its base at the mean of its motion, constant forces,
no wave and no gust. What its nominal scene has instead, a list or a steady wind, `control.nominal` says.

Where the scene has a path of the joints, these follow it: z* is then the target with the path's positions and
velocities of the actuated joints in place of its own.
"""

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import Field

from crane_control.linearisation import Array, equilibrium, linearise, regulator, without_dry_friction
from crane_control.reduced_state import nominal_coordinate
from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_settings
from crane_sim.numerics.jit import entry_point, generic, routine
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.trajectory import Trajectory, reference_at

DEVIATIONS = {"m": (0.2, 0.2), "rad": (0.05, 0.1), "1": (0.05, 0.1)}
"""Deviation and velocity that weigh 1, by unit of the joint."""


class Channel(NamedTuple):
    """The effort of one actuated joint and those of the joints after it, a list that kernels can walk by type."""

    effort: float  # at the target
    gain: Any  # (2 nq,), of positions, then of velocities
    tail: "Channel | None"


class LqrLaw(NamedTuple):
    """The law; its gain is that of its nominal crane, nq joints."""

    channels: Channel | None
    target: Any  # (nq,)
    trajectory: Trajectory | None  # of the actuated joints, to the target
    poles: Any  # closed-loop eigenvalues (complex): s [1/s] of a continuous law, z of a sampled one

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the effort commands (nu,) at joint positions q and velocities v, nq or more."""
        return compute_efforts(self, t, np.array(q), np.array(v))


@generic
def move_target(trajectory, effort, gain, target, t):
    """Return the effort with the target moved along a trajectory at time t [s]; as it is without one."""
    return effort


@move_target.register(Trajectory)
def _(trajectory, effort, gain, target, t):
    (x, rate, _), n = reference_at(trajectory, t), len(target)
    for i in range(len(x)):
        effort = effort + gain[i] * (x[i] - target[i]) + gain[n + i] * rate[i]
    return effort


@generic
def feedback(channel, law, t, q, v):
    """Return the efforts of a list of channels as a tuple."""
    return ()


@feedback.register(Channel)
def _(channel, law, t, q, v):
    target, n = law.target, len(law.target)
    effort = move_target(law.trajectory, channel.effort, channel.gain, target, t)
    for i in range(n):
        effort = (
            effort
            - channel.gain[i] * (nominal_coordinate(q, i, n) - target[i])
            - channel.gain[n + i] * nominal_coordinate(v, i, n)
        )
    return (effort, *feedback(channel.tail, law, t, q, v))


@system.command.register(LqrLaw)
def _(law, t, q, v):
    return feedback(law.channels, law, t, q, v)


@system.effort.register(LqrLaw)
def _(u, p, t, x):
    return saturated_feedback(u, p, t, x)


@routine
def saturated_feedback(law, p, t, x):
    """Return the efforts (nu,) of the law in state x of model p at t; one piece, which the stages of a step call."""
    q, v = system.joints(p, x)
    return system.saturate(p, feedback(law.channels, law, t, q, v))


@entry_point
def compute_efforts(law, t, q, v):
    """Compiled `command` for calls from Python."""
    return feedback(law.channels, law, t, q, v)


class Settings(NamedTuple):
    """Weights; for any crane. It goes to `reference.q` or follows a `reference.path` of joints (`overhead_shaped`).

    The equations are linearised at the mean of what disturbs the crane: the base at the mean of its motion, constant
    forces and the offsets of sines, no other gusts; `nominal` says what the law takes instead.
    """

    q: Annotated[tuple[NonNegative, ...], Field(min_length=2)] | None = None  # -, weights of positions, then of
    # velocities, one of each joint; left out: Bryson's rule, 0.2 m or 0.05 rad, 0.2 m/s or 0.1 rad/s weigh 1
    r: tuple[Positive, ...] | None = None  # -, weights of the efforts, one of each actuated joint; left out: what
    # accelerates the joint by 1 m/s² or 1 rad/s² weighs 1


SETTINGS = {"control": Settings}


def build(settings: Mapping[str, Any], nominal: Scene) -> LqrLaw:
    """Return the law for its nominal scene, sampled every `nominal.period` if `nominal.sampled`.

    Raises:
        SceneError: a setting is wrong, the path is the payload's, nothing can be held at the target, or a motion about
            it cannot be reached.
    """
    options, nominal = read_settings(Settings, settings), without_dry_friction(nominal)
    if nominal.path is not None and not nominal.path.of_joints:
        raise SceneError("reference.path.of = 'payload': control.law = 'lqr' follows paths of the joints only")
    target, efforts = equilibrium(nominal)
    a, b = linearise(nominal, target, efforts)
    period = nominal.period if nominal.sampled else None
    q, r = _weights(options, nominal, b)
    moving = _moving(nominal, target, a, b)
    gain, poles = regulator(a[np.ix_(moving, moving)], b[moving], q[moving], r, period)
    full = np.zeros((len(efforts), len(a)))
    full[:, moving] = gain
    channels = None
    for effort, row in zip(efforts[::-1], full[::-1], strict=True):
        channels = Channel(float(effort), row.copy(), channels)
    return LqrLaw(channels, target, nominal.path, poles)


def _weights(options: Settings, scene: Scene, b: Array) -> tuple[Array, Array]:
    """Return the weights q (2 nq,) and r (nu,)."""
    nq, nu = len(scene.joint_names), len(scene.actuated)
    own = b[[nq + scene.joint_names.index(name) for name in scene.actuated], range(nu)]
    scales = np.array([DEVIATIONS[unit] for unit in scene.joint_units])
    q = scales.T.ravel() ** -2.0 if options.q is None else np.array(options.q)
    r = own**2 if options.r is None else np.array(options.r)
    for name, weights, size in (("q", q, 2 * nq), ("r", r, nu)):
        if len(weights) != size:
            raise SceneError(f"control.{name}: has {len(weights)} weights, {size} are needed: {scene.joint_names}")
    return q, r


def _moving(scene: Scene, target: Array, a: Array, b: Array) -> npt.NDArray[np.intp]:
    """Return the rows of the state that can deviate: not those of imposed joints, nor along a unit vector."""
    n = len(target)
    still = ~np.any(np.hstack([a, b])[n:] != 0.0, axis=1)
    along = [unit == "1" and abs(x) > 0.5 for unit, x in zip(scene.joint_units, target, strict=True)]
    joints = np.flatnonzero(~(still | along))
    return np.concatenate([joints, n + joints])
