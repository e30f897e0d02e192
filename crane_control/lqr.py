"""LQR for any scene: u = u* - K (z - z*), the equations linearised where the target can be held.

z: the joint positions and velocities that are free to deviate; of a unit vector, the two coordinates of its tangent
plane. A law that is sampled solves the discrete Riccati equation, of the motion between two commands, with the same
weights; a continuous one the continuous equation.

The weights are those of Bryson's rule where the scene gives none: a deviation of 0.2 m or 0.05 rad, a velocity of
0.2 m/s or 0.1 rad/s, and an effort that accelerates its own joint by 1 m/s² or 1 rad/s² weigh the same.

The equations are those at the mean of what disturbs the crane (`crane_sim.scenes.averaging`): its base at the mean of
its motion, forces at theirs, no wave and no gust. A static heel or a steady wind is given in `control.nominal`.

Where the scene has a path of the joints, these follow it: z* is then the target with the path's positions and
velocities of the actuated joints in place of its own.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field
from scipy.linalg import block_diag

from crane_control.reduced_state import nominal_coordinate
from crane_control.regulator import Array, regulators
from crane_sim import system
from crane_sim.files.errors import SceneError, shorten
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import ForeignSetting, read_settings
from crane_sim.numerics.jit import entry_point, generic, routine
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
"""Deviation and velocity that weigh 1, by unit of the joint."""


class GainRow(NamedTuple):
    """The effort of one actuated joint and those of the joints after it, a linked list, unrolled at compile time."""

    effort: float  # at the target
    gain: Any  # (2 nq,), of positions, then of velocities
    tail: "GainRow | None"


class LqrLaw(NamedTuple):
    """The law; its gain is that of its nominal crane, nq joints."""

    rows: GainRow | None
    target: Any  # (nq,)
    trajectory: Trajectory | None  # of the actuated joints, to the target
    poles: Any  # closed-loop eigenvalues (complex): s [1/s] of a continuous law, z of a sampled one

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the effort commands (nu,) at joint positions q and velocities v, nq or more."""
        return compute_efforts(self, t, np.array(q), np.array(v))


@generic
def add_path_feedback(trajectory, effort, gain, target, t):
    """Return the effort with the feedback on a trajectory's deviation from the target at t [s]; none without one."""
    return effort


@add_path_feedback.register(Trajectory)
def _(trajectory, effort, gain, target, t):
    (x, rate, _), n = reference_at(trajectory, t), len(target)
    for i in range(len(x)):
        effort = effort + gain[i] * (x[i] - target[i]) + gain[n + i] * rate[i]
    return effort


@generic
def feedback(row, law, t, q, v):
    """Return the efforts of a linked list of rows as a tuple."""
    return ()


@feedback.register(GainRow)
def _(row, law, t, q, v):
    target, n = law.target, len(law.target)
    effort = add_path_feedback(law.trajectory, row.effort, row.gain, target, t)
    for i in range(n):
        effort = (
            effort
            - row.gain[i] * (nominal_coordinate(q, i, n) - target[i])
            - row.gain[n + i] * nominal_coordinate(v, i, n)
        )
    return (effort, *feedback(row.tail, law, t, q, v))


@system.command.register(LqrLaw)
def _(law, t, q, v):
    return feedback(law.rows, law, t, q, v)


@system.effort.register(LqrLaw)
def _(u, p, t, x):
    return saturated_feedback(u, p, t, x)


@routine
def saturated_feedback(law, p, t, x):
    """Return the efforts (nu,) of the law in state x of model p at t; not inlined: called once per stage."""
    q, v = system.joints(p, x)
    return system.saturate(p, feedback(law.rows, law, t, q, v))


@entry_point
def compute_efforts(law, t, q, v):
    """Compiled `command` for calls from Python."""
    return feedback(law.rows, law, t, q, v)


class Settings(NamedTuple):
    """Weights; for any crane. It goes to `reference.q` or follows a `reference.path` of joints (`overhead_shaped`).

    The equations are linearised at the mean of what disturbs the crane: the base at the mean of its motion, constant
    forces, the offsets of sines and the means of tables; `nominal` says what the law takes instead.
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
    (law,) = build_many([settings], [nominal])
    if isinstance(law, SceneError):
        raise law
    return law


def build_many(settings: Sequence[Mapping[str, Any]], nominals: Sequence[Scene]) -> list[LqrLaw | SceneError]:
    """Return the law of each of many scenes, or the error that `build` raises for it, in a fraction of the time."""
    scenes = [without_dry_friction(nominal) for nominal in nominals]
    laws: list[Any] = [_options_of(*pair) for pair in zip(settings, scenes, strict=True)]
    sound = [i for i, law in enumerate(laws) if not isinstance(law, SceneError)]
    alike = dict[Any, list[_Plant]]()
    for i, plant in zip(sound, _make_plants([scenes[i] for i in sound], [laws[i] for i in sound]), strict=True):
        laws[i] = plant
        if not isinstance(plant, SceneError):
            alike.setdefault((plant.period is None, plant.b.shape), []).append(plant)
    made = {id(plant): law for plants in alike.values() for plant, law in zip(plants, _make_laws(plants), strict=True)}
    return [made.get(id(law), law) for law in laws]


def _options_of(settings: Mapping[str, Any], scene: Scene) -> "Settings | SceneError":
    """Return the weights as they are given, or what is wrong with them or with the path."""
    try:
        options = read_settings(Settings, settings)
        if scene.path is not None and not scene.path.of_joints:
            raise SceneError("reference.path.of = 'payload': control.law = 'lqr' follows paths of the joints only")
    except ForeignSetting as error:
        return ForeignSetting(error.key, error.known, "lqr")
    except SceneError as error:
        return error
    return options


class _Plant(NamedTuple):
    """What the regulator of one scene is computed from; m deviations are free."""

    scene: Scene
    rest: tuple[Array, Array]  # joint positions (nq,) and efforts (nu,) that are held
    a: Array  # (m, m)
    b: Array  # (m, nu)
    q: Array  # (m, m), weights
    r: Array  # (nu,)
    to_joints: Array  # (2 nq, m), joint positions and velocities of the deviations
    period: float | None  # s, between commands; None: continuous


def _make_plants(scenes: Sequence[Scene], options: Sequence["Settings"]) -> list[_Plant | SceneError]:
    """Return the linear equations of scenes about rest at their targets, or the error where there is no rest."""
    plants: list[Any] = equilibria(scenes)
    for group in by_kind(scenes):
        held = [i for i in group if not isinstance(plants[i], SceneError)]
        rests = [plants[i] for i in held]
        matrices = state_matrices_of([scenes[i] for i in held], *zip(*rests, strict=True)) if held else []
        for i, rest, (a, b) in zip(held, rests, matrices, strict=True):
            try:
                plants[i] = _make_plant(options[i], scenes[i], rest, a, b)
            except SceneError as error:
                plants[i] = error
    return plants


def _make_plant(options: "Settings", scene: Scene, rest: tuple[Array, Array], a: Array, b: Array) -> _Plant:
    moving = np.flatnonzero(np.tile(~imposed_rows(a, b), 2))
    basis = tangent_basis(scene, rest[0])
    to_joints = np.asarray(block_diag(basis, basis), np.float64)[:, moving]
    q, r = _weights(options, scene, basis @ b[basis.shape[1] :])
    weights = to_joints.T @ np.diag(q) @ to_joints
    period = scene.period if scene.sampled else None
    return _Plant(scene, rest, a[np.ix_(moving, moving)], b[moving], weights, r, to_joints, period)


def _make_laws(plants: Sequence[_Plant]) -> list[LqrLaw | SceneError]:
    """Return the laws of plants of one shape, or the error of one that has no regulator."""
    parts = (np.array([getattr(plant, name) for plant in plants]) for name in ("a", "b", "q", "r"))
    found = regulators(*parts, [plant.period for plant in plants])
    pairs = zip(plants, found, strict=True)
    return [each if isinstance(each, SceneError) else _make_law(plant, *each) for plant, each in pairs]


def _make_law(plant: _Plant, gain: Array, poles: Any) -> LqrLaw:
    target, efforts = plant.rest
    rows = None
    for effort, row in zip(efforts[::-1], (gain @ plant.to_joints.T)[::-1], strict=True):
        rows = GainRow(float(effort), row.copy(), rows)
    return LqrLaw(rows, target, plant.scene.path, poles)


def _weights(options: Settings, scene: Scene, accelerations: Array) -> tuple[Array, Array]:
    """Return the weights q (2 nq,) and r (nu,), with the joint accelerations (nq, nu) of a unit of each effort."""
    joints, actuated = list(scene.joint_names), list(scene.actuated)
    own = accelerations[[joints.index(name) for name in actuated], range(len(actuated))]
    scales = np.array([DEVIATIONS[unit] for unit in scene.joint_units])
    q = scales.T.ravel() ** -2.0 if options.q is None else np.array(options.q)
    r = own**2 if options.r is None else np.array(options.r)
    for name, weights, size, what in (
        ("q", q, 2 * len(joints), f"of the positions, then of the velocities, of {shorten(joints)}"),
        ("r", r, len(actuated), f"one per actuated joint, {shorten(actuated)}"),
    ):
        if len(weights) != size:
            raise SceneError(f"control.{name}: has {len(weights)} weights, {size} are needed: {what}")
    return q, r
