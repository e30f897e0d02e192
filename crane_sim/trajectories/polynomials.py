"""Piecewise polynomials of time, the common form of all trajectories, and operations on them."""

from collections.abc import Sequence
from math import comb
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.libm import exponential

Array = npt.NDArray[np.float64]
MIN_INTERVAL = 1e-6  # s, of a piece: its powers stay in the range of doubles


class PiecewisePolynomial(NamedTuple):
    """n coordinates as piecewise polynomials of time."""

    starts: Array  # (pieces,) s, increasing; the first piece also holds before, the last one after
    coefficients: Array  # (pieces, n, degree + 1), of powers of t - starts[piece], from the
    # constant on


def with_rest_at_ends(times: Array, coefficients: Array) -> PiecewisePolynomial:
    """Return the pieces (K, n, degree + 1) between times (K + 1,) [s], with rest before and after.

    Rest is at the end positions; velocities at the ends are not checked.
    """
    before, after = np.zeros_like(coefficients[:1]), np.zeros_like(coefficients[:1])
    before[0, :, 0] = coefficients[0, :, 0]
    span = times[-1] - times[-2]
    after[0, :, 0] = coefficients[-1] @ exponential(span, np.arange(coefficients.shape[2]))
    return PiecewisePolynomial(
        np.array([times[0] - 1.0, *times]), np.concatenate([before, coefficients, after])
    )


def check_durations(times: Array, cause: str = "limits so large") -> Array:
    """Return the times (K + 1,) [s] of pieces, checked.

    Their durations follow from limits, or from another `cause`.

    Raises:
        ValueError: a piece is shorter than the resolution of doubles.
    """
    if not np.min(np.diff(times)) >= MIN_INTERVAL:
        raise ValueError(f"{cause} that the motion, or a part of it, takes no time")
    return times


def evaluate(polynomials: PiecewisePolynomial, t: Array, derivative: int = 0) -> Array:
    """Return the derivative of that order (K, n) at times t (K,) [s]."""
    piece = np.clip(np.searchsorted(polynomials.starts, t, side="right") - 1, 0, None)
    rows, s = (
        differentiate(polynomials.coefficients, derivative)[piece],
        t - polynomials.starts[piece],
    )
    out = np.zeros(rows.shape[:2])
    for k in reversed(range(rows.shape[2])):
        out = out * s[:, None] + rows[:, :, k]
    return out


def differentiate(coefficients: Array, order: int = 1) -> Array:
    """Return the coefficients of the derivative of that order, at least one of them."""
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[-1])
        coefficients = (
            coefficients[..., 1:] * powers if len(powers) else np.zeros_like(coefficients)
        )
    return coefficients


def max_derivatives(polynomials: PiecewisePolynomial, derivative: int) -> Array:
    """Return the maximum magnitude (n,) of the derivative of an order, exactly.

    It is at the ends or extrema of pieces.

    The first and the last piece are rest.
    """
    n = polynomials.coefficients.shape[1]
    rows, largest = differentiate(polynomials.coefficients, derivative), np.zeros(n)
    for row, span in zip(rows[1:-1], np.diff(polynomials.starts)[1:], strict=True):
        for k in range(n):
            roots = np.roots(np.trim_zeros(differentiate(row[k])[::-1], "f"))
            turning = roots.real[
                (np.abs(roots.imag) < 1e-9 * span) & (roots.real > 0.0) & (roots.real < span)
            ]
            at = np.concatenate([[0.0, span], turning])
            largest[k] = max(largest[k], np.max(np.abs(np.polyval(row[k][::-1], at))))
    return largest


def delay_by(polynomials: PiecewisePolynomial, delay: float) -> PiecewisePolynomial:
    """Return the same trajectory, `delay` seconds later."""
    return polynomials._replace(starts=polynomials.starts + delay)


def reorder(polynomials: PiecewisePolynomial, order: Sequence[int]) -> PiecewisePolynomial:
    """Return the coordinates of these numbers, in this order."""
    return polynomials._replace(coefficients=polynomials.coefficients[:, list(order)])


def weighted_sum(
    weights: Sequence[float], parts: Sequence[PiecewisePolynomial]
) -> PiecewisePolynomial:
    """Return the sum of weights[k] parts[k], of the same coordinates."""
    starts = np.unique(np.concatenate([part.starts for part in parts]))
    starts = starts[np.concatenate([[True], np.diff(starts) > MIN_INTERVAL])]
    degree = max(part.coefficients.shape[2] for part in parts)
    total = np.zeros((len(starts), parts[0].coefficients.shape[1], degree))
    for weight, part in zip(weights, parts, strict=True):
        piece = np.clip(
            np.searchsorted(part.starts, starts + MIN_INTERVAL, side="right") - 1, 0, None
        )
        moved = shift_origin(part.coefficients[piece], starts - part.starts[piece])
        total[:, :, : moved.shape[2]] += weight * moved
    return PiecewisePolynomial(starts, total)


def shift_origin(coefficients: Array, s: Array) -> Array:
    """Return polynomials (K, n, degree + 1) in powers of t - s, from those of t; s (K,)."""
    out, size = np.zeros_like(coefficients), coefficients.shape[2]
    for k in range(size):
        for j in range(k, size):
            out[:, :, k] += comb(j, k) * coefficients[:, :, j] * s[:, None] ** (j - k)
    return out
