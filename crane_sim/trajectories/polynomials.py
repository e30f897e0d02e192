"""Polynomials of time, piece by piece: what every kind of reference becomes, and what can be done with them."""

from collections.abc import Sequence
from math import comb
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
MIN_INTERVAL = 1e-6  # s, of a piece: its powers stay in the range of doubles


class Pieces(NamedTuple):
    """n coordinates as polynomials of time."""

    starts: Array  # (pieces,) s, increasing; the first piece also holds before, the last one ever after
    coefficients: Array  # (pieces, n, degree + 1), of powers of t - starts[piece], from the constant on


def at_rest_around(times: Array, coefficients: Array) -> Pieces:
    """Return the pieces (K, n, degree + 1) between times (K + 1,) [s], with rest before and after.

    What remains of the velocity at the ends is the caller's business: the rest is where the ends are.
    """
    before, after = np.zeros_like(coefficients[:1]), np.zeros_like(coefficients[:1])
    before[0, :, 0] = coefficients[0, :, 0]
    span = times[-1] - times[-2]
    after[0, :, 0] = coefficients[-1] @ span ** np.arange(coefficients.shape[2])
    return Pieces(np.array([times[0] - 1.0, *times]), np.concatenate([before, coefficients, after]))


def lasting(times: Array) -> Array:
    """Return the times (K + 1,) [s] of pieces whose lengths follow from limits.

    Raises:
        ValueError: a piece is shorter than the resolution of doubles.
    """
    if not np.min(np.diff(times)) >= MIN_INTERVAL:
        raise ValueError("limits so large that the motion, or a part of it, takes no time")
    return times


def values(pieces: Pieces, t: Array, derivative: int = 0) -> Array:
    """Return the derivative of that order (K, n) at times t (K,) [s]."""
    piece = np.clip(np.searchsorted(pieces.starts, t, side="right") - 1, 0, None)
    rows, s = differentiate(pieces.coefficients, derivative)[piece], t - pieces.starts[piece]
    out = np.zeros(rows.shape[:2])
    for k in reversed(range(rows.shape[2])):
        out = out * s[:, None] + rows[:, :, k]
    return out


def differentiate(coefficients: Array, order: int = 1) -> Array:
    """Return the coefficients of the derivative of that order, at least one of them."""
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[-1])
        coefficients = coefficients[..., 1:] * powers if len(powers) else np.zeros_like(coefficients)
    return coefficients


def peaks(pieces: Pieces, derivative: int) -> Array:
    """Return the largest size (n,) that the derivative of that order has, exactly: at ends of pieces or where it turns.

    The first and the last piece are rest.
    """
    n = pieces.coefficients.shape[1]
    rows, largest = differentiate(pieces.coefficients, derivative), np.zeros(n)
    for row, span in zip(rows[1:-1], np.diff(pieces.starts)[1:], strict=True):
        for k in range(n):
            roots = np.roots(np.trim_zeros(differentiate(row[k])[::-1], "f"))
            turning = roots.real[(np.abs(roots.imag) < 1e-9 * span) & (roots.real > 0.0) & (roots.real < span)]
            at = np.concatenate([[0.0, span], turning])
            largest[k] = max(largest[k], np.max(np.abs(np.polyval(row[k][::-1], at))))
    return largest


def delay_path(pieces: Pieces, delay: float) -> Pieces:
    """Return the same motion, `delay` seconds later."""
    return pieces._replace(starts=pieces.starts + delay)


def reorder(pieces: Pieces, order: Sequence[int]) -> Pieces:
    """Return the coordinates of these numbers, in this order."""
    return pieces._replace(coefficients=pieces.coefficients[:, list(order)])


def weighted_sum(weights: Sequence[float], parts: Sequence[Pieces]) -> Pieces:
    """Return the sum of weights[k] parts[k], of the same coordinates."""
    starts = np.unique(np.concatenate([part.starts for part in parts]))
    starts = starts[np.concatenate([[True], np.diff(starts) > MIN_INTERVAL])]
    degree = max(part.coefficients.shape[2] for part in parts)
    total = np.zeros((len(starts), parts[0].coefficients.shape[1], degree))
    for weight, part in zip(weights, parts, strict=True):
        piece = np.clip(np.searchsorted(part.starts, starts + MIN_INTERVAL, side="right") - 1, 0, None)
        moved = shift_origin(part.coefficients[piece], starts - part.starts[piece])
        total[:, :, : moved.shape[2]] += weight * moved
    return Pieces(starts, total)


def shift_origin(coefficients: Array, s: Array) -> Array:
    """Return polynomials (K, n, degree + 1) in powers of what exceeds s (K,)."""
    out, size = np.zeros_like(coefficients), coefficients.shape[2]
    for k in range(size):
        for j in range(k, size):
            out[:, :, k] += comb(j, k) * coefficients[:, :, j] * s[:, None] ** (j - k)
    return out
