"""What offshore laws see and observe: camera frames, repeated questions, a disturbance.

Questions are repeated at one time.
"""

from math import cos, exp, pi, sin, sqrt
from typing import Any

import pytest

from crane_control.estimation.oscillator import THETA, D
from crane_sim.laws import with_initial_state
from crane_sim.scenes.scene import load_scene

LENGTH, KP = 1.255, 9.81 / 1.255  # m, 1/s²
Q = (1.3, 0.05, 0.0, 0.06, -0.08, -sqrt(1.0 - 0.06**2 - 0.08**2))
# across the link
V = (0.02, -0.03, 0.0, 0.1, 0.2, (0.06 * 0.1 - 0.08 * 0.2) / sqrt(1.0 - 0.06**2 - 0.08**2))


def law_of(scene: str, changes: dict[str, Any] | None = None) -> Any:
    """Return the law of a scene, with nothing learnt yet."""
    return with_initial_state(load_scene(scene, changes).law)


def hanging(y: Any, dy: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return joint positions and velocities of a payload at y that hangs straight down.

    It moves with its tip.
    """
    return (y[0], y[1], 0.0, 0.0, 0.0, -1.0), (dy[0], dy[1], 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("law", ["adaptive", "harmonic"])
def test_a_law_called_twice_at_one_time_learns_once(law: str) -> None:
    """A second question at the same time gets the same answer, without later effect."""
    changes = {"control": {"law": law, "period": 0.004, "vision": {"rate": 30.0, "latency": 0.05}}}
    answers = []
    for times in (1, 2):
        law_of_run = law_of("offshore_resonant", changes)
        answers.append([[law_of_run(k * 0.004, Q, V) for _ in range(times)][-1] for k in range(60)])
    assert answers[0] == answers[1]


def test_the_observer_finds_a_disturbance_that_it_was_not_told() -> None:
    """From late frames of a payload forced at 3.5 rad/s it finds frequency and force.

    The force is that of the moment.
    """
    vision, w, force = {"rate": 30.0, "latency": 0.05, "noise": 0.0}, 3.5, 0.3
    # the rope's length is unobservable while the tip is at rest
    observer = {"wander": 0.5, "rope": 0.0}
    control = {"law": "harmonic", "period": 0.004, "vision": vision, "observer": observer}
    law, t = law_of("offshore_obstacle", {"control": control}), 0.0
    ekf = law.tracker.disturbance_estimator.ekf
    size = force / (KP - w * w) / LENGTH  # of y'' = w0² (tip - y) + d, the tip at rest
    x = ekf.state.x
    assert sqrt(ekf.theta) == pytest.approx(0.8 * sqrt(KP))
    for k in range(5000):
        t = 0.004 * k
        n, rate = size * sin(w * t), size * w * cos(w * t)
        height = sqrt(1.0 - n * n)
        law(t, (1.35, 0.0, 0.0, n, 0.0, -height), (0.0, 0.0, 0.0, rate, 0.0, n * rate / height))
    assert sqrt(x[0, THETA]) == pytest.approx(w, rel=0.01)  # it comes nearer by a tenth a second
    # what the frequency is off by, over the 0.05 s of a late frame and the time that the filter
    # looks back, is 3 %
    assert x[0, D] == pytest.approx(force * sin(w * t), abs=0.03 * force)
    assert abs(x[1, D]) < 1e-6  # nothing forces the other axis


def test_a_camera_is_late_holds_and_filters() -> None:
    """Frames are used once old enough and held between; velocities are backward differences."""
    vision = {"rate": 10.0, "latency": 0.12, "noise": 0.0, "low_pass": 1.0}
    law = law_of("offshore_obstacle", {"control.vision": vision})
    state, gain = law.tracker.camera.state, 1.0 - exp(-2.0 * pi * 1.0 / 10.0)
    ages, filtered = [], 1.35
    for k in range(100):
        t = k * 0.01
        law(t, *hanging((1.35 + 0.1 * t, 0.0), (0.1, 0.0)))
        ages.append(t - state.last_used_frame[0])
        if ages[-1] < ages[k - 1]:  # a frame has come in
            before, filtered = filtered, filtered + gain * (state.last_used_frame[1] - filtered)
            assert state.filtered[0] == pytest.approx(filtered, abs=1e-12)
            assert state.filtered[2] == pytest.approx((filtered - before) / 0.1, abs=1e-11)
    assert min(ages[12:]) == pytest.approx(0.12) and max(ages[12:]) == pytest.approx(0.21)
    noise = law_of("offshore_vision").tracker.camera.noise_samples
    assert noise.std() == pytest.approx(0.002, rel=0.05)  # of 3600 numbers
