"""The law `harmonic`: Cartesian tracking with an observer of a disturbance.

The frequency of the disturbance is unknown.

For each horizontal axis an extended Kalman filter estimates [y, y', d, d', θ, b, λ]: the payload's
position y [m], the oscillating disturbance d [m/s²] and the square θ [1/s²] of its angular
frequency, a bias b [m/s²], and the ratio λ of the nominal to the true length of the cable:

    y'' = ω² (tip - y) + d + b,   d'' = -θ d,

tip the suspension point's position [m], ω the pendulum frequency [rad/s]. θ and b are random walks,
λ is constant. The compensation u [m/s²] is an acceleration of the payload that the tracker adds. It
opposes the disturbance predicted for the time when the suspension point responds, τ [s] later:

    u = -d(t + τ) - b,   d(t + τ) = d cos(√θ τ) + d' sin(√θ τ) / √θ.
"""

from collections.abc import Mapping
from math import cos, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_control.cartesian import CartesianLaw, Settings, TrackingDefaults, make_cartesian_law
from crane_control.estimation.oscillator import (
    BIAS,
    DISTURBANCE_RATE,
    LENGTH_RATIO,
    THETA,
    D,
    Filter,
    V,
    Y,
    begin_filter,
    correct,
    initial_filter_state,
    predict,
)
from crane_control.tracking.tracker import Estimate, Tracker, compute_ramp, pendulum_omega_sq
from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_group
from crane_sim.numerics.jit import routine
from crane_sim.scenes.scene import Scene

WITHOUT_CAMERA = TrackingDefaults(stiffness=1.25, damping=0.65, ramp=1.6, velocity_feedforward=True)
WITH_CAMERA = TrackingDefaults(stiffness=2.0, damping=0.65, ramp=0.6, velocity_feedforward=True)
"""The shorter ramp of the gains accelerates the tip no more than the noise of the camera does."""
FREQUENCY_BOUNDS = (0.1, 3.0)  # of the disturbance, in the natural frequency of the pendulum


class ObserverSettings(NamedTuple):
    """Observer of the disturbance, a sine of unknown frequency, and of the rope's length."""

    frequency: Positive | None = None  # rad/s, initial, 0.1 to 3 times the natural frequency of the
    # pendulum; left out: 0.8 times
    lead: NonNegative | None = None  # s, τ, prediction time; left out: the lag of the suspension
    # point
    ramp: NonNegative | None = None  # s, rise time of u and of the gains; left out: 1.6 s, with a
    # camera 0.6 s
    noise: Positive = 1e-4  # m, standard deviation of the measured position; that of the camera, if
    # larger
    noise_rate: Positive = 1e-3  # m/s, standard deviation of the measured velocity; not used with a
    # camera
    push: Positive = 0.005  # m/s, standard deviation of the process noise of the payload's velocity
    # after one second
    wander: Positive = 1.5  # m/s³, standard deviation of the process noise of the disturbance's
    # rate after one second
    detune: Positive = 0.5  # 1/s², standard deviation of the process noise of the squared frequency
    # after one second
    drift: Positive = 0.005  # m/s², standard deviation of the process noise of the bias after one
    # second
    rope: NonNegative = 0.05  # -, standard deviation of the initial λ, nominal over true length; 0:
    # λ stays 1. With the default, the payload of `offshore_obstacle` is within 1 mm of its path on
    # a rope 10 % shorter or longer


SETTINGS = {"control": Settings, "control.observer": ObserverSettings}


class HarmonicObserver(NamedTuple):
    """The observer: settings and state of its filter."""

    lead: float  # s, τ
    ramp: float  # s, rise time of the compensation
    velocity_measured: bool  # there is no camera
    ekf: Filter

    def with_initial_state(self) -> "HarmonicObserver":
        """Return the observer with its initial state."""
        return self._replace(ekf=self.ekf.with_initial_state())

    def estimate(self, pendulum, sample, measurement):
        """Return the Estimate at a Sample, which updates the filter."""
        update_filter(self, pendulum, sample, measurement)
        x = self.ekf.state.x
        u0, du0, d0 = compute_compensation(self, sample.t, x[0])
        u1, du1, d1 = compute_compensation(self, sample.t, x[1])
        position, velocity = (x[0, Y], x[1, Y]), (x[0, V], x[1, V])
        length_ratio = x[0, LENGTH_RATIO], x[1, LENGTH_RATIO]
        return Estimate(position, velocity, (u0, u1), (du0, du1), (d0, d1), length_ratio)


def compute_compensation(observer, t, x):
    """Return (u [m/s²], its rate [m/s³], d + b [m/s²]) of one axis in state x (7,) at t [s].

    d + b is that within the ramp.
    """
    w, lead = sqrt(x[THETA]), observer.lead
    c, s = cos(w * lead), sin(w * lead)
    factor, factor_rate = compute_ramp(observer.ramp, t)
    expected = x[D] * c + x[DISTURBANCE_RATE] * s / w + x[BIAS]
    return (
        -factor * expected,
        -factor * (x[DISTURBANCE_RATE] * c - x[D] * w * s) - factor_rate * expected,
        factor * (x[D] + x[BIAS]),
    )


@routine
def update_filter(observer, pendulum, sample, measurement):
    """Predict the filter's state up to the time of a Sample; correct it by its Measurement."""
    ekf = observer.ekf
    x, last_time, last_tip = ekf.state.x, ekf.state.last_time, ekf.state.last_tip
    if last_time[0] < 0.0:
        begin_filter(ekf, sample.t, measurement.position, measurement.velocity, sample.tip)
    h = sample.t - last_time[0]
    if h > 0.0:  # a second call at the same time adds nothing
        for i in range(2):
            omega_sq = pendulum_omega_sq(
                pendulum.length / x[i, LENGTH_RATIO],
                pendulum.gravity,
                (x[0, Y], x[1, Y]),
                sample.tip,
            )
            predict(ekf, i, omega_sq, 0.5 * (last_tip[i] + sample.tip[i]), h)
            rate, last_tip[i] = (sample.tip[i] - last_tip[i]) / h, sample.tip[i]
            if measurement.new:
                correct(
                    ekf, i, Y, measurement.raw[i], omega_sq, sample.tip[i], rate, measurement.age
                )
            if observer.velocity_measured:
                correct(ekf, i, V, measurement.velocity[i], omega_sq, sample.tip[i], rate, 0.0)
        last_time[0] = sample.t


def _initial_theta(frequency: float | None, omega_sq: float) -> float:
    """Return the squared frequency [1/s²] of the disturbance with which the observer begins."""
    if frequency is None:
        return 0.64 * omega_sq
    low, high = (factor * sqrt(omega_sq) for factor in FREQUENCY_BOUNDS)
    if not low <= frequency <= high:
        what = (
            f"must be {low:.3g} to {high:.3g} rad/s, 0.1 to 3 times the natural frequency of the "
            "pendulum"
        )
        raise SceneError(f"control.observer.frequency = {frequency:g}: {what}")
    return frequency * frequency


def make_observer(settings: ObserverSettings, tracker: Tracker, lag: float) -> HarmonicObserver:
    """Return the observer of a tracker whose tip lags `lag` seconds behind its setpoint.

    The tip is the suspension point.

    Raises:
        SceneError: the base's acceleration is fed forward: it would be compensated twice; or the
            frequency is out of the observer's bounds.
    """
    if tracker.base is not None:
        raise SceneError(
            "control.feedforward.base: must be left out, the harmonic law estimates the base's "
            "effect as a disturbance"
        )
    noise = settings.noise
    if tracker.camera is not None:
        noise = max(noise, tracker.camera.noise_std)
    return HarmonicObserver(
        lag if settings.lead is None else settings.lead,
        tracker.gains.ramp,
        tracker.camera is None,
        _make_filter(settings, noise, tracker.pendulum.gravity / tracker.pendulum.length),
    )


def _make_filter(settings: ObserverSettings, noise: float, omega_sq: float) -> Filter:
    """Return the filter for a position's noise [m] and the pendulum's ω² [1/s²]."""
    theta = _initial_theta(settings.frequency, omega_sq)
    low, high = FREQUENCY_BOUNDS
    walks = (settings.wander**2, settings.detune**2, settings.drift**2)
    process_noise = np.array([1e-12, settings.push**2, 0.0, *walks, 0.0])
    initial_variance = np.array(
        [noise**2, 1e-4, 0.25, 1.0, (0.4 * theta) ** 2, 1e-4, settings.rope**2]
    )
    return Filter(
        (noise**2, settings.noise_rate**2),
        theta,
        initial_variance,
        process_noise,
        bounds=(low * low * omega_sq, high * high * omega_sq),
        state=initial_filter_state(),
    )


def build(settings: Mapping[str, Any], nominal: Scene) -> CartesianLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    observer, remaining = read_group(ObserverSettings, settings, "observer")
    defaults = WITHOUT_CAMERA if remaining.get("vision") is None else WITH_CAMERA
    defaults = defaults if observer.ramp is None else defaults._replace(ramp=observer.ramp)
    return make_cartesian_law(
        "harmonic",
        remaining,
        nominal,
        lambda tracker, lag: make_observer(observer, tracker, lag),
        defaults,
    )
