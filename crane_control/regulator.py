"""The linear-quadratic regulator of linear equations."""

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import LinAlgError, expm, solve_continuous_are, solve_discrete_are

from crane_sim.files.errors import SceneError

Array = npt.NDArray[np.float64]
Poles = npt.NDArray[np.complex128]
STABILITY_TOLERANCE = 1e-6  # 1/s: poles nearer to the stability limit count as on it; error of the differences


def regulator(a: Array, b: Array, q: Array, r: Array, period: float | None) -> tuple[Array, Poles]:
    """Return (gain (nu, n), closed-loop eigenvalues (n,)) for weights q (n, n), r (nu,).

    Args:
        a, b: of x' = a x + b u, (n, n) and (n, nu).
        q, r: weights of the states, positive semi-definite, and of the efforts.
        period: s, between commands that are held; None: continuous.

    Raises:
        SceneError: the linearisation is not stabilisable, or a motion has no weight.
    """
    n, nu = b.shape
    if period is not None:
        transition = np.asarray(expm(period * np.block([[a, b], [np.zeros((nu, n + nu))]])), np.float64)
        a, b = transition[:n, :n], transition[:n, n:]
    try:
        p: Any = (solve_continuous_are if period is None else solve_discrete_are)(a, b, q, np.diag(r))
    except LinAlgError:
        p = np.zeros((n, n))  # no solution: nothing would change
    hessian = np.diag(r) + (0.0 if period is None else b.T @ p @ b)
    gain = np.asarray(np.linalg.solve(hessian, b.T @ p @ (a if period is not None else np.eye(n))), np.float64)
    poles = np.linalg.eigvals(a - b @ gain).astype(np.complex128)
    exponents = poles if period is None else np.log(poles) / period
    slowest = exponents[exponents.real.argmax()]
    if slowest.real > -STABILITY_TOLERANCE or not np.any(p):
        # where everything is weighed, the best law damps all that efforts reach
        reason = "no effort damps it" if np.all(np.diag(q) > 0.0) else "no effort damps it, or no weight asks for it"
        raise SceneError(
            f"control.law = 'lqr': a motion of {abs(slowest.imag):.3g} rad/s about the target stays: {reason}"
        )
    return gain, poles
