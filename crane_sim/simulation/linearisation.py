"""A scene about a point where it can be held: the point, and the linear equations of deviations.

All of it is about the mean of what disturbs the crane (`crane_sim.scenes.averaging`), not about one instant of a wave
or gust.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag, null_space

from crane_sim.files.errors import SceneError
from crane_sim.scenes.averaging import average_scene
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.dynamics import acceleration

Array = npt.NDArray[np.float64]
STEP = 1e-5  # of central differences: their error is about STEP squared, rounding 1e-16 / STEP, both 1e-10
ZERO_ACCELERATION = 1e-9  # m/s² or rad/s²: accelerations that count as none
ITERATIONS = 50  # of Newton's method
MAX_TURN = 0.5  # rad, in one of them: full steps from below may end a turn further, or above the suspension


def without_dry_friction(scene: Scene) -> Scene:
    """Return the scene with viscous friction only: dry friction jumps where the equations are to be linearised.

    So does that of bristles. A winch below a support loses all of its friction, and sheaves their loss.
    """
    document = scene.to_dict()
    friction, rope = document.get("friction") or {}, document.get("rope") or {}
    bristles = document.pop("lugre", None) or {}
    sheaves = (rope.get("reeving") or {}).get("sheaves") or {}
    removed = rope.pop("friction", None), sheaves.pop("loss", None)
    if not friction and not bristles and not any(removed):
        return scene
    none, viscous = {"coulomb": 0.0, "static": 0.0}, {"viscous": 0.0}
    rubbing = {joint: group | none for joint, group in friction.items() if group}
    creeping = {joint: none | {"viscous": (viscous | group)["viscous"]} for joint, group in bristles.items() if group}
    if rubbing or creeping:
        document["friction"] = rubbing | creeping
    return replace(load_scene(document), period=scene.period, sampled=scene.sampled)


def equilibrium(scene: Scene) -> tuple[Array, Array]:
    """Return (joint positions (nq,), efforts (nu,)) that hold the actuated joints at the reference, the others hanging.

    Raises:
        SceneError: there is no target, or no joint to command, or Newton's method finds nothing that stays at rest.
    """
    if scene.reference is None or not scene.actuated:
        raise SceneError(f"reference: LQR needs a target of commanded joints; actuated are {scene.actuated}")
    scene, target = average_scene(scene), scene.reference
    q, u = hanging_positions(scene, target), np.zeros(len(scene.actuated))
    actuated = [scene.joint_names.index(name) for name in scene.actuated]
    for _ in range(ITERATIONS):
        qdd = acceleration(scene, q, np.zeros(len(q)), u)
        if not np.all(np.isfinite(qdd)):
            break
        (a, b), basis = state_matrices(scene, q, u), tangent_basis(scene, q)
        n = basis.shape[1]
        rounding = 1e-15 * np.max(np.abs(a[n:, :n])) * (1.0 + np.max(np.abs(q)))  # of stiff springs' accelerations
        if np.max(np.abs(qdd)) < ZERO_ACCELERATION + rounding:
            return q, u
        free = ~(imposed_rows(a, b) | np.any(basis[actuated] != 0.0, axis=0))
        step = np.linalg.lstsq(np.hstack([a[n:, :n][:, free], b[n:]]), -basis.T @ qdd)[0]
        dq, du = basis[:, free] @ step[: free.sum()], step[free.sum() :]
        scale = _step_scale(scene, dq)
        q, u = _normalise(scene, q + scale * dq), u + scale * du
    raise SceneError(f"reference.q = {list(target)}: no efforts hold the crane at rest there")


def hanging_positions(scene: Scene, reference: tuple[float, ...]) -> Array:
    """Return the joint positions (nq,) at the reference with the cable straight down, or those that the form has."""
    if (rest := scene.file.rest_positions(reference)) is not None:
        return np.array(rest, dtype=float)
    down = {"rad": 0.0}
    start = zip(scene.joint_names, scene.joint_units, scene.initial_q, strict=True)
    upright = {"_z": -1.0, "qw": 1.0}
    q = np.array([upright.get(name[-2:], 0.0) if unit == "1" else down.get(unit, x) for name, unit, x in start])
    q[[scene.joint_names.index(name) for name in scene.actuated]] = reference
    return q


def _step_scale(scene: Scene, dq: Array) -> float:
    """Return the part of a Newton step dq (nq,) that turns no joint further than MAX_TURN."""
    turns = np.abs(dq[[unit != "m" for unit in scene.joint_units]])
    return min(1.0, MAX_TURN / np.max(turns, initial=MAX_TURN))


def _unit_vectors(scene: Scene) -> dict[int, int]:
    """Return the size of every unit vector (3) or quaternion (4) among the joint positions, by its first index."""
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
    """Return an orthonormal basis (nq, n) of the deviations from q (nq,) that keep unit vectors of length 1.

    A unit vector has two and a quaternion three, perpendicular to it; any other joint its own. Without them it is the
    identity.
    """
    sizes, blocks, i = _unit_vectors(scene), [], 0
    if not sizes:
        return np.eye(len(q))
    while i < len(q):
        blocks.append(null_space(q[None, i : i + sizes[i]]) if i in sizes else np.eye(1))
        i += len(blocks[-1])
    return np.asarray(block_diag(*blocks), np.float64)


def state_matrices(scene: Scene, q: Array, u: Array) -> tuple[Array, Array]:
    """Return A (2 n, 2 n) and B (2 n, nu) of the deviations from rest at q (nq,) under efforts u (nu,).

    The n deviations are the coordinates in the tangent basis at q, then come their rates.
    """
    scene, basis = average_scene(scene), tangent_basis(scene, q)
    nq, n = basis.shape
    directions = np.asarray(block_diag(basis, basis, np.eye(len(u))), np.float64)
    at, columns = np.concatenate([q, np.zeros(nq), u]), []
    for direction in directions.T:
        rows = [
            acceleration(scene, z[:nq], z[nq : 2 * nq], z[2 * nq :])
            for z in (at + STEP * direction, at - STEP * direction)
        ]
        columns.append(basis.T @ ((rows[0] - rows[1]) / (2.0 * STEP)))
    derivatives = np.array(columns).T
    rates = np.hstack([np.zeros((n, n)), np.eye(n)])
    return np.vstack([rates, derivatives[:, : 2 * n]]), np.vstack([np.zeros((n, len(u))), derivatives[:, 2 * n :]])


def imposed_rows(a: Array, b: Array) -> npt.NDArray[np.bool_]:
    """Return which of the n deviations of A (2 n, 2 n), B (2 n, nu) nothing accelerates: those of imposed joints."""
    return ~np.any(np.hstack([a, b])[len(a) // 2 :] != 0.0, axis=1)
