"""The linear-quadratic regulator of linear equations, for one plant or many."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm

from crane_control.riccati import solve_riccati
from crane_sim.files.errors import SceneError

Array = npt.NDArray[np.float64]
Poles = npt.NDArray[np.complex128]
STABILITY_TOLERANCE = 1e-6  # 1/s: poles nearer to the stability limit count as on it, by the linearisation's error


class Regulators(NamedTuple):
    """Regulators of n plants, and which of them are valid."""

    gains: Array  # (n, nu, m)
    poles: Poles  # (n, m), closed-loop eigenvalues
    dominant: Poles  # (n,) 1/s, exponents of the closed-loop motions that decay most slowly
    valid: npt.NDArray[np.bool_]  # (n,), whether those decay; not where the plant cannot be stabilised, or a motion
    # that does not decay by itself has no state weight


def solve_regulators_or_errors(
    a: Array, b: Array, q: Array, r: Array, periods: Sequence[float | None]
) -> list[tuple[Array, Poles] | SceneError]:
    """Return (gain (nu, m), closed-loop eigenvalues (m,)) of each of n plants, or an error where it has no regulator.

    The arguments are those of `solve_regulators`.
    """
    found = solve_regulators(a, b, q, r, periods)
    has_state_weights = np.all(np.einsum("nii->ni", q) > 0.0, axis=1)
    return [
        (gain, poles) if valid else _undamped_error(abs(exponent.imag), bool(has_weights))
        for gain, poles, exponent, valid, has_weights in zip(*found, has_state_weights, strict=True)
    ]


def solve_regulators(a: Array, b: Array, q: Array, r: Array, periods: Sequence[float | None]) -> Regulators:
    """Return the regulators of n plants.

    Args:
        a, b: of x' = a x + b u, (n, m, m) and (n, m, nu).
        q, r: weights of the states (n, m, m), positive semi-definite, and of the efforts (n, nu).
        periods: s, of commands that are held; None: continuous. Either all are None or none is.
    """
    n, m, nu = b.shape
    period = np.array([1.0 if each is None else each for each in periods])
    sampled, weights = periods[0] is not None, r[:, :, None] * np.eye(nu)
    if sampled:
        rates = np.zeros((n, m + nu, m + nu))
        rates[:, :m, :m], rates[:, :m, m:] = a, b
        transition = np.asarray(expm(period[:, None, None] * rates), np.float64)
        a, b = transition[:, :m, :m], transition[:, :m, m:]
    p, solved = solve_riccati(a, b, q, weights, sampled)
    p[~solved] = 0.0  # no solution: gains of zero, which makes the regulator invalid
    product = np.swapaxes(b, 1, 2) @ p
    gains = np.linalg.solve(weights + product @ b, product @ a) if sampled else np.linalg.solve(weights, product)
    poles = np.linalg.eigvals(a - b @ gains).astype(np.complex128)
    exponents = np.log(poles) / period[:, None] if sampled else poles
    dominant = np.take_along_axis(exponents, exponents.real.argmax(axis=1)[:, None], 1)[:, 0]
    undamped = (dominant.real > -STABILITY_TOLERANCE) | ~np.any(p, axis=(1, 2))
    return Regulators(np.asarray(gains, np.float64), poles, dominant.astype(np.complex128), ~undamped)


def _undamped_error(frequency: float, has_state_weights: bool) -> SceneError:
    """Return the error of a motion of this frequency [rad/s] that does not decay."""
    frequency = frequency if frequency > STABILITY_TOLERANCE else 0.0  # a double pole at 0 parts by its error's root
    # where all states have a weight, the regulator stabilises every motion that efforts can influence
    reason = "no effort damps it" if has_state_weights else "no effort damps it, or its states have no weight"
    return SceneError(f"control.law = 'lqr': a motion of {frequency:.3g} rad/s about the target stays: {reason}")
