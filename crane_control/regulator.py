"""The linear-quadratic regulator of linear equations."""

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm, solve_continuous_are, solve_discrete_are

from crane_sim.files.errors import SceneError

Array = npt.NDArray[np.float64]
Poles = npt.NDArray[np.complex128]
# 1/s: poles nearer to the stability limit count as on it, by the linearisation's error
STABILITY_TOLERANCE = 1e-6


def solve_regulator(
    a: Array, b: Array, q: Array, r: Array, period: float | None
) -> tuple[Array, Poles]:
    """Return (gain (nu, m), closed-loop eigenvalues (m,)) of x' = a x + b u, a (m, m), b (m, nu).

    Args:
        a, b: of the equations.
        q, r: weights of the states (m, m), positive semi-definite, and of the efforts (nu,).
        period: s, of commands that are held; None: they are continuous.

    Raises:
        SceneError: no regulator makes all motions decay: the plant cannot be stabilised, or a
            motion that does not decay by itself has no weight.
    """
    weights, solve = np.diag(r), _solve_continuous
    if period is not None:
        a, b = _sampled(a, b, period)
        solve = solve_discrete_are
    try:
        p = solve(a, b, q, weights)
    except np.linalg.LinAlgError:
        p = np.zeros_like(q)
    product = b.T @ p
    gain = (
        np.linalg.solve(weights, product)
        if period is None
        else np.linalg.solve(weights + product @ b, product @ a)
    )
    poles = np.linalg.eigvals(a - b @ gain).astype(np.complex128)
    exponents = poles if period is None else np.log(poles) / period
    slowest = exponents[exponents.real.argmax()]
    if slowest.real > -STABILITY_TOLERANCE or not np.any(p):
        raise _undamped_error(abs(slowest.imag), bool(np.all(np.diag(q) > 0.0)))
    return np.asarray(gain, np.float64), poles


def _solve_continuous(a: Array, b: Array, q: Array, weights: Array) -> Any:
    """Return the solution of the continuous Riccati equation, as `solve_continuous_are` does."""
    try:
        return solve_continuous_are(a, b, q, weights)
    except ValueError:  # weights that differ by more than it takes: with efforts scaled by them
        scale = np.sqrt(np.diag(weights))
        return solve_continuous_are(a, b / scale, q, np.eye(len(scale)))


def _sampled(a: Array, b: Array, period: float) -> tuple[Any, Any]:
    """Return a and b of the next state of a plant whose efforts are held for a period [s]."""
    m, nu = b.shape
    rates = np.zeros((m + nu, m + nu))
    rates[:m, :m], rates[:m, m:] = a, b
    transition = expm(period * rates)
    return transition[:m, :m], transition[:m, m:]


def _undamped_error(frequency: float, has_state_weights: bool) -> SceneError:
    """Return the error of a motion of this frequency [rad/s] that does not decay."""
    # a double pole at 0 parts by its error's root
    frequency = frequency if frequency > STABILITY_TOLERANCE else 0.0
    # where all states have a weight, the regulator stabilises every motion that efforts can
    # influence
    reason = (
        "no effort damps it"
        if has_state_weights
        else "no effort damps it, or its states have no weight"
    )
    return SceneError(
        f"control.law = 'lqr': a motion of {frequency:.3g} rad/s about the target stays: {reason}"
    )
