"""The law `adaptive`: Cartesian tracking that learns the disturbance.

It is by Smith & Egeland, eq. 81-99.

The disturbance is taken for a function of what the payload does, α·ψ(x) for each axis with random
features ψ. With e the error of the payload, Q = ½ (kp + (kc + c) c) |e|² + c e·e' + ½ |e'|², kc =
kd - c, and F the dead zone, the law adds u = α·ψ to what the payload should do and learns α' = -γ
F(Q) ψ (c e + e').
"""

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field

from crane_control.cartesian import CartesianLaw, Settings, TrackingDefaults, make_cartesian_law
from crane_control.estimation.features import (
    FeatureArguments,
    Features,
    draw_frequencies,
    write_features,
)
from crane_control.tracking.tracker import Estimate, Gains
from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Seed, reject_bool
from crane_sim.laws import read_group
from crane_sim.numerics.jit import routine
from crane_sim.scenes.scene import Scene

Number = Annotated[int, BeforeValidator(reject_bool), Field(ge=1, le=10000)]


class DeadZone(NamedTuple):
    """Errors too small to learn from; Q is in m²/s²."""

    cutoff: NonNegative  # m²/s², δ, of Q, up to which nothing is learnt
    smoothing: Positive  # m²/s², μ: from δ + 2 μ on, everything is


class Adaptation(NamedTuple):
    """Adaptive estimation of the disturbance."""

    features: Number = 100  # -, number of random features
    width: Positive = 1.5  # -, of their Gaussian kernel, in the units of its arguments
    rate: NonNegative = 9.0  # -, γ, learning rate
    c: Positive = 0.5  # 1/s, weight of the error beside its rate; below kd
    of: FeatureArguments = "y"  # arguments of the disturbance and of the kernel: the payload's
    # position, its position and velocity, or its errors of both
    time: bool = False  # whether it is a function of time, too
    dead_zone: DeadZone | None = None  # errors too small to learn from; left out: none
    seed: Seed = 0  # -, of the features


SETTINGS = {"control": Settings, "control.adaptation": Adaptation}


class Weights(NamedTuple):
    """Learnt weights, and work arrays."""

    weights: Any  # (2 d, 2), α of both axes
    values: Any  # (2 d,), ψ
    inputs: Any  # (9,): y, y', e, e', t
    last_time: Any  # (1,) s, of the last update; negative before the first


class Learner(NamedTuple):
    """Adaptive estimator of a disturbance."""

    features: Features
    rate: float
    c: float  # 1/s
    stiffness: float  # 1/s², kp + kd c: the paper's kp + (kc + c) c, its kc being kd - c
    zone: DeadZone | None
    state: Weights

    def with_initial_state(self) -> "Learner":
        """Return the learner with zero weights."""
        return self._replace(state=initial_weights(len(self.features.frequencies)))

    def estimate(self, pendulum, sample, measurement):
        """Return the Estimate at a Sample, from which the learner learns."""
        inputs, last_time = self.state.inputs, self.state.last_time
        for i in range(2):
            inputs[i], inputs[2 + i] = measurement.position[i], measurement.velocity[i]
            inputs[4 + i] = measurement.position[i] - sample.goal[0][i]
            inputs[6 + i] = measurement.velocity[i] - sample.goal[1][i]
        inputs[8] = sample.t
        # a law may begin in the middle of a run
        elapsed = sample.t - last_time[0] if last_time[0] >= 0.0 else 0.0
        last_time[0] = sample.t
        u, nothing = adaptation_step(self, elapsed), (0.0, 0.0)
        return Estimate(measurement.position, measurement.velocity, u, nothing, nothing, (1.0, 1.0))


def initial_weights(d: int) -> Weights:
    """Return zero weights for d frequencies."""
    return Weights(np.zeros((2 * d, 2)), np.zeros(2 * d), np.zeros(9), np.full(1, -1.0))


def learning_factor(zone, q):
    """Return F(Q), eq. 97, the factor of the learning rate at an error of size Q [m²/s²].

    It is 1 without a dead zone.
    """
    return 1.0 if zone is None else min(max((q - zone.cutoff) / (2.0 * zone.smoothing), 0.0), 1.0)


def error_size(learner, inputs):
    """Return Q [m²/s²], eq. 85 and 86."""
    ex, ey, vx, vy = inputs[4], inputs[5], inputs[6], inputs[7]
    cross = learner.c * (ex * vx + ey * vy)
    return 0.5 * learner.stiffness * (ex * ex + ey * ey) + cross + 0.5 * (vx * vx + vy * vy)


@routine
def adaptation_step(learner, elapsed):
    """Learn for `elapsed` seconds from the inputs, eq. 99, and return u (2,) [m/s²], eq. 81."""
    weights, values, inputs, _ = learner.state
    write_features(learner.features, inputs, values)
    gain = elapsed * learner.rate * learning_factor(learner.zone, error_size(learner, inputs))
    sx, sy = learner.c * inputs[4] + inputs[6], learner.c * inputs[5] + inputs[7]
    ux, uy = 0.0, 0.0
    for j in range(len(values)):
        weights[j, 0] -= gain * values[j] * sx
        weights[j, 1] -= gain * values[j] * sy
        ux += weights[j, 0] * values[j]
        uy += weights[j, 1] * values[j]
    return ux, uy


def make_learner(settings: Adaptation, gains: Gains) -> Learner:
    """Return the learner for a tracker with these gains.

    Raises:
        SceneError: c is not below kd, so that Q would not decrease.
    """
    if settings.c >= gains.kd:
        raise SceneError(
            f"control.adaptation.c = {settings.c:g}: must be below kd = {gains.kd:g} 1/s"
        )
    features = draw_frequencies(
        settings.features, settings.width, settings.of, settings.time, settings.seed
    )
    size = gains.kp + gains.kd * settings.c
    return Learner(
        features,
        settings.rate,
        settings.c,
        size,
        settings.dead_zone,
        initial_weights(settings.features),
    )


def build(settings: Mapping[str, Any], nominal: Scene) -> CartesianLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    own, remaining = read_group(Adaptation, settings, "adaptation")
    return make_cartesian_law(
        "adaptive",
        remaining,
        nominal,
        lambda tracker, _: make_learner(own, tracker.gains),
        TrackingDefaults(),
    )
