"""The largest efforts that a plant takes."""

import pytest

from crane_sim import load_scene
from crane_sim.ros.common.command_filter import largest_efforts


def test_inertia_and_gravity_of_the_scene_bound_efforts() -> None:
    """The rope, which lifts the payload alone, has the bound of its mass and weight; an imposed motion has its own."""
    scene = load_scene("knuckle_setpoint", {"payload.mass": 2.5})
    by_joint = dict(zip(scene.actuated, largest_efforts(scene), strict=True))
    expected = 2.5 * 1e5 + 2.5 * scene.document.get("gravity", 9.81) * 1e3
    assert by_joint["rope"] == pytest.approx(expected, rel=1e-6)  # differences of a potential that is linear
    assert set(largest_efforts(load_scene("offshore_resonant"))) == {1e5}


def test_one_bound_for_all_joints_if_that_is_wished() -> None:
    """A bound that is given holds for every joint."""
    assert largest_efforts(load_scene("knuckle_setpoint"), 7.0) == (7.0,) * 4


def test_a_crane_without_actuators_has_no_bounds() -> None:
    """Where no joint takes commands, there is nothing to bound."""
    assert largest_efforts(load_scene("overhead_sway")) == ()
