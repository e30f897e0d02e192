"""Tracking of a payload below a suspension point: adaptation, features, poles, settings.

Settings are those that are rejected.
"""

from math import exp, sqrt
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_control.adaptive import DeadZone, learning_factor
from crane_control.tracking.tracker import Estimate, Gains, axis_setpoint
from crane_sim.files.errors import SceneError
from crane_sim.laws import with_initial_state
from crane_sim.scenes.scene import load_scene

LENGTH, G = 1.255, 9.81
# of the paper's table 2: the pendulum's own frequency, damping 0.2
KP, KD = G / LENGTH, 0.4 * sqrt(G / LENGTH)
Q = (1.3, 0.05, 0.0, 0.06, -0.08, -sqrt(1.0 - 0.06**2 - 0.08**2))
# across the link
V = (0.02, -0.03, 0.0, 0.1, 0.2, (0.06 * 0.1 - 0.08 * 0.2) / sqrt(1.0 - 0.06**2 - 0.08**2))
Y, DY = np.array(Q[:2]) + LENGTH * np.array(Q[3:5]), np.array(V[:2]) + LENGTH * np.array(V[3:5])
E1, E2 = Y - (1.35, 0.0), DY  # the path of the scenes rests at (1.35, 0) for ten seconds


def law_of(scene: str, changes: dict[str, Any] | None = None) -> Any:
    """Return the law of a scene with its initial state."""
    return with_initial_state(load_scene(scene, changes).law)


def hanging(y: Any, dy: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return joint positions and velocities of a payload at y that hangs straight down.

    It moves with its tip.
    """
    return (y[0], y[1], 0.0, 0.0, 0.0, -1.0), (dy[0], dy[1], 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("of", ["y", "state", "error"])
def test_features_have_unit_norm_and_approximate_the_kernel(of: str) -> None:
    """Features have norm 1, and their products at two points are the Gaussian kernel."""
    changes = {
        "control.adaptation": {"features": 4000, "of": of, "time": True, "width": 0.5, "rate": 0.0}
    }
    law, features = law_of("offshore_resonant", changes), []
    for t, y in ((0.0, (1.35, 0.0)), (0.3, (1.2, 0.2))):
        law(t, *hanging(y, (0.0, 0.0)))
        features.append(law.tracker.disturbance_estimator.state.values.copy())
    assert [feature @ feature for feature in features] == pytest.approx([1.0, 1.0], abs=1e-12)
    distance = 0.15**2 + 0.2**2 + 0.3**2  # m² and s²: velocities and the reference stay
    # the mean of 4000 cosines, each of variance below 1/2: four standard deviations
    assert features[0] @ features[1] == pytest.approx(
        exp(-distance / (2.0 * 0.5**2)), abs=4.0 * sqrt(0.5 / 4000)
    )


def test_one_step_of_learning_is_the_printed_law() -> None:
    """Weights after one period, and the effort of them, are equations 64 to 99 by hand.

    These are equations 64, 67, 74, 86, 97 and 99.
    """
    zone = {"cutoff": 0.001, "smoothing": 0.05}
    law = law_of(
        "offshore_resonant", {"control.adaptation": {"features": 20, "seed": 3, "dead_zone": zone}}
    )
    state, c, h = law.tracker.disturbance_estimator.state, 0.5, 0.004
    law(0.0, Q, V)
    assert not np.any(state.weights)  # zero elapsed time
    effort = law(h, Q, V)
    angles = law.tracker.disturbance_estimator.features.frequencies @ Y
    psi = np.column_stack([np.cos(angles), np.sin(angles)]).ravel() / sqrt(20)
    p = np.array([[KP + (KD - c + c) * c, c], [c, 1.0]])
    size = 0.5 * sum(np.array([E1[i], E2[i]]) @ p @ (E1[i], E2[i]) for i in range(2))
    factor = (size - 0.001) / 0.1
    assert 0.1 < factor < 0.9  # on the slope of the dead zone
    weights = -9.0 * factor * h * np.outer(psi, c * E1 + E2)
    assert np.allclose(state.weights, weights, rtol=1e-12, atol=0.0)
    w = -KD * E2 - KP * E1 + weights.T @ psi
    setpoint = Y + w / (G * -Q[5] / LENGTH)
    assert effort == pytest.approx(
        tuple(-36.4 * np.array(V[:2]) - 676.0 * (Q[:2] - setpoint)), rel=1e-11
    )


def test_the_dead_zone_is_piecewise_linear() -> None:
    """F is 0 up to the cutoff, 1 from two smoothings beyond it on, and linear between.

    Without a zone it is 1.
    """
    zone = DeadZone(0.007, 0.002)
    assert [learning_factor(zone, q) for q in (0.0, 0.007, 0.011, 1.0)] == pytest.approx(
        [0.0, 0.0, 1.0, 1.0], abs=1e-15
    )
    assert [learning_factor(zone, q) for q in (0.008, 0.009, 0.01)] == pytest.approx(
        [0.25, 0.5, 0.75]
    )
    assert learning_factor(None, 0.0) == 1.0


def test_a_law_that_begins_mid_run_learns_from_one_period() -> None:
    """A law that replaces another at 50 s begins with weights of zero.

    It has not learned for 50 s at once.
    """
    law = law_of("offshore_resonant", {"control.adaptation": {"features": 20}})
    law(50.0, Q, V)
    assert not np.any(law.tracker.disturbance_estimator.state.weights)
    law(50.004, Q, V)
    assert np.any(law.tracker.disturbance_estimator.state.weights)


@pytest.mark.parametrize("base", [0.0, 0.3])
def test_the_velocity_fed_forward_is_the_setpoints_rate(base: float) -> None:
    """The setpoint's velocity is its rate of change along the model.

    The model is y'' = w² (tip - y) + d + what the base imposes.
    """
    gains, omega_sq, tip, d, jerk = Gains(2.0, 1.5, 1.0, 0.0, 1.6), 5.0, 1.2, 0.05, 0.4

    def setpoint(h: float) -> tuple[float, float]:
        """Return the setpoint h [s] later, the tip at rest; the compensation is constant."""
        y, dy, acceleration = 1.35, -0.1, omega_sq * (tip - 1.35) + d + base
        y, dy = y + h * dy + 0.5 * h * h * acceleration, dy + h * acceleration
        x, v, a = 1.3 + 0.2 * h + 0.3 * h * h, 0.2 + 0.6 * h + 0.5 * jerk * h * h, 0.6 + jerk * h
        zero, one = (0.0, 0.0), (1.0, 1.0)
        estimates = Estimate((y, 0.0), (dy, 0.0), (-d, 0.0), zero, (d, 0.0), one)
        goal = (x, 0.0), (v, 0.0), (a, 0.0)
        return axis_setpoint(
            gains, 0.7 + h, omega_sq, estimates, (tip, 0.0), goal, (jerk, 0.0), (base, 0.0), 0
        )

    step = 1e-5
    rate = (setpoint(step)[0] - setpoint(-step)[0]) / (2.0 * step)
    # the difference: rounding / step, and step²
    assert setpoint(0.0)[1] == pytest.approx(rate, abs=1e-8)


def lyapunov(learner: Any, true_weights: Any, e: Any, de: Any, zone: bool) -> float:
    """Return V of equations 92 and 100 for the errors e, de (2,) and the error of the weights."""
    kc, c = KD - learner.c, learner.c
    size = 0.5 * (KP + (kc + c) * c) * e @ e + c * e @ de + 0.5 * de @ de
    if zone:
        low, mu = learner.zone
        size = (
            0.0
            if size <= low
            else (size - low) ** 2 / (4 * mu)
            if size < low + 2 * mu
            else size - low - mu
        )
    weight_error = learner.state.weights - true_weights
    return size + 0.5 * float(np.sum(weight_error**2)) / learner.rate


@pytest.mark.parametrize("zone", [False, True])
def test_the_proofs_lyapunov_function_falls(zone: bool) -> None:
    """With a disturbance that the features express, V falls at -c kp e² - kc e'² times F.

    V only falls.
    """
    settings = {
        "features": 30,
        "dead_zone": {"cutoff": 0.002, "smoothing": 0.004} if zone else None,
    }
    law, h = law_of("offshore_resonant", {"control.adaptation": settings}), 1e-3
    learner, c, kc = law.tracker.disturbance_estimator, 0.5, KD - 0.5
    true_weights = np.random.default_rng(1).normal(0.0, 0.05, (60, 2))
    e, de, values, expected_decrease = np.array([0.1, -0.05]), np.array([0.0, 0.1]), [], 0.0
    for k in range(8000):  # eight seconds, the reference rests at (1.35, 0)
        law(k * h, *hanging(e + (1.35, 0.0), de))
        values.append(lyapunov(learner, true_weights, e, de, zone))
        size = values[0] if not zone else 0.5 * (KP + KD * c) * e @ e + c * e @ de + 0.5 * de @ de
        expected_decrease += (
            h * (c * KP * e @ e + kc * de @ de) * learning_factor(learner.zone, size)
        )
        dde = -KP * e - KD * de + (learner.state.weights - true_weights).T @ learner.state.values
        de = de + h * dde
        e = e + h * de
    # a step of length h errs by about h / 2 of what V falls by, and by h² w0² of V where it stands
    # still
    assert np.max(np.diff(values)) < h**2 * KP * values[0]
    assert values[0] - values[-1] == pytest.approx(expected_decrease, rel=0.02)
    assert values[0] - values[-1] > 0.1 * values[0]


def test_poles_of_the_linearised_loop() -> None:
    """Law and plant, linearised, have the poles of the characteristic equation.

    They are linearised numerically where the load hangs still.

    (s² + w0²)(s² + kd0 s + kp0) = kp0 (w0² - kd s - kp), for each axis.
    """
    scene, step = load_scene("offshore_obstacle", {"control.kp": 5.0, "control.kd": 1.5}), 1e-5
    law, moving = scene.law, [0, 1, 3, 4]
    assert law is not None
    matrix = np.zeros((8, 8))
    matrix[:4, 4:] = np.eye(4)
    for k in range(8):
        sides = []
        for sign in (1.0, -1.0):
            q, v = np.array([1.35, 0.0, 0.0, 0.0, 0.0, -1.0]), np.zeros(6)
            (q if k < 4 else v)[moving[k % 4]] += sign * step
            effort = law(0.0, tuple(q), tuple(v))
            sides.append(crane_sim.acceleration(scene, q, v, effort)[moving])
        matrix[4:, k] = (sides[0] - sides[1]) / (2.0 * step)
    w2, kp0, kd0 = KP, 676.0, 36.4
    right = [kp0 * -1.5, kp0 * (w2 - 5.0)]
    poles = np.sort_complex(np.roots(np.polysub(np.polymul([1, 0, w2], [1, kd0, kp0]), right)))
    assert np.all(poles.real < 0.0)
    for axis in (slice(0, None, 2), slice(1, None, 2)):
        actual = np.sort_complex(np.linalg.eigvals(matrix[axis, axis]))
        # differences of efforts of a thousand: 1e3 * 1e-16 / 1e-5 of rounding, and of the step's
        # square, 1e3 * 1e-10
        assert np.allclose(actual, poles, rtol=0, atol=1e-6)
    assert not np.any(matrix[::2, 1::2]) and not np.any(matrix[1::2, ::2])


SERVO = {"suspension": {"drive": "servo", "kp": 676.0, "kd": 36.4}}
ALONG_X = {"control.law": "angular", "initial.direction": [1.0, 0.0, 0.0]}
REJECTED: list[tuple[dict[str, Any], str]] = [
    (
        {"control.law": "cartesian", "reference": {"q": [1.0, 0.0]}},
        "reference.path: .* needs one of the payload",
    ),
    ({"control.law": "cartesian", "suspension.height": "driven"}, "suspension.height: fixed"),
    ({"control.law": "cartesian", "gravity": 0.0}, "gravity = 0: .* needs gravity"),
    ({"control.servo": {"kp": 1.0}, **SERVO}, "control.servo: the suspension has one itself"),
    ({"control.law": "angular", **SERVO}, "'servo': the angular law commands accelerations"),
    ({"control.adaptation": {"c": 1.2}}, "adaptation.c = 1.2: must be below kd = 1.118"),
    (
        {"control.law": "harmonic", "control.observer": [1]},
        r"control.observer = \[1\]: must be a group of keys: freq",
    ),
    (
        {"control.law": "harmonic", "control.observer": {"frequency": 20.0}},
        r"control.observer.frequency = 20: must be 0.28 to 8.39 rad/s, 0.1 to 3 times the natural "
        r"frequency",
    ),
    (
        {"control.period": "continuous"},
        "control.period = 'continuous': 'adaptive' is a sampled law: give a period",
    ),
    (
        {"control.law": "cartesian", "control.adaptation": {}},
        "unknown key 'adaptation' for law 'cartesian'",
    ),
    (
        ALONG_X,
        r"initial.direction = \[1.0, 0.0, 0.0\]: the rope is horizontal, where the angular law",
    ),
    (
        {"control.law": "harmonic", "control.feedforward": {"base": True}},
        "feedforward.base: must be left out, the harmonic law",
    ),
]


@pytest.mark.parametrize(
    ("changes", "message"), REJECTED, ids=lambda value: value if isinstance(value, str) else ""
)
def test_what_does_not_fit_is_a_single_line_error(changes: dict[str, Any], message: str) -> None:
    """A law, or settings, that do not fit the scene are single-line errors with the key."""
    with pytest.raises(SceneError, match=message) as caught:
        load_scene("offshore_resonant", changes)
    assert "\n" not in str(caught.value)
