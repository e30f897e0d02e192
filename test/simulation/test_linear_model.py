"""The linear equations of a scene against closed forms and against the motion itself."""

from math import sqrt
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.files.errors import SceneError

G = 9.81
VISCOUS = 1.0  # N s/m, of overhead_friction


def test_a_pendulum_below_a_trolley_is_its_closed_form() -> None:
    """A and B of one rope below a trolley are: M ẍ = u + m g θ, L θ̈ = -ẍ - g θ.

    These are the equations of textbooks for a free trolley.
    """
    mass, load, length = 20.0, 10.0, 2.0  # of the scene
    model = crane_sim.linearise("overhead_energy")
    a, b = np.zeros((4, 4)), np.zeros((4, 1))
    a[:2, 2:] = np.eye(2)
    a[2, 1], a[3, 1] = load * G / mass, -(1.0 + load / mass) * G / length
    b[2, 0], b[3, 0] = 1.0 / mass, -1.0 / (mass * length)
    # of the swing, either convention
    sign = np.diag([1.0, np.sign(model.a[2, 1]), 1.0, np.sign(model.a[2, 1])])
    # derivatives are exact to rounding
    np.testing.assert_allclose(sign @ model.a @ sign, a, atol=1e-13)
    np.testing.assert_allclose(sign @ model.b, b, atol=1e-13)
    assert (
        model.states[0] == "trolley"
        and model.state_units[2] == "m/s"
        and model.input_units == ("N",)
    )
    frequency = sqrt((1.0 + load / mass) * G / length)
    assert np.max(model.eigenvalues.imag) == pytest.approx(frequency, rel=1e-12)


def test_weights_are_held() -> None:
    """The efforts of the model hold the knuckle boom at rest, and elsewhere other ones do."""
    scene = crane_sim.load_scene("knuckle_setpoint")
    for at in (None, [0.2, *scene.initial_q[1:4]]):
        model = crane_sim.linearise(scene, at)
        still = crane_sim.acceleration(scene, model.q, np.zeros(len(model.q)), model.u)
        assert np.max(np.abs(still)) < 1e-9  # rad/s², what the search for rest calls none
        assert at is None or model.q[0] == 0.2


def test_a_locked_rope_keeps_its_length() -> None:
    """At rest the load hangs down on its rope's length, which no effort or deviation changes."""
    model = crane_sim.linearise("knuckle_tracking")
    # rad, of the last step of Newton's method
    assert model.q[3] == 1.255 and np.max(np.abs(model.q[4:])) < 1e-9
    assert model.a[11, 5] < -G / 1.255  # hangs, and the boom that gives way makes it faster


def test_a_joint_with_viscous_friction_alone_is_not_stuck() -> None:
    """Without dry friction a trolley at rest gives way to any force, by viscous friction."""
    model = crane_sim.linearise("overhead_friction")
    assert model.a[2, 1] != 0.0
    assert model.a[2, 2] == pytest.approx(-model.b[2, 0] * VISCOUS, rel=1e-12)


def test_directions_have_as_many_deviations_as_they_can_take() -> None:
    """A link in space has three components, two deviations, and one frequency in both."""
    model = crane_sim.linearise("bridge_hook_and_sling")
    n = len(model.states) // 2
    assert model.basis.shape[1] == n < model.basis.shape[0]
    assert model.a.shape == (2 * n, 2 * n) and model.b.shape == (2 * n, len(model.inputs))
    assert len(model.state_units) == 2 * n


@pytest.mark.parametrize(
    ("angle", "hoisted"), [("0 deg", False), ("10 deg", True), ("100 deg", False)]
)
def test_an_elastic_cable_is_linearised_where_it_hangs(angle: str, hoisted: bool) -> None:
    """Whatever the release angle, nodes at rest hang as deep as closed forms; nothing grows."""
    masses, stiffness = np.array([1.0, 2.0, 10.0]), np.array([1e6, 1e5, 1e6])
    cable = {"model": "elastic", "lengths": [1.0, 0.5, 0.5], "damping": 100.0}
    cable |= {"node_masses": masses.tolist(), "stiffness": stiffness.tolist()}
    document = {
        "crane": "overhead",
        "duration": 1.0,
        "cable": cable,
        "initial": {"angles": [angle]},
    }
    document |= {"trolley": {"drive": "force", "mass": 5.0}}
    document |= {"hoist": {"drive": "force", "inertia": 3.0}} if hoisted else {}
    model, first = (
        crane_sim.linearise(document, [3.0, 2.0] if hoisted else [3.0]),
        2.0 if hoisted else 1.0,
    )
    stretch = G * np.cumsum(masses[::-1])[::-1] / stiffness
    depths, nodes = (
        np.cumsum(np.array([first, 0.5, 0.5]) + stretch),
        model.q[1 + hoisted :].reshape(3, 2),
    )
    # 1e-12 m: rounding; 1e-4 1/s: the roots of the free trolley are the root of rounding, 1e-10,
    # from 0
    np.testing.assert_allclose(
        nodes, np.column_stack([np.full(3, 3.0), -depths]), rtol=0.0, atol=1e-12
    )
    assert model.eigenvalues[0].real < 1e-4
    assert model.u[-1] == pytest.approx(-G * masses.sum() if hoisted else 0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("at", "shown"),
    [
        ([1.0, 2.0], "[1.0, 2.0]"),
        (1.0, "1.0"),
        (["a"], "['a']"),
        ([float("nan")], "[nan]"),
        (np.ones((1, 2)), "array([[1., 1.]])"),
        ([10**400], "[1000"),
    ],
)
def test_positions_that_are_none_are_refused(at: Any, shown: str) -> None:
    """What is no finite number for each actuated joint is refused in one line that shows it."""
    with pytest.raises(SceneError) as caught:
        crane_sim.linearise("overhead_energy", at)
    line = str(caught.value)
    assert (
        f"at = {shown}" in line
        and ": must be a finite position for each actuated joint: trolley" in line
    )
    assert "\n" not in line
