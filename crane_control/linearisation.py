"""A scene about a point where it can be held: the point, the linear equations of deviations, the best linear law.

All of it is about the mean of what disturbs the crane (`crane_sim.scenes.averaging`), not about one instant of a wave
or gust.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import LinAlgError, expm, solve_continuous_are, solve_discrete_are

from crane_sim.files.errors import SceneError
from crane_sim.scenes.averaging import average_scene
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.dynamics import acceleration

Array = npt.NDArray[np.float64]
Poles = npt.NDArray[np.complex128]
STEP = 1e-5  # of central differences: their error is about STEP squared, rounding 1e-16 / STEP, both 1e-10
ZERO_ACCELERATION = 1e-9  # m/s² or rad/s²: accelerations that count as none
STABILITY_TOLERANCE = 1e-6  # 1/s: poles nearer to the stability limit count as on it; error of the differences


def without_dry_friction(scene: Scene) -> Scene:
    """Return the scene with viscous friction only: dry friction jumps where the equations are to be linearised."""
    document = scene.to_dict()
    friction = document.get("friction")
    if not friction:
        return scene
    document["friction"] = {axis: group | {"coulomb": 0.0, "static": 0.0} for axis, group in friction.items() if group}
    return replace(load_scene(document), period=scene.period, sampled=scene.sampled)


def equilibrium(scene: Scene) -> tuple[Array, Array]:
    """Return (joint positions (nq,), efforts (nu,)) that hold the actuated joints at the reference, the others hanging.

    Raises:
        SceneError: there is no target, or no joint to command, or Newton's method finds nothing that stays at rest.
    """
    if scene.reference is None or not scene.actuated:
        raise SceneError(f"reference: LQR needs a target of commanded joints; actuated are {scene.actuated}")
    scene, target = average_scene(scene), scene.reference
    q, u = _hanging_positions(scene, target), np.zeros(len(scene.actuated))
    n, free = len(q), [i for i, name in enumerate(scene.joint_names) if name not in scene.actuated]
    for _ in range(20):
        qdd = acceleration(scene, q, np.zeros(n), u)
        if not np.all(np.isfinite(qdd)):
            break
        a, b = linearise(scene, q, u)
        rounding = 1e-15 * np.max(np.abs(a[n:, :n])) * (1.0 + np.max(np.abs(q)))  # of stiff springs' accelerations
        if np.max(np.abs(qdd)) < ZERO_ACCELERATION + rounding:
            return q, u
        step = np.linalg.lstsq(np.hstack([a[n:, free], b[n:]]), -qdd)[0]
        q[free] += step[: len(free)]
        u += step[len(free) :]
    raise SceneError(f"reference.q = {list(target)}: no efforts hold the crane at rest there")


def _hanging_positions(scene: Scene, reference: tuple[float, ...]) -> Array:
    """Return the joint positions (nq,) at the reference with the cable straight down."""
    down = {"rad": 0.0, "1": 0.0}
    start = zip(scene.joint_names, scene.joint_units, scene.initial_q, strict=True)
    q = np.array([-1.0 if unit == "1" and name.endswith("_z") else down.get(unit, x) for name, unit, x in start])
    q[[scene.joint_names.index(name) for name in scene.actuated]] = reference
    return q


def linearise(scene: Scene, q: Array, u: Array) -> tuple[Array, Array]:
    """Return A (2 nq, 2 nq) and B (2 nq, nu) of the deviations from rest at q (nq,) under efforts u (nu,)."""
    scene, n = average_scene(scene), len(q)
    a, b = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, len(u)))
    a[:n, n:] = np.eye(n)
    at = np.concatenate([q, np.zeros(n), u])
    for i in range(len(at)):
        ahead, behind = at.copy(), at.copy()
        ahead[i] += STEP
        behind[i] -= STEP
        rows = [acceleration(scene, z[:n], z[n : 2 * n], z[2 * n :]) for z in (ahead, behind)]
        column = (rows[0] - rows[1]) / (2.0 * STEP)
        if i < 2 * n:
            a[n:, i] = column
        else:
            b[n:, i - 2 * n] = column
    return a, b


def regulator(a: Array, b: Array, q: Array, r: Array, period: float | None) -> tuple[Array, Poles]:
    """Return (gain (nu, n), closed-loop eigenvalues (n,)) for weights q (n,), r (nu,).

    Args:
        a, b: of x' = a x + b u, (n, n) and (n, nu).
        q, r: weights of the states and of the efforts.
        period: s, between commands that are held; None: continuous.

    Raises:
        SceneError: a motion is not controllable, or not weighed at all.
    """
    n, nu = b.shape
    if period is not None:
        transition = np.asarray(expm(period * np.block([[a, b], [np.zeros((nu, n + nu))]])), np.float64)
        a, b = transition[:n, :n], transition[:n, n:]
    try:
        p: Any = (solve_continuous_are if period is None else solve_discrete_are)(a, b, np.diag(q), np.diag(r))
    except LinAlgError:
        p = np.zeros((n, n))  # no solution: nothing would change
    hessian = np.diag(r) + (0.0 if period is None else b.T @ p @ b)
    gain = np.asarray(np.linalg.solve(hessian, b.T @ p @ (a if period is not None else np.eye(n))), np.float64)
    poles = np.linalg.eigvals(a - b @ gain).astype(np.complex128)
    exponents = poles if period is None else np.log(poles) / period
    slowest = exponents[exponents.real.argmax()]
    if slowest.real > -STABILITY_TOLERANCE or not np.any(p):
        # where everything is weighed, the best law damps all that efforts reach
        reason = "no effort damps it" if np.all(q > 0.0) else "no effort damps it, or no weight asks for it"
        raise SceneError(
            f"control.law = 'lqr': a motion of {abs(slowest.imag):.3g} rad/s about the target stays: {reason}"
        )
    return gain, poles
