"""A scene about a point where it can be held: the point, and the linear equations of deviations.

All of it is about the mean of what disturbs the crane (`crane_sim.scenes.averaging`), not about one
instant of a wave or gust.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import sin
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag, null_space

from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.numerics.derivatives import DIRECTIONS, directional_derivatives
from crane_sim.numerics.jit import LIGHT, entry_point, optimisation
from crane_sim.numerics.lanes import take_entry
from crane_sim.scenes.averaging import average_scene
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.columns import group_indices, kind_of, stack_columns
from crane_sim.simulation.dynamics import joint_acceleration

Array = npt.NDArray[np.float64]
ZERO_ACCELERATION = 1e-9  # m/s² or rad/s²: accelerations that count as none
ITERATIONS = 50  # of Newton's method
DISSIPATIVE = {"friction", "lugre", "rope", "hoist"}
"""Groups that may have dry friction."""
REACH = 1e-8  # to both sides of a point: far enough for a mode to change, and 1e-16 of what bends
ROUNDING = 1e-12  # of the largest acceleration along a direction: what counts as none
# rad, in one of them: full steps from below may end a turn further, or above the suspension
MAX_TURN = 0.5


def without_dry_friction(scene: Scene) -> Scene:
    """Return the scene with viscous friction only.

    Dry friction jumps where the equations are to be linearised.

    So does that of bristles. A winch below a support loses all of its friction, and sheaves their
    loss.
    """
    if not scene.document.keys() & DISSIPATIVE:
        return scene
    document = scene.to_dict()
    friction, bristles, removed = (
        document.get("friction") or {},
        document.pop("lugre", None) or {},
        list[object](),
    )
    for winch in (document.get("rope") or {}, document.get("hoist") or {}):
        sheaves = (winch.get("reeving") or {}).get("sheaves") or {}
        removed += [winch.pop("friction", None), sheaves.pop("loss", None)]
    if not friction and not bristles and not any(removed):
        return scene
    none, viscous = {"coulomb": 0.0, "static": 0.0}, {"viscous": 0.0}
    rubbing = {joint: group | none for joint, group in friction.items() if group}
    creeping = {
        joint: none | {"viscous": (viscous | group)["viscous"]}
        for joint, group in bristles.items()
        if group
    }
    if rubbing or creeping:
        document["friction"] = rubbing | creeping
    return replace(load_scene(document), period=scene.period, sampled=scene.sampled)


def acceleration_at(p, z, nq):
    """Return the joint accelerations (nq,) at t = 0 at z (2 nq + nu,).

    z: joint positions, velocities and efforts.
    """
    return joint_acceleration(
        p, 0.0, z[:nq], z[nq : 2 * nq], system.efforts_from_row(p, z[2 * nq :])
    )


@entry_point
@optimisation(LIGHT)
def fill_accelerations(models, points, directions, out, slopes):
    """Fill `out` (n, nq) with accelerations, `slopes` (n, k, nq) with directional derivatives.

    At a kink a derivative is the mean of those of both sides.

    Args:
        models: columns of the cranes' models.
        points: joint positions, velocities and efforts (n, m), m = 2 nq + nu.
        directions: of each crane's point (n, k, m).
        out: to fill with accelerations.
        slopes: to fill with derivatives.
    """
    nq, size, count = out.shape[1], points.shape[1], directions.shape[1]
    z, seeds = np.empty(size), np.zeros((size, DIRECTIONS))
    for i in range(len(points)):
        p = take_entry(models, i)
        for side in range(3):  # before the point, behind it, and at it
            move_aside(points[i], directions[i], REACH * (2.0 * side - 1.0) if side < 2 else 0.0, z)
            for first in range(0, count if side < 2 else 1, DIRECTIONS):
                last = min(first + DIRECTIONS, count)
                for j in range(size):
                    for k in range(first, last):
                        seeds[j, k - first] = directions[i, k, j]
                qdd, rows = directional_derivatives(
                    acceleration_at, (p, z, nq), (None, seeds, None)
                )
                for j in range(len(qdd)):
                    out[i, j] = qdd[j]
                    for k in range(first, last if side < 2 else first):
                        slopes[i, k, j] = 0.5 * rows[j][k - first] + (
                            slopes[i, k, j] if side == 1 else 0.0
                        )


def move_aside(point, directions, distance, z):
    """Write into z the point at a distance from `point`, in a direction parallel to no kink.

    The direction is a mixture of `directions`.
    """
    for j in range(len(z)):
        z[j] = point[j]
    for k in range(len(directions)):
        weight = distance * (1.0 + sin(k + 1.0) ** 2)
        for j in range(len(z)):
            z[j] += weight * directions[k, j]


class Accelerations(NamedTuple):
    """Joint accelerations of c cranes at t = 0, each at its own point z.

    z: joint positions, velocities and efforts.
    """

    values: Array  # (c, nq)
    slopes: Array  # (c, k, nq), derivatives along directions of z


def accelerations(scenes: Sequence[Scene], points: Array, directions: Array) -> Accelerations:
    """Return accelerations of scenes of one kind and their slopes along directions.

    Points (c, 2 nq + nu), directions (c, k, 2 nq + nu).
    """
    nq = len(scenes[0].joint_names)
    found = Accelerations(np.empty((len(points), nq)), np.empty((*directions.shape[:2], nq)))
    fill_accelerations(stack_columns([scene.model for scene in scenes]), points, directions, *found)
    return found


def equilibria(scenes: Sequence[Scene]) -> list[tuple[Array, Array] | SceneError]:
    """Return what `equilibrium` returns for each of the scenes, or the error that it raises.

    Most cranes that hang straight down are at rest without efforts, which is seen for all scenes of
    a kind at once.
    """
    found: list[tuple[Array, Array] | SceneError] = []
    for scene, rests in zip(scenes, _hang_at_rest(scenes), strict=True):
        try:
            found.append(rests or equilibrium(scene))
        except SceneError as error:
            found.append(error)
    return found


def _hang_at_rest(scenes: Sequence[Scene]) -> list[tuple[Array, Array] | None]:
    """Return (positions, zero efforts) of the scenes that rest where they hang straight down."""
    found: list[tuple[Array, Array] | None] = [None] * len(scenes)
    for group in by_kind(scenes):
        first = scenes[group[0]]
        if first.reference is None or not first.actuated:
            continue
        own = [average_scene(scenes[i]) for i in group]
        q = np.array(
            [
                hanging_positions(scene, scene.reference)
                for scene in own
                if scene.reference is not None
            ]
        )
        points = np.concatenate([q, np.zeros((len(q), q.shape[1] + len(first.actuated)))], axis=1)
        qdd = accelerations(own, points, np.zeros((len(q), 1, points.shape[1]))).values
        for i, at, rates in zip(group, q, np.abs(qdd).max(axis=1), strict=True):
            if rates < ZERO_ACCELERATION:
                found[i] = at, np.zeros(len(first.actuated))
    return found


def by_kind(scenes: Sequence[Scene]) -> list[list[int]]:
    """Return the indices of scenes whose models are of one kind, group by group."""
    return group_indices(
        (kind_of(scene.model), scene.joint_names, scene.actuated) for scene in scenes
    )


def equilibrium(scene: Scene) -> tuple[Array, Array]:
    """Return (positions (nq,), efforts (nu,)) that hold actuated joints at the reference.

    The other joints hang.

    Raises:
        SceneError: there is no target, or no joint to command, or Newton's method finds nothing
            that stays at rest.
    """
    if scene.reference is None or not scene.actuated:
        raise SceneError(
            f"reference: LQR needs a target of commanded joints; actuated are {scene.actuated}"
        )
    scene, target = average_scene(scene), scene.reference
    q, u = hanging_positions(scene, target), np.zeros(len(scene.actuated))
    for _ in range(ITERATIONS):
        basis = tangent_basis(scene, q)
        found = accelerations([scene], _points([q], [u]), _directions([basis], len(u)))
        qdd, (a,), (b,) = found.values[0], *_to_state_matrices(found.slopes, [basis])
        if not np.all(np.isfinite(qdd)):
            break
        if np.max(np.abs(qdd)) < ZERO_ACCELERATION:
            return q, u
        n = basis.shape[1]
        # of stiff springs' accelerations
        rounding = 1e-15 * np.max(np.abs(a[n:, :n])) * (1.0 + np.max(np.abs(q)))
        if np.max(np.abs(qdd)) < ZERO_ACCELERATION + rounding:
            return q, u
        dq, du = _newton_step(scene, basis, qdd, a, b)
        scale = _step_scale(scene, dq)
        q, u = _normalise(scene, q + scale * dq), u + scale * du
    raise SceneError(f"reference.q = {list(target)}: no efforts hold the crane at rest there")


def _newton_step(
    scene: Scene, basis: Array, qdd: Array, a: Array, b: Array
) -> tuple[Array, npt.NDArray[np.floating]]:
    """Return the changes of positions and of efforts (nu,) after which nothing accelerates."""
    n = basis.shape[1]
    actuated = [scene.joint_names.index(name) for name in scene.actuated]
    free = ~(imposed_rows(a, b) | np.any(basis[actuated] != 0.0, axis=0))
    # else a load turns by rounding
    pulls = a[n:, :n] * (np.abs(a[n:, :n]) > ROUNDING * np.max(np.abs(a)))
    step = np.linalg.lstsq(np.hstack([pulls[:, free], b[n:]]), -basis.T @ qdd)[0]
    return basis[:, free] @ step[: free.sum()], step[free.sum() :]


def hanging_positions(scene: Scene, reference: tuple[float, ...]) -> Array:
    """Return the joint positions (nq,) at the reference with the cable straight down.

    Those that the file gives take precedence.
    """
    if (rest := scene.file.rest_positions(reference)) is not None:
        return np.array(rest, np.float64)
    down = {"rad": 0.0}
    start = zip(scene.joint_names, scene.joint_units, scene.initial_q, strict=True)
    upright = {"_z": -1.0, "qw": 1.0}
    q = np.array(
        [
            upright.get(name[-2:], 0.0) if unit == "1" else down.get(unit, x)
            for name, unit, x in start
        ]
    )
    q[[scene.joint_names.index(name) for name in scene.actuated]] = reference
    return q


def _step_scale(scene: Scene, dq: Array) -> float:
    """Return the part of a Newton step dq (nq,) that turns no joint further than MAX_TURN."""
    turns = np.abs(dq[[unit != "m" for unit in scene.joint_units]])
    return min(1.0, MAX_TURN / np.max(turns, initial=MAX_TURN))


def _unit_vectors(scene: Scene) -> dict[int, int]:
    """Return the size of each unit vector (3) or quaternion (4) in the joints, by first index."""
    starts = {"_x": 3, "_qw": 4}
    return {
        i: size
        for i, (name, unit) in enumerate(zip(scene.joint_names, scene.joint_units, strict=True))
        for end, size in starts.items()
        if unit == "1" and name.endswith(end)
    }


def _normalise(scene: Scene, q: Array) -> Array:
    """Return joint positions (nq,) with unit vectors of length 1."""
    for i, size in _unit_vectors(scene).items():
        q[i : i + size] /= np.linalg.norm(q[i : i + size])
    return q


def tangent_basis(scene: Scene, q: Array) -> Array:
    """Return an orthonormal basis (nq, n) of deviations from q (nq,) that keep unit lengths.

    A unit vector has two and a quaternion three, perpendicular to it; any other joint its own.
    Without them it is the identity.
    """
    sizes, blocks, i = _unit_vectors(scene), [], 0
    if not sizes:
        return np.eye(len(q))
    while i < len(q):
        blocks.append(null_space(q[None, i : i + sizes[i]]) if i in sizes else np.eye(1))
        i += len(blocks[-1])
    return np.asarray(block_diag(*blocks), np.float64)


def state_matrices(scene: Scene, q: Array, u: Array) -> tuple[Array, Array]:
    """Return A (2 n, 2 n) and B (2 n, nu) about rest at q (nq,) under efforts u (nu,).

    The n deviations are the coordinates in the tangent basis at q, then come their rates.
    """
    a, b = state_matrices_of([scene], [q], [u])
    return a[0], b[0]


def state_matrices_of(
    scenes: Sequence[Scene], q: Sequence[Array], u: Sequence[Array]
) -> tuple[Array, Array]:
    """Return A (c, 2 n, 2 n) and B (c, 2 n, nu) of c scenes of one kind, see `state_matrices`."""
    bases = [tangent_basis(scene, x) for scene, x in zip(scenes, q, strict=True)]
    averaged = [average_scene(scene) for scene in scenes]
    found = accelerations(averaged, _points(q, u), _directions(bases, len(u[0])))
    return _to_state_matrices(found.slopes, bases)


def _points(q: Sequence[Array], u: Sequence[Array]) -> Array:
    """Return the points (c, 2 nq + nu) of rest at joint positions (nq,) under efforts (nu,)."""
    return np.array(
        [np.concatenate([x, np.zeros(len(x)), efforts]) for x, efforts in zip(q, u, strict=True)]
    )


def _directions(bases: Sequence[Array], nu: int) -> Array:
    """Return directions (c, 2 n + nu, 2 nq + nu) of deviations, their rates and efforts.

    Deviations and rates are in tangent bases.
    """
    across = np.swapaxes(bases, 1, 2)
    count, n, nq = across.shape
    directions = np.zeros((count, 2 * n + nu, 2 * nq + nu))
    directions[:, :n, :nq] = directions[:, n : 2 * n, nq : 2 * nq] = across
    directions[:, 2 * n :, 2 * nq :] = np.eye(nu)
    return directions


def _to_state_matrices(slopes: Array, bases: Sequence[Array]) -> tuple[Array, Array]:
    """Return A and B from derivatives (c, 2 n + nu, nq) of accelerations along `_directions`."""
    rows = np.swapaxes(
        [each @ basis + 0.0 for each, basis in zip(slopes, bases, strict=True)], 1, 2
    )
    count, n, size = rows.shape
    a, b = np.zeros((count, 2 * n, 2 * n)), np.zeros((count, 2 * n, size - 2 * n))
    a[:, :n, n:], a[:, n:], b[:, n:] = np.eye(n), rows[:, :, : 2 * n], rows[:, :, 2 * n :]
    return a, b


def imposed_rows(a: Array, b: Array) -> npt.NDArray[np.bool_]:
    """Return which of the n deviations nothing accelerates, those of imposed joints.

    A is (…, 2 n, 2 n), B (…, 2 n, nu).
    """
    slopes = np.abs(np.concatenate([a, b], axis=-1)[..., a.shape[-1] // 2 :, :])
    largest = slopes.max(axis=-2, keepdims=True)
    # one may have nothing but rounding
    sizes = np.maximum(largest, REACH * largest.max(axis=-1, keepdims=True))
    return ~np.any(slopes > ROUNDING * sizes, axis=-1)
