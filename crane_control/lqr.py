"""LQR for any scene: u = u* - K (z - z*), the equations linearised where the target can be held.

z: the joint positions and velocities that are free to deviate; of a unit vector, the two
coordinates of its tangent plane. A law that is sampled solves the discrete Riccati equation, of the
motion between two commands, with the same weights; a continuous one the continuous equation.

The weights are those of Bryson's rule where the scene gives none: a deviation of 0.2 m or 0.05 rad,
a velocity of 0.2 m/s or 0.1 rad/s, and an effort that accelerates its own joint by 1 m/s² or 1
rad/s² weigh the same.

The equations are those at the mean of what disturbs the crane (`crane_sim.scenes.averaging`): its
base at the mean of its motion, forces at theirs, no wave and no gust. A static heel or a steady
wind is given in `control.nominal`.

Where the scene has a path of the joints, these follow it: z* is then the target with the path's
positions and velocities of the actuated joints in place of its own.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field
from threadpoolctl import threadpool_limits

from crane_control.reduced_state import nominal_coordinate
from crane_control.regulator import Array, solve_regulator
from crane_sim import system
from crane_sim.files.errors import SceneError, shorten
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import ForeignSetting, read_settings
from crane_sim.numerics.jit import routine
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.linearisation import (
    by_kind,
    equilibria,
    imposed_rows,
    state_matrices_of,
    tangent_basis,
    without_dry_friction,
)
from crane_sim.trajectories.trajectory import Trajectory, reference_at

DEVIATIONS = {"m": (0.2, 0.2), "rad": (0.05, 0.1), "1": (0.05, 0.1)}
"""Deviation and velocity whose weighted squares are 1, by unit of the joint."""


class GainRow(NamedTuple):
    """The effort of one actuated joint."""

    effort: float  # at the target
    gain: Any  # (2 nq,), of positions, then of velocities


class LqrLaw(NamedTuple):
    """The law; its gain is that of its nominal crane, nq joints."""

    rows: tuple[GainRow, ...]  # (nu,)
    target: Any  # (nq,)
    trajectory: Trajectory | None  # of the actuated joints, to the target
    poles: Any  # closed-loop eigenvalues (complex): s [1/s] of a continuous law, z of a sampled one

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the effort commands (nu,) at joint positions q and velocities v, nq or more."""
        return system.compute_command(self, t, np.array(q), np.array(v))


def add_path_feedback(trajectory, effort, gain, target, t):
    """Return the effort with the feedback on the trajectory at t [s]; as it is without one.

    It is on the trajectory's deviation from the target.
    """
    if trajectory is None:
        return effort
    (x, rate, _), n = reference_at(trajectory, t), len(target)
    for i in range(len(x)):
        effort = effort + gain[i] * (x[i] - target[i]) + gain[n + i] * rate[i]
    return effort


def row_effort(row, law, t, q, v):
    """Return the effort of one row."""
    target, n = law.target, len(law.target)
    effort = add_path_feedback(law.trajectory, row.effort, row.gain, target, t)
    for i in range(n):
        effort = (
            effort
            - row.gain[i] * (nominal_coordinate(q, i, n) - target[i])
            - row.gain[n + i] * nominal_coordinate(v, i, n)
        )
    return effort


@system.command.register(LqrLaw)
def feedback(law, t, q, v):
    """Return the efforts (nu,) of the law."""
    return tuple([row_effort(row, law, t, q, v) for row in law.rows])


@system.demand.register(LqrLaw)
def feedback_demand(u, p, t, x):
    """Return the efforts (nu,) of the law, evaluated by the equations of the crane p."""
    return feedback(u, t, *system.joints(p, x))


@system.effort.register(LqrLaw)
@routine
def feedback_effort(u, p, t, x):
    """Return the law's demand within the actuators' limits; not inlined: one call per stage."""
    return system.saturate(p, feedback_demand(u, p, t, x))


class Settings(NamedTuple):
    """Weights, for any crane; the law goes to `reference.q` or follows a `reference.path`.

    The path is one of joints (`overhead_shaped`).

    The gain is that of the discrete Riccati equation, for efforts that are held for a period
    (zero-order hold), with the same weights: at 10 ms 1 to 6 % beside the gain of the continuous
    one, which `period: continuous` has.

    The equations are linearised at the mean of what disturbs the crane: the base at the mean of its
    motion, constant forces, the offsets of sines and the means of tables; `nominal` says what the
    law takes instead.
    """

    q: Annotated[tuple[NonNegative, ...], Field(min_length=2)] | None = None  # -, weights of
    # positions, then of velocities, one of each joint; left out: Bryson's rule, which counts 0.2 m
    # or 0.05 rad, 0.2 m/s or 0.1 rad/s as 1
    r: tuple[Positive, ...] | None = None  # -, weights of the efforts, one of each actuated joint;
    # left out: the effort that accelerates the joint by 1 m/s² or 1 rad/s² counts as 1


SETTINGS = {"control": Settings}


def build(settings: Mapping[str, Any], nominal: Scene) -> LqrLaw:
    """Return the law for its nominal scene, sampled every `nominal.period` if `nominal.sampled`.

    Raises:
        SceneError: a setting is wrong, the path is the payload's, nothing can be held at the
            target, or a motion about it cannot be reached.
    """
    (law,) = build_many([settings], [nominal])
    if isinstance(law, SceneError):
        raise law
    return law


def build_many(
    settings: Sequence[Mapping[str, Any]], nominals: Sequence[Scene]
) -> list[LqrLaw | SceneError]:
    """Return the law of each of many scenes, or the error that `build` raises for it.

    Rest and linear equations, which cost most, are computed for all scenes of a kind at once.
    """
    scenes = [without_dry_friction(nominal) for nominal in nominals]
    laws: list[Any] = [_options_of(*pair) for pair in zip(settings, scenes, strict=True)]
    sound = [i for i, law in enumerate(laws) if not isinstance(law, SceneError)]
    rests: dict[int, Any] = dict(zip(sound, equilibria([scenes[i] for i in sound]), strict=True))
    laws = [
        rest if isinstance(rest := rests.get(i), SceneError) else law for i, law in enumerate(laws)
    ]
    with threadpool_limits(
        limits=1, user_api="blas"
    ):  # more threads wait longer for each other than they compute
        for group in by_kind(scenes):
            kind = [i for i in group if not isinstance(laws[i], SceneError)]
            if kind:
                matrices = state_matrices_of(
                    [scenes[i] for i in kind], *zip(*(rests[i] for i in kind), strict=True)
                )
                for i, a, b in zip(kind, *matrices, strict=True):
                    laws[i] = _design(laws[i], scenes[i], rests[i], a, b)
    return laws


def _options_of(settings: Mapping[str, Any], scene: Scene) -> Settings | SceneError:
    """Return the weights as they are given, or what is wrong with them or with the path."""
    try:
        options = read_settings(Settings, settings)
        if scene.trajectory is not None and not scene.trajectory.of_joints:
            raise SceneError(
                "reference.path.of = 'payload': control.law = 'lqr' follows paths of the joints "
                "only"
            )
        if scene.reference is not None and scene.actuated:
            _check_sizes(options, scene)
    except ForeignSetting as error:
        return ForeignSetting(error.key, error.known, "lqr")
    except SceneError as error:
        return error
    return options


def _design(
    options: Settings, scene: Scene, rest: tuple[Array, Array], a: Array, b: Array
) -> LqrLaw | SceneError:
    """Return the law of a scene about rest, or the error that it has no regulator.

    Rest is (positions (nq,), efforts (nu,)).

    a, b are the linear equations of its n free deviations, (2 n, 2 n) and (2 n, nu); what nothing
    accelerates is left out.
    """
    basis, moving = tangent_basis(scene, rest[0]), np.flatnonzero(np.tile(~imposed_rows(a, b), 2))
    nq, n = basis.shape
    to_joints = np.zeros((2 * nq, 2 * n))
    to_joints[:nq, :n] = to_joints[nq:, n:] = basis
    to_joints = to_joints[:, moving]
    driven = [scene.joint_names.index(name) for name in scene.actuated]
    q, r = _weights(options, scene, (basis @ b[n:])[driven, range(len(driven))])
    reduced = to_joints.T @ (q[:, None] * np.eye(2 * nq)) @ to_joints
    period = scene.period if scene.sampled else None
    try:
        gain, poles = solve_regulator(a[np.ix_(moving, moving)], b[moving], reduced, r, period)
    except SceneError as error:
        return error
    target, efforts = rest
    rows = tuple(
        GainRow(float(effort), row.copy())
        for effort, row in zip(efforts, gain @ to_joints.T, strict=True)
    )
    return LqrLaw(rows, target, scene.trajectory, poles)


def _weights(options: Settings, scene: Scene, accelerations: Array) -> tuple[Array, Array]:
    """Return the weights q (2 nq,) and r (nu,).

    `accelerations` (nu,) are those by a unit of each effort.
    """
    q = _scale_weights(scene.joint_units) if options.q is None else np.array(options.q)
    r = accelerations**2 if options.r is None else np.array(options.r)
    return q, r


@lru_cache(maxsize=64)
def _scale_weights(units: tuple[str, ...]) -> Array:
    """Return the weights (2 nq,) of joints by the units of their positions (nq,)."""
    return np.array([DEVIATIONS[unit] for unit in units]).T.ravel() ** -2.0


def _check_sizes(options: Settings, scene: Scene) -> None:
    """Raise SceneError where there are more or fewer weights than the scene has joints."""
    joints, actuated = list(scene.joint_names), list(scene.actuated)
    for name, weights, size, what in (
        (
            "q",
            options.q,
            2 * len(joints),
            f"of the positions, then of the velocities, of {shorten(joints)}",
        ),
        ("r", options.r, len(actuated), f"one per actuated joint, {shorten(actuated)}"),
    ):
        if weights is not None and len(weights) != size:
            raise SceneError(
                f"control.{name}: has {len(weights)} weights, {size} are needed: {what}"
            )
