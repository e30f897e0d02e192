"""An extended Kalman filter of one swinging payload and a disturbance at an unknown frequency, axis by axis.

The state of an axis is [y, y', d, d', θ, b, λ]: y'' = Oz² (tip - y) + d + b, d'' = -θ d; θ, b and λ are constant but
for their noise. Units: m, m/s, m/s², m/s³, 1/s², m/s², 1. What is measured is the direction of the cable, and what is
seen of y is the place on a cable of the nominal length: tip + λ (y - tip), λ the nominal length over the true one.
"""

from math import cos, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.jit import kernel, routine

Y, V, D, RATE, THETA, BIAS, ROPE = range(7)
N = 7
MIN_LENGTH_RATIO, MAX_LENGTH_RATIO = 0.5, 2.0  # bounds of λ


class Trace(NamedTuple):
    """What the filter knows; both axes."""

    x: Any  # (2, 7)
    covariance: Any  # (2, 7, 7)
    work: Any  # (2, 7, 7)
    clock: Any  # (3,) time [s] of the last prediction, and the tip then [m]; the time is negative before the first


class Filter(NamedTuple):
    """The filter of both axes."""

    variances: tuple[float, float]  # m² of a position, m²/s² of a velocity that is seen
    theta: float  # 1/s², at first
    start: Any  # (7,) variance of the state at first
    noise: Any  # (7,) variance that the state gains per second
    bounds: tuple[float, float]  # 1/s², of θ
    trace: Trace

    def fresh(self) -> "Filter":
        """Return the filter before it has seen anything."""
        return self._replace(trace=blank())


def blank() -> Trace:
    """Return the trace of nothing yet."""
    return Trace(np.zeros((2, N)), np.zeros((2, N, N)), np.zeros((2, N, N)), np.array([-1.0, 0.0, 0.0]))


@kernel
def begin_filter(ekf, t, y, dy, tip):
    """Begin at time t [s] with the payload at y, dy (2,) and the tip at `tip` (2,)."""
    x, p, _, clock = ekf.trace
    for i in range(2):
        x[i, Y], x[i, V], x[i, THETA], x[i, ROPE] = y[i], dy[i], ekf.theta, 1.0
        for k in range(N):
            p[i, k, k] = ekf.start[k]
        clock[1 + i] = tip[i]
    clock[0] = t


@routine
def predict(ekf, i, square, tip, h):
    """Pass h seconds of axis i, through which the tip was at `tip` [m] on the average."""
    x, p, f = ekf.trace.x[i], ekf.trace.covariance[i], ekf.trace.work[0]
    half, theta, d = 0.5 * h * h, x[THETA], x[D]
    w = sqrt(theta)
    c, s = cos(w * h), sin(w * h) / w
    transition(f, square, theta, d, h)
    later = d * c + x[RATE] * s
    push = square * (tip - x[Y]) + 0.5 * (d + later) + x[BIAS]
    y = x[Y] + h * x[V] + half * push
    x[V] += h * (push - 0.5 * square * (y - x[Y]))
    x[Y] = y
    x[D], x[RATE] = later, x[RATE] * c - theta * d * s
    propagate_covariance(p, f, ekf.trace.work[1])
    for k in range(N):
        p[k, k] += h * ekf.noise[k]


@kernel
def transition(f, square, theta, d, h):
    """Write exp(A h) to second order in h into f (7, 7), A the Jacobian of the model.

    What λ does to Oz² is left out of it: a disturbance at the payload's own frequency does the same.
    """
    half = 0.5 * h * h
    for j in range(N):
        for k in range(N):
            f[j, k] = 1.0 if j == k else 0.0
    f[Y, Y] = f[V, V] = 1.0 - half * square
    f[Y, V], f[V, Y] = h, -h * square
    f[Y, D] = f[Y, BIAS] = half
    f[V, D] = f[V, BIAS] = h
    f[V, RATE] = half
    f[D, D] = f[RATE, RATE] = 1.0 - half * theta
    f[D, RATE], f[RATE, D] = h, -h * theta
    f[D, THETA], f[RATE, THETA] = -half * d, -h * d


@kernel
def propagate_covariance(p, f, product):
    """Overwrite the covariance p with f p fᵀ."""
    for j in range(N):
        for k in range(N):
            total = 0.0
            for m in range(N):
                total += f[j, m] * p[m, k]
            product[j, k] = total
    for j in range(N):
        for k in range(j, N):
            total = 0.0
            for m in range(N):
                total += product[j, m] * f[k, m]
            p[j, k] = p[k, j] = total


@kernel
def measurement_model(ekf, i, entry, square, tip, tip_rate, age):
    """Return (H, what should be seen): of entry Y of axis i `age` seconds ago, to second order, or of entry V now.

    H (7,) is that of the state now and is written into the filter's work; tip [m] and its rate [m/s] are those of now.
    """
    x, row, half = ekf.trace.x[i], ekf.trace.work[1, 2], 0.5 * age * age
    rope, push = x[ROPE], square * (tip - x[Y]) + x[D] + x[BIAS]
    for k in range(N):
        row[k] = 0.0
    if entry == Y:
        apart = x[Y] - age * x[V] + half * push - tip
        row[Y], row[V], row[D], row[BIAS] = rope * (1.0 - half * square), -rope * age, rope * half, rope * half
        row[ROPE] = apart
        return row, tip + rope * apart
    row[V], row[ROPE] = rope, x[V] - tip_rate
    return row, tip_rate + rope * row[ROPE]


@routine
def correct(ekf, i, entry, measured, square, tip, tip_rate, age):
    """Correct axis i by a measured entry Y or V of its state, `age` seconds old; the rest as of `measurement_model`."""
    x, p, work = ekf.trace.x[i], ekf.trace.covariance[i], ekf.trace.work[1]
    gain, row = work[0], work[1]
    sensitivity, expected = measurement_model(ekf, i, entry, square, tip, tip_rate, age)
    innovation, variance = measured - expected, ekf.variances[entry]
    for k in range(N):
        row[k] = 0.0
        for m in range(N):
            row[k] += sensitivity[m] * p[m, k]
    for k in range(N):
        variance += row[k] * sensitivity[k]
    for k in range(N):
        gain[k] = row[k] / variance
        x[k] += gain[k] * innovation
    for j in range(N):
        for k in range(N):
            p[j, k] -= gain[j] * row[k]
    x[THETA] = min(max(x[THETA], ekf.bounds[0]), ekf.bounds[1])
    x[ROPE] = min(max(x[ROPE], MIN_LENGTH_RATIO), MAX_LENGTH_RATIO)
