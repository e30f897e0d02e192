"""Initial conditions of a chain, and drives as functions of time, in extended precision."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from rigid import Real, Vector

Sine = dict[str, float]  # offset, amplitude, frequency [rad/s], phase; absent: 0


def sine(form: Sine) -> Callable[[Real], Real]:
    """Return offset + amplitude sin(frequency t + phase), a function of t [s]."""
    offset, size, rate, phase = (
        Real(form.get(key, 0.0)) for key in ("offset", "amplitude", "frequency", "phase")
    )
    return lambda t: offset + size * np.sin(rate * t + phase)


def drive(*forms: Sine) -> Callable[[Real], Vector]:
    """Return the force on the trolley along x and y, a function of t [s]."""
    parts = [sine(form) for form in (*forms, {}, {})[:2]]
    return lambda t: np.array([part(t) for part in parts], Real)


def smooth(first: float, last: float, duration: float) -> Callable[[Real], tuple[Real, Real, Real]]:
    """Return the quintic from `first` to `last`, at rest at both ends, with two derivatives.

    It is a function of t [s].
    """
    a, b, d = Real(first), Real(last) - Real(first), Real(duration)

    def profile(t: Real) -> tuple[Real, Real, Real]:
        s = min(t / d, Real(1))
        shape = (
            s**3 * (10 + s * (6 * s - 15)),
            30 * s**2 * (1 - s) ** 2,
            60 * s * (1 - s) * (1 - 2 * s),
        )
        return a + b * shape[0], b * shape[1] / d, b * shape[2] / d**2

    return profile


def hang(
    lengths: Sequence[float], angles: Sequence[float], rates: Sequence[float]
) -> tuple[Vector, Vector]:
    """Return nodes and velocities (N + 1, 2) of a planar chain below a trolley at rest at x = 0."""
    length, a, w = (np.array(values, Real) for values in (lengths, angles, rates))
    across, along = (
        np.stack([np.cos(a), np.sin(a)], axis=1),
        np.stack([np.sin(a), -np.cos(a)], axis=1),
    )
    return chained(length[:, None] * along), chained((length * w)[:, None] * across)


def aim(lengths: Sequence[float], directions: Any, rates: Any) -> tuple[Vector, Vector]:
    """Return nodes and velocities (N + 1, 3) from directions and rates.

    Directions are made unit, rates perpendicular to them.
    """
    length, n, w = (np.array(values, Real) for values in (lengths, directions, rates))
    n = n / np.sqrt(np.sum(n * n, axis=1))[:, None]
    w = w - np.sum(n * w, axis=1)[:, None] * n
    return chained(length[:, None] * n), chained(length[:, None] * w)


def chained(steps: Vector) -> Vector:
    """Return the running sum of steps from node to node, the first node at the origin."""
    return np.vstack([0 * steps[:1], np.cumsum(steps, axis=0)])


def instants(last: float, count: int = 10) -> list[float]:
    """Return `count` equally spaced instants [s] up to `last`, 0 left out."""
    return [last * (k + 1) / count for k in range(count)]
