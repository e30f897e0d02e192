"""The law called `harmonic`: Cartesian tracking with an observer of a disturbance that swings at an unknown frequency.

For each axis an extended Kalman filter follows [y, y', d, d', θ, b, λ]: y'' = Oz² (tip - y) + d + b, d'' = -θ d. θ, b
and λ, the nominal length of the cable over the true one, are constant but for their noise. The law opposes what the
disturbance will be when the suspension point has answered:
u = -d(t + τ) - b, d(t + τ) = d cos(ω τ) + d' sin(ω τ) / ω, ω = √θ.
"""

from collections.abc import Mapping
from math import cos, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_control.cartesian import CartesianLaw, Settings, TrackingDefaults, tracking_law
from crane_control.estimation.oscillator import (
    BIAS,
    RATE,
    ROPE,
    THETA,
    D,
    Filter,
    V,
    Y,
    begin_filter,
    blank,
    correct,
    predict,
)
from crane_control.tracking.tracker import Estimate, Tracker, compute_ramp, estimate, stiffness
from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_group
from crane_sim.numerics.jit import kernel, routine
from crane_sim.scenes.scene import Scene

SEEING, WATCHING = TrackingDefaults(1.25, 0.65, 1.6, True), TrackingDefaults(2.0, 0.65, 0.6, True)
"""How the law tracks, without a camera and with one: beside a camera's noise its own start makes no harder jerks."""


class Observer(NamedTuple):
    """How the disturbance is observed, as a swing of unknown frequency, and the rope's length beside it."""

    frequency: Positive | None = None  # rad/s, to begin with; left out: 20 % below the payload's own
    lead: NonNegative | None = None  # s, τ; left out: what the suspension point lags behind
    ramp: NonNegative | None = None  # s, in which u and the gains come in; left out: the law's own
    noise: Positive = 1e-4  # m, of what is seen of the payload, where no camera says more
    noise_rate: Positive = 1e-3  # m/s, of its velocity, where there is no camera
    push: Positive = 0.005  # m/s², unmodelled acceleration of the payload, in one second
    wander: Positive = 1.5  # m/s³, unmodelled change of the disturbance's rate, in one second
    detune: Positive = 0.5  # 1/s², of the squared frequency, in one second
    drift: Positive = 0.005  # m/s², of the bias, in one second
    rope: NonNegative = 0.05  # -, standard deviation of the nominal length, relative to the true one: from 20 %
    # shorter to 20 % longer is observed


SETTINGS = {"control": Settings, "control.observer": Observer}


class HarmonicObserver(NamedTuple):
    """The observer at work."""

    lead: float  # s
    ramp: float  # s
    direct: bool  # no camera: the velocity is seen, too
    ekf: Filter

    def fresh(self) -> "HarmonicObserver":
        """Return the observer before it has seen anything."""
        return self._replace(ekf=self.ekf.fresh())


@kernel
def compute_compensation(observer, t, x):
    """Return (u [m/s²], its rate [m/s³], what is admitted of d and b [m/s²]) of one axis in state x (6,) at t [s]."""
    w, lead = sqrt(x[THETA]), observer.lead
    c, s = cos(w * lead), sin(w * lead)
    share, rising = compute_ramp(observer.ramp, t)
    expected = x[D] * c + x[RATE] * s / w + x[BIAS]
    return -share * expected, -share * (x[RATE] * c - x[D] * w * s) - rising * expected, share * (x[D] + x[BIAS])


@routine
def update_filter(observer, pendulum, sample, measurement):
    """Predict the filter up to a Sample and correct it by its Measurement."""
    ekf = observer.ekf
    x, clock = ekf.trace.x, ekf.trace.clock
    if clock[0] < 0.0:
        begin_filter(ekf, sample.t, measurement.y, measurement.dy, sample.tip)
    h = sample.t - clock[0]
    if h > 0.0:  # a second call at the same time adds nothing
        for i in range(2):
            square = stiffness(pendulum.length / x[i, ROPE], pendulum.gravity, (x[0, Y], x[1, Y]), sample.tip)
            predict(ekf, i, square, 0.5 * (clock[1 + i] + sample.tip[i]), h)
            rate, clock[1 + i] = (sample.tip[i] - clock[1 + i]) / h, sample.tip[i]
            if measurement.new:
                correct(ekf, i, Y, measurement.raw[i], square, sample.tip[i], rate, measurement.age)
            if observer.direct:
                correct(ekf, i, V, measurement.dy[i], square, sample.tip[i], rate, 0.0)
        clock[0] = sample.t


@estimate.register(HarmonicObserver)
def _(learner, pendulum, sample, measurement):
    update_filter(learner, pendulum, sample, measurement)
    x = learner.ekf.trace.x
    (u0, du0, d0), (u1, du1, d1) = (
        compute_compensation(learner, sample.t, x[0]),
        compute_compensation(learner, sample.t, x[1]),
    )
    return Estimate((x[0, Y], x[1, Y]), (x[0, V], x[1, V]), (u0, u1), (du0, du1), (d0, d1), (x[0, ROPE], x[1, ROPE]))


def observer_of(settings: Observer, tracker: Tracker, lag: float) -> HarmonicObserver:
    """Return the observer of a tracker whose suspension point lags `lag` seconds behind what is demanded.

    Raises:
        SceneError: the base is fed forward: what is measured and what is observed would be opposed both.
    """
    if tracker.base is not None:
        raise SceneError("control.feedforward.base: the harmonic law observes the base's motion; leave one of both out")
    own = tracker.pendulum.gravity / tracker.pendulum.length
    theta = 0.64 * own if settings.frequency is None else settings.frequency**2
    deviation = settings.noise if tracker.eye is None else max(settings.noise, tracker.eye.deviation)
    noise = np.array([1e-12, settings.push**2, 0.0, settings.wander**2, settings.detune**2, settings.drift**2, 0.0])
    start = np.array([deviation**2, 1e-4, 0.25, 1.0, (0.4 * theta) ** 2, 1e-4, settings.rope**2])
    ekf = Filter((deviation**2, settings.noise_rate**2), theta, start, noise, (0.01 * own, 9.0 * own), blank())
    return HarmonicObserver(
        lag if settings.lead is None else settings.lead, tracker.gains.ramp, tracker.eye is None, ekf
    )


def build(settings: Mapping[str, Any], nominal: Scene) -> CartesianLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    own, rest = read_group(Observer, settings, "observer")
    manner = WATCHING if rest.get("vision") else SEEING
    manner = manner if own.ramp is None else manner._replace(ramp=own.ramp)
    return tracking_law("harmonic", rest, nominal, lambda tracker, lag: observer_of(own, tracker, lag), manner)
