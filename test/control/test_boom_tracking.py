"""Tracking laws on a knuckle boom: the tip does what they demand of a suspension point, by the efforts of joints."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_control.tracking.knuckle_boom import with_winch
from crane_sim.files.errors import SceneError
from crane_sim.models.cables.rope import RateRope, Span
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.rollout import simulate
from crane_sim.trajectories.minimum_jerk import MinimumJerk
from crane_sim.trajectories.path import path_of
from crane_sim.trajectories.replanning import with_path

BOOM, JIB, LENGTH = 1.0, 0.85, 1.255
EVERYTHING = {
    "boom.axial_inertia": 0.1,
    "jib.axial_inertia": 0.05,
    "springs": {"boom": {"stiffness": 50.0, "rest": 0.5}, "jib": {"stiffness": 30.0, "rest": -1.0, "relative": True}},
    "swing_friction": {"model": "linear", "tangential": 0.3, "radial": 0.2},
    "payload_drag": {"coefficient": 0.3},
    "base_motion.roll": {"amplitude": 0.1, "frequency": 1.3},
    "reference.path.radius": 1.0,  # so that demands are within reach
    "control": {"law": "cartesian", "period": 0.004, "feedforward": {"base": True}},
}
SHARED = {key: EVERYTHING[key] for key in ("base_motion.roll", "reference.path.radius", "control")}
WINCH = SHARED | {"rope.drive": "force", "springs": {"rope": {"stiffness": 20.0, "rest": 1.0}}}
STILL = {"base_motion.sway.amplitude": 0.0}
SERVO = (676.0, 36.4)  # 1/s², 1/s, of the tip where a scene says nothing else
HEIGHT = BOOM * np.sin(np.pi / 3.0)  # m, at which the scene begins
IDEAL: Any = load_scene("offshore_resonant", SHARED)


def turned(angle: float, rate: float, second: float = 0.0) -> tuple[complex, complex, complex]:
    """Return exp(i angle) and its first two derivatives, for an angle that changes so."""
    at = np.exp(1j * angle)
    return at, 1j * rate * at, (1j * second - rate * rate) * at


def tip_of(q: Any, v: Any, a: Any) -> np.ndarray:
    """Return position, velocity, acceleration (3, 3) of the tip, from sums of turning pointers in the complex plane."""
    across = sum(
        0.5 * length * np.array(turned(q[0] + sign * q[k], v[0] + sign * v[k], a[0] + sign * a[k]))
        for k, length in ((1, BOOM), (2, JIB))
        for sign in (1.0, -1.0)
    )
    up = BOOM * np.array(turned(q[1], v[1], a[1])) + JIB * np.array(turned(q[2], v[2], a[2]))
    return np.column_stack([across.real, across.imag, up.imag])


def rope_of(q: Any, v: Any) -> np.ndarray:
    """Return the unit vector from tip to payload and its rate (2, 3)."""
    (s1, c1, s2, c2), (w1, w2) = (np.sin(q[4]), np.cos(q[4]), np.sin(q[5]), np.cos(q[5])), v[4:]
    turn, turning, _ = turned(q[0], v[0])
    level, changing = s2 + 1j * c2 * s1, c2 * w2 + 1j * (c2 * c1 * w1 - s2 * s1 * w2)
    n, dn = turn * level, turning * level + turn * changing
    return np.array([[n.real, n.imag, -c2 * c1], [dn.real, dn.imag, s2 * c1 * w2 + c2 * s1 * w1]])


def states(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return random states of a moving crane whose knee is bent either way, on a rope of the nominal length."""
    rng, found = np.random.default_rng(5), []
    for k in range(count):
        knee = (-1.0) ** k * rng.uniform(0.4, 2.2)
        beta = rng.uniform(0.7, 1.2) if knee < 0 else rng.uniform(-0.8, -0.2)
        q = np.array([rng.uniform(-3.0, 3.0), beta, beta + knee, LENGTH, *rng.uniform(-0.5, 0.5, 2)])
        found.append((q, np.array([*rng.uniform(-0.5, 0.5, 3), 0.0, *rng.uniform(-0.5, 0.5, 2)])))
    return found


def asked_and_done(scene: Any, t: float, q: Any, v: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (acceleration (3,) that is demanded of the tip, what it is (3,), joint accelerations (6,)).

    The demand is what the law commands of an ideal suspension point that is where the tip is, and the servo's height.
    """
    (n, dn), (tip, dtip, _) = rope_of(q, v), tip_of(q, v, np.zeros(3))
    across = IDEAL.law(t, (*tip, *n), (*dtip, *dn))
    rise = -SERVO[1] * dtip[2] - SERVO[0] * (tip[2] - HEIGHT)
    bent = crane_sim.acceleration(scene, q, v, scene.law(t, tuple(q), tuple(v)), t)
    return np.array([*across, rise]), tip_of(q, v, bent)[2], bent


@pytest.mark.interpreted
@pytest.mark.parametrize("changes", [EVERYTHING, WINCH], ids=["everything", "winch"])
def test_the_tip_accelerates_as_an_ideal_suspension_point(changes: dict[str, Any]) -> None:
    """Efforts, put through the forward dynamics, give the tip what the law commands of a pendulum, and hold height."""
    scene = load_scene("knuckle_tracking", changes)
    for k, (q, v) in enumerate(states(6)):
        wanted, found, bent = asked_and_done(scene, 3.0 * k, q, v)
        # equations solved there and back in doubles, of knees bent by 0.4 rad: rounding times 1e2, relative
        assert np.max(np.abs(found - wanted)) < 1e-12 * np.max(np.abs(wanted))
        assert abs(bent[3]) < 1e-12 * np.max(np.abs(wanted))  # the rope keeps its length


@pytest.mark.interpreted
@pytest.mark.parametrize(("time_constant", "given"), [(None, 0.5), (0.1, 0.25)])
def test_a_rate_driven_winch_is_given_what_accelerates_its_rope(time_constant: float | None, given: float) -> None:
    """The winch's input is the rope's acceleration, or the rate that makes a winch that lags accelerate it so."""
    line = Span((0.0, 0.0, -1.0), LENGTH, 0.2, (0.0, 0.0, -0.2))
    assert with_winch(RateRope(time_constant), (1.0, 2.0, 3.0), line, 0.5, 9.0) == (1.0, 2.0, 3.0, given)


@pytest.mark.interpreted
@pytest.mark.parametrize("knee", [0.0, 1e-3, -0.05, 0.0999, np.pi, np.pi - 0.05])
def test_in_line_the_joints_stay_bounded(knee: float) -> None:
    """With boom and jib nearly in line, accelerations are bounded, and across the line the tip still does as asked."""
    scene = load_scene("knuckle_tracking", EVERYTHING)
    q = np.array([0.3, 0.7, 0.7 + knee, LENGTH, 0.1, -0.05])
    wanted, found, bent = asked_and_done(scene, 2.0, q, np.zeros(6))
    along = np.array([np.cos(0.3), np.sin(0.3), 0.0])
    plane = np.array([along @ wanted, wanted[2]])
    # the least singular value of two unit vectors with a sine of 0.1 between them is 0.1 / sqrt(2), to 0.1 %
    assert np.hypot(BOOM * bent[1], JIB * bent[2]) < 1.001 * np.sqrt(2.0) / 0.1 * np.linalg.norm(plane)
    across = -np.sin(0.7) * along + np.array([0.0, 0.0, np.cos(0.7)])
    # damped by at most 0.01 of 2, and turned by half a knee of at most 0.1 rad
    assert abs(across @ (found - wanted)) < (0.005 + 0.05) * np.linalg.norm(plane)


@pytest.mark.interpreted
def test_in_line_the_knee_brakes() -> None:
    """A knee that straightens while the tip rests is braked by the servo's damping, the only direction that is lost."""
    scene = load_scene("knuckle_tracking", EVERYTHING)
    q, v = np.array([0.3, 0.7, 0.7, LENGTH, 0.1, -0.05]), np.array([0.0, 0.5 / BOOM, -0.5 / JIB, 0.0, 0.0, 0.0])
    _, _, bent = asked_and_done(scene, 2.0, q, v)
    # equations solved there and back in doubles, damped by 0.01: rounding of accelerations of 1e4 1/s²
    assert BOOM * bent[1] - JIB * bent[2] == pytest.approx(-SERVO[1] * 1.0, abs=1e-9)


@pytest.mark.interpreted
def test_above_the_tower_the_slew_stays_bounded() -> None:
    """With the tip on the tower's axis the slew is not accelerated, and near it not more than at a tenth of a metre."""
    scene = load_scene("knuckle_tracking", EVERYTHING)
    for radius in (0.0, 1e-3, 0.05):
        knee = np.arccos((radius - JIB * np.cos(2.4)) / BOOM)
        q = np.array([0.3, knee, 2.4, LENGTH, 0.1, -0.05])
        wanted, _, bent = asked_and_done(scene, 2.0, q, np.zeros(6))
        assert abs(bent[0]) < 1e-9 + np.linalg.norm(wanted[:2]) * radius / 0.1**2


@pytest.mark.slow
def test_a_path_beyond_reach_is_followed_as_far_as_it_goes() -> None:
    """Sent 2.5 m out while running, the tip waits at the edge of its reach, and tracks again from where it can."""
    scene = load_scene("knuckle_tracking", STILL | {"control.law": "cartesian", "duration": 40.0})
    way = MinimumJerk(((1.35, 0.0), (2.5, 0.0), (1.35, 0.0)), (1.0, 8.0, 15.0)).pieces()
    run = simulate(scene, with_path(scene.law, path_of(way)))
    stretched = BOOM**2 + JIB**2 + 2.0 * BOOM * JIB * np.sqrt(1.0 - 0.3**2)
    edge, out = np.sqrt(stretched - HEIGHT**2), np.hypot(run.tip[:, 0], run.tip[:, 1])
    # a servo of 0.7 of critical damping that is stopped at 0.3 m/s overshoots by 0.3 / 26 e^-0.8 m at most
    assert np.max(out) < edge + 0.006
    waiting = out[(run.t > 5.0) & (run.t < 11.0)]
    assert np.max(np.abs(waiting - edge)) < 1e-3
    assert np.linalg.norm(run.payload[-1, :2] - (1.35, 0.0)) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "changes"), [("cartesian", STILL), ("angular", STILL), ("adaptive", {}), ("harmonic", {})]
)
def test_joint_efforts_track_as_an_ideal_suspension_point(law: str, changes: dict[str, Any]) -> None:
    """The payload of the boom follows its path with at most twice the ideal suspension point's mean square error."""
    boom, ideal = (
        simulate(load_scene(name, changes | {"control.law": law})).summary["tracking_mse"]
        for name in ("knuckle_tracking", "offshore_resonant")
    )
    assert boom < 2.0 * ideal


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"initial.q": [0, "60 deg", "60 deg", 1.255, 0, 0]}, r"initial.q: the tip begins 0.925 m .* 0.2 to 0.88\d* m"),
    ({"initial.q": [0, "60 deg", "130 deg", 1.255, 0, 0]}, "initial.q: the tip begins -0.04637 m"),
    ({"reference.path.radius": 1.7}, r"reference.path: is at t = [\d.]* s 1.7 m .* drives the tip 0.2 to 1.61\d* m"),
    ({"reference.path.centre": [1.35, 0.0]}, "reference.path: is at t = .*'adaptive'"),
    ({"reference.path": None, "reference.q": [0.0, 1.0, 0.0, 1.0]}, "reference.path: .* needs one of the payload"),
    ({"gravity": 0.0}, "gravity = 0: .* needs some"),
]


@pytest.mark.interpreted
@pytest.mark.parametrize(("changes", "line"), REFUSED, ids=lambda value: value if isinstance(value, str) else "")
def test_what_the_boom_cannot_reach_is_refused_in_one_line(changes: dict[str, Any], line: str) -> None:
    """A start or a path that needs a posture from which the tip cannot be moved freely is refused in one line."""
    with pytest.raises(SceneError, match=line) as caught:
        load_scene("knuckle_tracking", changes)
    assert "\n" not in str(caught.value)
