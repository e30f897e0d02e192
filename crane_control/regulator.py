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
STABILITY_TOLERANCE = 1e-6  # 1/s: poles nearer to the stability limit count as on it; error of the differences


class Regulators(NamedTuple):
    """Regulators of n plants, sound or not."""

    gains: Array  # (n, nu, m)
    poles: Poles  # (n, m), closed-loop eigenvalues
    slowest: Poles  # (n,) 1/s, exponents of the motions that take longest
    undamped: npt.NDArray[np.bool_]  # (n,), whether those stay: a plant not stabilisable, or a motion without weight


def regulators(
    a: Array, b: Array, q: Array, r: Array, periods: Sequence[float | None]
) -> list[tuple[Array, Poles] | SceneError]:
    """Return (gain (nu, m), closed-loop eigenvalues (m,)) of n plants, or the error of one that has none.

    Arguments of `solve_regulators`.
    """
    found = solve_regulators(a, b, q, r, periods)
    weighed = np.all(np.einsum("nii->ni", q) > 0.0, axis=1)
    return [
        _undamped_error(abs(rate.imag), bool(all_weighed)) if undamped else (gain, pole)
        for gain, pole, rate, undamped, all_weighed in zip(*found, weighed, strict=True)
    ]


def solve_regulators(a: Array, b: Array, q: Array, r: Array, periods: Sequence[float | None]) -> Regulators:
    """Return the regulators of n plants.

    Args:
        a, b: of x' = a x + b u, (n, m, m) and (n, m, nu).
        q, r: weights of the states (n, m, m), positive semi-definite, and of the efforts (n, nu).
        periods: s, between commands that are held; None: continuous. All are one or the other.
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
    p[~solved] = 0.0  # no solution: nothing would change
    product = np.swapaxes(b, 1, 2) @ p
    gains = np.linalg.solve(weights + product @ b, product @ a) if sampled else np.linalg.solve(weights, product)
    poles = np.linalg.eigvals(a - b @ gains).astype(np.complex128)
    exponents = np.log(poles) / period[:, None] if sampled else poles
    slowest = np.take_along_axis(exponents, exponents.real.argmax(axis=1)[:, None], 1)[:, 0]
    undamped = (slowest.real > -STABILITY_TOLERANCE) | ~np.any(p, axis=(1, 2))
    return Regulators(np.asarray(gains, np.float64), poles, slowest.astype(np.complex128), undamped)


def _undamped_error(rate: float, weighed: bool) -> SceneError:
    """Return the error of a motion of this rate [rad/s] that stays."""
    # where everything is weighed, the best law damps all that efforts reach
    reason = "no effort damps it" if weighed else "no effort damps it, or no weight asks for it"
    return SceneError(f"control.law = 'lqr': a motion of {rate:.3g} rad/s about the target stays: {reason}")
