"""Tracking on a knuckle boom: its joint efforts realise the suspension point's acceleration.

The law commands this acceleration.
"""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_control.tracking.knuckle_boom import clamp_to_workspace, winch_efforts
from crane_control.tracking.tracker import TipSetpoint
from crane_sim.files.errors import SceneError
from crane_sim.models.cables.rope import MotionRope, RopeKinematics
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.rollout import simulate
from crane_sim.trajectories.minimum_jerk import MinimumJerk
from crane_sim.trajectories.replanning import with_trajectory
from crane_sim.trajectories.trajectory import compile_trajectory

BOOM, JIB, LENGTH = 1.0, 0.85, 1.255
EVERYTHING = {
    "boom.axial_inertia": 0.1,
    "jib.axial_inertia": 0.05,
    "springs": {
        "boom": {"stiffness": 50.0, "rest": 0.5},
        "jib": {"stiffness": 30.0, "rest": -1.0, "relative": True},
    },
    "swing_friction": {"model": "linear", "tangential": 0.3, "radial": 0.2},
    "payload_drag": {"coefficient": 0.3},
    "base_motion.roll": {"amplitude": 0.1, "frequency": 1.3},
    "reference.path.radius": 1.0,  # so that setpoints are in the workspace
    "control": {"law": "cartesian", "period": 0.004, "feedforward": {"base": True}},
}
SHARED = {key: EVERYTHING[key] for key in ("base_motion.roll", "reference.path.radius", "control")}
WINCH = SHARED | {"rope.drive": "force", "springs": {"rope": {"stiffness": 20.0, "rest": 1.0}}}
STILL = {"base_motion.sway.amplitude": 0.0}
SERVO = (676.0, 36.4)  # 1/s², 1/s, of the tip where a scene says nothing else
HEIGHT = BOOM * np.sin(np.pi / 3.0)  # m, initial height of the tip
IDEAL: Any = load_scene("offshore_resonant", SHARED)


def phasor_derivatives(
    angle: float, rate: float, second: float = 0.0
) -> tuple[complex, complex, complex]:
    """Return exp(i angle) and its first two derivatives, for an angle with these derivatives."""
    phasor = np.exp(1j * angle)
    return phasor, 1j * rate * phasor, (1j * second - rate * rate) * phasor


def tip_of(q: Any, v: Any, a: Any) -> np.ndarray:
    """Return position, velocity, acceleration (3, 3) of the tip, from sums of phasors.

    The phasors are in the complex plane.
    """
    across = sum(
        0.5
        * length
        * np.array(phasor_derivatives(q[0] + sign * q[k], v[0] + sign * v[k], a[0] + sign * a[k]))
        for k, length in ((1, BOOM), (2, JIB))
        for sign in (1.0, -1.0)
    )
    up = BOOM * np.array(phasor_derivatives(q[1], v[1], a[1])) + JIB * np.array(
        phasor_derivatives(q[2], v[2], a[2])
    )
    return np.column_stack([across.real, across.imag, up.imag])


def rope_of(q: Any, v: Any) -> np.ndarray:
    """Return the unit vector from tip to payload and its rate (2, 3)."""
    (s1, c1, s2, c2), (w1, w2) = (np.sin(q[4]), np.cos(q[4]), np.sin(q[5]), np.cos(q[5])), v[4:]
    phase, dphase, _ = phasor_derivatives(q[0], v[0])
    horizontal, dhorizontal = s2 + 1j * c2 * s1, c2 * w2 + 1j * (c2 * c1 * w1 - s2 * s1 * w2)
    n, dn = phase * horizontal, dphase * horizontal + phase * dhorizontal
    return np.array([[n.real, n.imag, -c2 * c1], [dn.real, dn.imag, s2 * c1 * w2 + c2 * s1 * w1]])


def states(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return random states with boom and jib angle of either sign, on a rope of nominal length.

    The angle is that between boom and jib.
    """
    rng, pairs = np.random.default_rng(5), []
    for k in range(count):
        elbow = (-1.0) ** k * rng.uniform(0.4, 2.2)
        beta = rng.uniform(0.7, 1.2) if elbow < 0 else rng.uniform(-0.8, -0.2)
        q = np.array(
            [rng.uniform(-3.0, 3.0), beta, beta + elbow, LENGTH, *rng.uniform(-0.5, 0.5, 2)]
        )
        pairs.append((q, np.array([*rng.uniform(-0.5, 0.5, 3), 0.0, *rng.uniform(-0.5, 0.5, 2)])))
    return pairs


def commanded_and_actual_acceleration(
    scene: Any, t: float, q: Any, v: Any
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (commanded tip acceleration (3,), its actual one (3,), joint accelerations (6,)).

    The command is that of the law for an ideal suspension point at the tip, and that of the servo
    of the height.
    """
    (n, dn), (tip, dtip, _) = rope_of(q, v), tip_of(q, v, np.zeros(3))
    across = IDEAL.law(t, (*tip, *n), (*dtip, *dn))
    vertical = -SERVO[1] * dtip[2] - SERVO[0] * (tip[2] - HEIGHT)
    qdd = crane_sim.acceleration(scene, q, v, scene.law(t, tuple(q), tuple(v)), t)
    return np.array([*across, vertical]), tip_of(q, v, qdd)[2], qdd


@pytest.mark.parametrize("changes", [EVERYTHING, WINCH], ids=["everything", "winch"])
def test_the_tip_accelerates_as_an_ideal_suspension_point(changes: dict[str, Any]) -> None:
    """Efforts give the tip what the law commands of a pendulum, and hold its height.

    They are put through the forward dynamics.
    """
    scene = load_scene("knuckle_tracking", changes)
    for k, (q, v) in enumerate(states(6)):
        commanded, actual, qdd = commanded_and_actual_acceleration(scene, 3.0 * k, q, v)
        # equations solved there and back in doubles, of jib angles of 0.4 rad: rounding times 1e2,
        # relative
        assert np.max(np.abs(actual - commanded)) < 1e-12 * np.max(np.abs(commanded))
        assert abs(qdd[3]) < 1e-12 * np.max(np.abs(commanded))  # the rope keeps its length


@pytest.mark.parametrize(("time_constant", "expected"), [(None, 0.5), (0.1, 0.25)])
def test_input_of_a_rate_driven_winch_gives_the_acceleration(
    time_constant: float | None, expected: float
) -> None:
    """The winch's input is the rope's acceleration, or the rate that gives it with a lag.

    A winch that lags then accelerates the rope so.
    """
    rope_state = RopeKinematics((0.0, 0.0, -1.0), LENGTH, 0.2, (0.0, 0.0, -0.2))
    assert winch_efforts(MotionRope(time_constant), rope_state, 0.5, 9.0) == (expected,)


@pytest.mark.parametrize("elbow", [0.0, 0.0999, np.pi - 0.05])
def test_in_line_the_joints_stay_bounded(elbow: float) -> None:
    """With boom and jib nearly in line, accelerations are bounded.

    Across the line the tip's is as commanded.
    """
    scene = load_scene("knuckle_tracking", EVERYTHING)
    q = np.array([0.3, 0.7, 0.7 + elbow, LENGTH, 0.1, -0.05])
    commanded, actual, qdd = commanded_and_actual_acceleration(scene, 2.0, q, np.zeros(6))
    outward = np.array([np.cos(0.3), np.sin(0.3), 0.0])
    plane = np.array([outward @ commanded, commanded[2]])
    # the least singular value of two unit vectors with a sine of 0.1 between them is 0.1 / sqrt(2),
    # to 0.1 %
    assert np.hypot(BOOM * qdd[1], JIB * qdd[2]) < 1.001 * np.sqrt(2.0) / 0.1 * np.linalg.norm(
        plane
    )
    across = -np.sin(0.7) * outward + np.array([0.0, 0.0, np.cos(0.7)])
    # damped by at most 0.01 of 2, and rotated by half an angle of at most 0.1 rad
    assert abs(across @ (actual - commanded)) < (0.005 + 0.05) * np.linalg.norm(plane)


def test_above_the_tower_the_slew_stays_bounded() -> None:
    """With the tip on the tower's axis the slew is not accelerated.

    Near the axis it is not more than at a tenth of a metre.
    """
    scene = load_scene("knuckle_tracking", EVERYTHING)
    for radius in (0.0, 1e-3, 0.05):
        beta = np.arccos((radius - JIB * np.cos(2.4)) / BOOM)
        q = np.array([0.3, beta, 2.4, LENGTH, 0.1, -0.05])
        commanded, _, qdd = commanded_and_actual_acceleration(scene, 2.0, q, np.zeros(6))
        assert abs(qdd[0]) < 1e-9 + np.linalg.norm(commanded[:2]) * radius / 0.1**2


@pytest.mark.parametrize(
    ("x", "expected"),
    [((0.0, 0.0), (0.5, 0.0)), ((3e-9, -4e-9), (0.3, -0.4)), ((6.0, 8.0), (4.8, 6.4))],
)
def test_setpoints_are_moved_to_the_edge(
    x: tuple[float, float], expected: tuple[float, float]
) -> None:
    """Outside the workspace a setpoint is at rest at the nearest place within it.

    On the tower's axis it is so, too.
    """
    clamped = clamp_to_workspace((0.5, 8.0), TipSetpoint(x, (1.0, 0.0), (1.0, 0.0)))
    assert clamped.x == pytest.approx(expected, rel=1e-14) and not any((*clamped.v, *clamped.a))


@pytest.mark.slow
def test_a_trajectory_outside_the_workspace_is_clamped() -> None:
    """Sent 2.5 m out while running, the tip rests at the edge of its workspace.

    It tracks again from there.
    """
    scene = load_scene("knuckle_tracking", STILL | {"control.law": "cartesian", "duration": 40.0})
    trajectory = MinimumJerk(
        ((1.35, 0.0), (2.5, 0.0), (1.35, 0.0)), (1.0, 8.0, 15.0)
    ).to_polynomials()
    run = simulate(scene, with_trajectory(scene.law, compile_trajectory(trajectory)))
    max_length_sq = BOOM**2 + JIB**2 + 2.0 * BOOM * JIB * np.sqrt(1.0 - 0.3**2)
    edge, radius = np.sqrt(max_length_sq - HEIGHT**2), np.hypot(run.tip[:, 0], run.tip[:, 1])
    # a servo with damping ratio 0.7 that is stopped at 0.3 m/s overshoots by 0.3 / 26 e^-0.8 m at
    # most
    assert np.max(radius) < edge + 0.006
    at_edge = radius[(run.t > 5.0) & (run.t < 11.0)]
    assert np.max(np.abs(at_edge - edge)) < 1e-3
    assert np.linalg.norm(run.payload[-1, :2] - (1.35, 0.0)) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "changes"),
    [("cartesian", STILL), ("angular", STILL), ("adaptive", {}), ("harmonic", {})],
)
def test_joint_efforts_track_as_an_ideal_suspension_point(
    law: str, changes: dict[str, Any]
) -> None:
    """The boom's payload follows its path with at most twice the ideal mean square error.

    The ideal one is that of a driven suspension point.
    """
    boom, ideal = (
        simulate(load_scene(name, changes | {"control.law": law})).summary["tracking_mse"]
        for name in ("knuckle_tracking", "offshore_resonant")
    )
    assert boom < 2.0 * ideal


REJECTED: list[tuple[dict[str, Any], str]] = [
    (
        {"initial.q": [0, "60 deg", "60 deg", 1.255, 0, 0]},
        r"initial.q: the tip begins 0.925 m .* 0.2 to 0.88\d* m",
    ),
    (
        {"reference.path.radius": 1.7},
        r"reference.path: is at t = [\d.]* s 1.7 m .* drives the tip 0.2 to 1.61\d* m",
    ),
    ({"reference.path.centre": [1.35, 0.0]}, "reference.path: is at t = .*'adaptive'"),
]


@pytest.mark.parametrize(
    ("changes", "message"), REJECTED, ids=lambda value: value if isinstance(value, str) else ""
)
def test_what_the_boom_cannot_reach_is_a_single_line_error(
    changes: dict[str, Any], message: str
) -> None:
    """A start or a path that needs a singular posture is rejected by a single-line error."""
    with pytest.raises(SceneError, match=message) as caught:
        load_scene("knuckle_tracking", changes)
    assert "\n" not in str(caught.value)
