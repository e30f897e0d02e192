"""Assistance for an operator: the shaped speeds and the feedback of the law, in their own time."""

from math import pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import root

from crane_control.assistance import DAMPING, Assistance
from crane_sim import load_scene
from crane_sim.files.errors import SceneError
from crane_sim.operator.drives import with_operator_drives
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import derive_instant

GRAVITY = 9.81
PERIOD = 0.01


def workshop_crane() -> Scene:
    """Return the crane with a rope of 5 m."""
    return with_operator_drives(load_scene("bridge_speed_drive"))


def half_swing(length: float) -> float:
    """Return half a period [s] of the damped swing on a rope of this length [m]."""
    return pi / sqrt(GRAVITY / length * (1.0 - DAMPING**2))


@pytest.mark.long
def test_a_step_becomes_two() -> None:
    """A step of the operator's speed is passed on in two parts half a swing apart.

    The parts add up to the step.
    """
    scene = workshop_crane()
    assistance, q, seen = Assistance(scene), list(scene.initial_q), []
    for k in range(400):
        assistance.record_command(k * PERIOD, (0.4, 0.0, 0.1))
        seen.append(assistance.compute_velocity_command(k * PERIOD, q))
    trolley = np.array(seen)[:, 0]
    first, jump = trolley[0], int(np.argmax(np.diff(trolley))) + 1
    assert first == pytest.approx(0.4 / (1.0 + np.exp(-DAMPING * pi / sqrt(1.0 - DAMPING**2))))
    assert abs(jump * PERIOD - half_swing(5.0)) < PERIOD and trolley[-1] == pytest.approx(0.4)
    assert assistance.delay == pytest.approx(half_swing(5.0))


def test_assistance_that_is_switched_on_does_not_jump() -> None:
    """A speed held while the rope became longer, without assistance, is the first with it."""
    assistance, q = Assistance(scene := workshop_crane()), list(scene.initial_q)
    for k in range(1200):
        assistance.record_command(k * PERIOD, (0.4, 0.0, 0.0))
    q[scene.joint_names.index("rope")] *= 4.0
    assert assistance.compute_velocity_command(12.0, q)[0] == pytest.approx(0.4)


def test_feedback_is_that_of_the_law() -> None:
    """A swing angle a along a joint's way adds 2 z sqrt(g l) sin a to its speed alone."""
    scene = workshop_crane()
    assistance, q = Assistance(scene), list(scene.initial_q)
    moved = set()
    for swing in (3, 4):
        q[3:5] = 0.0, 0.0
        at_rest = assistance.compute_velocity_command(0.0, q)
        q[swing] = 0.05
        added = np.abs(np.array(assistance.compute_velocity_command(PERIOD, q)) - at_rest)
        assert added.max() == pytest.approx(
            2.0 * DAMPING * sqrt(GRAVITY * 5.0) * sin(0.05), rel=1e-6
        )
        assert np.sort(added)[:2].max() < 1e-9
        moved.add(int(np.argmax(added)))
    assert moved == {0, 1}  # trolley and bridge


def test_the_rope_has_its_present_length() -> None:
    """Half a second after hoisting, shaper and feedback are those of the rope's new length."""
    scene = workshop_crane()
    assistance, q = Assistance(scene), list(scene.initial_q)
    assistance.compute_velocity_command(0.0, q)
    q[2] = 2.0
    assistance.compute_velocity_command(1.0, q)
    assert assistance.delay == pytest.approx(half_swing(2.0), rel=1e-6)


def test_the_vertical_is_the_present_one() -> None:
    """On a base that moves a load that hangs plumb at the state's own time gets no feedback."""
    scene = with_operator_drives(load_scene("knuckle_sea"))
    swing, t = (
        [scene.joint_names.index(name) for name in scene.joint_names if name not in scene.actuated],
        7.0,
    )

    def posture(angles: np.ndarray) -> list[float]:
        q = list(scene.initial_q)
        for i, angle in zip(swing, angles, strict=True):
            q[i] = float(angle)
        return q

    def offset(angles: np.ndarray) -> np.ndarray:
        derived = derive_instant(scene, t, posture(angles), (0.0,) * len(scene.initial_q))
        return (derived.payload - derived.tip)[0, :2]

    plumb = root(offset, np.zeros(len(swing))).x
    assert np.abs(plumb).max() > 0.002, "the base has to be inclined"
    np.testing.assert_allclose(
        Assistance(scene).compute_velocity_command(t, posture(plumb)), 0.0, atol=1e-9
    )


def test_nothing_to_assist() -> None:
    """A crane that cannot move the load's suspension point has no assistance.

    One line says so.
    """
    changes = {"trolley": {"drive": "fixed"}, "control": None, "reference": None}
    hoist_only = with_operator_drives(load_scene("overhead_hoist_energy", changes))
    with pytest.raises(
        SceneError, match="no actuated joint moves a point below which the load swings"
    ):
        Assistance(hoist_only)


def test_coordinates_of_any_kind() -> None:
    """Loads described by places, not angles, get the same feedback.

    It is none where the load hangs still.
    """
    scene = with_operator_drives(load_scene("overhead_elastic"))
    assistance = Assistance(scene)
    still = [2.0 if name == "trolley" or name.endswith("_x") else q for name, q in named(scene)]
    assert assistance.compute_velocity_command(0.0, still) == pytest.approx((0.0,), abs=1e-9)
    aside = [
        q + 0.1 if name == scene.joint_names[-2] else q
        for name, q in zip(scene.joint_names, still, strict=True)
    ]
    length = abs(still[-1])
    assert assistance.compute_velocity_command(PERIOD, aside)[0] == pytest.approx(
        2.0 * DAMPING * sqrt(GRAVITY / length) * 0.1, rel=1e-3
    )


def named(scene: Scene) -> list[tuple[str, float]]:
    """Return the joints' names and initial positions."""
    return list(zip(scene.joint_names, scene.initial_q, strict=True))
