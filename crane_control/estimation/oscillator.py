"""An extended Kalman filter of a swinging payload and a disturbance at an unknown frequency.

It works axis by axis.

The state of an axis is [y, y', d, d', θ, b, λ]: y'' = ω² (tip - y) + d + b, d'' = -θ d, with the
pendulum frequency ω and the squared disturbance frequency θ; θ and the bias b are random walks, λ,
the nominal length of the cable over the true one, is an unknown constant. Units: m, m/s, m/s²,
m/s³, 1/s², m/s², 1. The payload's position is computed from the measured direction of the cable
with the nominal length, so it reads tip + λ (y - tip).
"""

from math import cos, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.jit import routine

Y, V, D, DISTURBANCE_RATE, THETA, BIAS, LENGTH_RATIO = range(7)
N = 7
MIN_LENGTH_RATIO, MAX_LENGTH_RATIO = 0.5, 2.0  # bounds of λ


class FilterState(NamedTuple):
    """EKF state of both axes: estimate, covariance, work arrays, last prediction."""

    x: Any  # (2, 7)
    covariance: Any  # (2, 7, 7)
    work: Any  # (2, 7, 7)
    last_time: Any  # (1,) s, of the last prediction; negative before the first
    last_tip: Any  # (2,) m, tip at that time


class Filter(NamedTuple):
    """The filter of both axes."""

    measurement_variances: tuple[float, float]  # m² of a measured position, m²/s² of a measured
    # velocity
    theta: float  # 1/s², initial squared disturbance frequency
    initial_variance: Any  # (7,) of the state
    process_noise: Any  # (7,) variance per second
    bounds: tuple[float, float]  # 1/s², of θ
    state: FilterState

    def with_initial_state(self) -> "Filter":
        """Return the filter before its first measurement."""
        return self._replace(state=initial_filter_state())


def initial_filter_state() -> FilterState:
    """Return the state before the first measurement."""
    return FilterState(
        np.zeros((2, N)), np.zeros((2, N, N)), np.zeros((2, N, N)), np.array([-1.0]), np.zeros(2)
    )


def begin_filter(ekf, t, y, dy, tip):
    """Initialise the filter at time t [s] with the payload at y, dy (2,), the tip at `tip` (2,)."""
    x, p, _, last_time, last_tip = ekf.state
    for i in range(2):
        x[i, Y], x[i, V], x[i, THETA], x[i, LENGTH_RATIO] = y[i], dy[i], ekf.theta, 1.0
        for k in range(N):
            p[i, k, k] = ekf.initial_variance[k]
        last_tip[i] = tip[i]
    last_time[0] = t


@routine
def predict(ekf, i, omega_sq, tip, h):
    """Predict axis i over h seconds.

    `tip` is the mean tip position over the step [m], `omega_sq` is ω² [1/s²].
    """
    x, p, f = ekf.state.x[i], ekf.state.covariance[i], ekf.state.work[0]
    half_h2, theta, d = 0.5 * h * h, x[THETA], x[D]
    w = sqrt(theta)
    c, s = cos(w * h), sin(w * h) / w
    write_transition(f, omega_sq, theta, d, h)
    d_next = d * c + x[DISTURBANCE_RATE] * s
    acceleration = omega_sq * (tip - x[Y]) + 0.5 * (d + d_next) + x[BIAS]
    y = x[Y] + h * x[V] + half_h2 * acceleration
    x[V] += h * (acceleration - 0.5 * omega_sq * (y - x[Y]))
    x[Y] = y
    x[D], x[DISTURBANCE_RATE] = d_next, x[DISTURBANCE_RATE] * c - theta * d * s
    propagate_covariance(p, f, ekf.state.work[1])
    for k in range(N):
        p[k, k] += h * ekf.process_noise[k]


def write_transition(f, omega_sq, theta, d, h):
    """Write exp(A h) to second order in h into f (7, 7), A the Jacobian of the model.

    The Jacobian neglects dω²/dλ: its effect equals that of a disturbance at the pendulum frequency.
    """
    half_h2 = 0.5 * h * h
    for j in range(N):
        for k in range(N):
            f[j, k] = 1.0 if j == k else 0.0
    f[Y, Y] = f[V, V] = 1.0 - half_h2 * omega_sq
    f[Y, V], f[V, Y] = h, -h * omega_sq
    f[Y, D] = f[Y, BIAS] = half_h2
    f[V, D] = f[V, BIAS] = h
    f[V, DISTURBANCE_RATE] = half_h2
    f[D, D] = f[DISTURBANCE_RATE, DISTURBANCE_RATE] = 1.0 - half_h2 * theta
    f[D, DISTURBANCE_RATE], f[DISTURBANCE_RATE, D] = h, -h * theta
    f[D, THETA], f[DISTURBANCE_RATE, THETA] = -half_h2 * d, -h * d


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


def measurement_model(ekf, i, component, omega_sq, tip, tip_rate, age):
    """Return (H, predicted measurement) of the past position or the present velocity.

    The position is delayed by `age` [s] (2nd-order Taylor).

    `component` is Y or V. H (7,), the Jacobian with respect to the present state, is written into
    the filter's work; tip [m] and its rate [m/s] are the present ones.
    """
    x, row, half_age2 = ekf.state.x[i], ekf.state.work[1, 2], 0.5 * age * age
    ratio, acceleration = x[LENGTH_RATIO], omega_sq * (tip - x[Y]) + x[D] + x[BIAS]
    row[:] = 0.0
    if component == Y:
        offset = x[Y] - age * x[V] + half_age2 * acceleration - tip
        row[Y], row[V], row[D], row[BIAS] = (
            ratio * (1.0 - half_age2 * omega_sq),
            -ratio * age,
            ratio * half_age2,
            ratio * half_age2,
        )
        row[LENGTH_RATIO] = offset
        return row, tip + ratio * offset
    row[V], row[LENGTH_RATIO] = ratio, x[V] - tip_rate
    return row, tip_rate + ratio * row[LENGTH_RATIO]


@routine
def correct(ekf, i, component, measured, omega_sq, tip, tip_rate, age):
    """Correct axis i by a measured component Y or V, `age` seconds old.

    See `measurement_model`.
    """
    x, p, work = ekf.state.x[i], ekf.state.covariance[i], ekf.state.work[1]
    gain, row = work[0], work[1]
    jacobian_row, expected = measurement_model(ekf, i, component, omega_sq, tip, tip_rate, age)
    innovation, variance = measured - expected, ekf.measurement_variances[component]
    for k in range(N):
        row[k] = 0.0
        for m in range(N):
            row[k] += jacobian_row[m] * p[m, k]
    for k in range(N):
        variance += row[k] * jacobian_row[k]
    for k in range(N):
        gain[k] = row[k] / variance
        x[k] += gain[k] * innovation
    for j in range(N):
        for k in range(N):
            p[j, k] -= gain[j] * row[k]
    x[THETA] = min(max(x[THETA], ekf.bounds[0]), ekf.bounds[1])
    x[LENGTH_RATIO] = min(max(x[LENGTH_RATIO], MIN_LENGTH_RATIO), MAX_LENGTH_RATIO)
