"""The group `contact`: contradictions are refused, stiffness 0 is none, points are converted."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.scenes.scene import load_scene

SQUARE = [[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]]
SCENE: dict[str, Any] = {
    "crane": "gantry",
    "duration": 1.0,
    "trolley": {"mass": 2e4},
    "bridge": {"mass": 1e5},
    "falls": {"top": SQUARE, "bottom": SQUARE, "axial_stiffness": 2e6},
    "payload": {"mass": 1000.0, "inertia": [1500, 900, 2000], "attachment": [0, 0, 1.0]},
    "contact": {"points": [[1, 1, -2], [1, -1, -2], [-1, 1, -2]], "height": -20.0},
    "initial": {"length": 10.0},
}
SPRINGS = {"contact.kind": "compliant", "contact.stiffness": 1e6}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"contact.points": []}, "contact.points = []: needs at least one point"),
        (
            {"contact.points": [[1, 1, -2], [1, 1, -2]]},
            "contact.points: 1 and 2 are the same; each may stand once",
        ),
        (
            {"contact.points": [[1, 1, -2], [0, 1, -2], [0, 0, 0], [-1, 1, -2]]},
            "contact.points: 1, 2 and 4 are in a line; leave out the middle one",
        ),
        (
            {"contact.height": -12.0},
            "contact.height = -12: at t = 0 point 1 is 0.01226 m below the surface",
        ),
        (
            {"contact.motion": {"heave": {"amplitude": 0.0, "frequency": 1.0, "offset": 8.5}}},
            "contact.height = -20: at t = 0 point 1 is 0.5123 m below the surface; lower it, or "
            "raise the load",
        ),
        (
            {"contact.stiffness": 1e6},
            "contact.stiffness: belongs to contact.kind: compliant, here it is rigid",
        ),
        (
            {"contact.damping": 0.1},
            "contact.damping: belongs to contact.kind: compliant, here it is rigid",
        ),
        (
            SPRINGS | {"contact.restitution": 0.1},
            "contact.restitution: belongs to contact.kind: rigid, here it is",
        ),
        (
            SPRINGS | {"contact.rest_velocity": 0.1},
            "contact.rest_velocity: belongs to contact.kind: rigid",
        ),
        (
            {"contact.kind": "compliant"},
            "contact.stiffness: is missing; a compliant contact needs it",
        ),
        (
            {"contact.restitution": 1.5},
            "contact.restitution = 1.5: must be less than or equal to 1",
        ),
        ({"contact.friction": -0.1}, "contact.friction = -0.1: must be greater than or equal to 0"),
        (
            {"contact.slip_velocity": 0.0},
            "contact.slip_velocity = 0.0: must be greater than or equal to 0.000001",
        ),
        (
            {"contact.motion": {"roll": 0.1}},
            "contact.motion: unknown key 'roll' (known: surge, sway, heave)",
        ),
        (
            {
                "falls.bottom": [[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 10]],
                "initial.position": [0, 0, -11],
            },
            "falls.top[3] = [-1.0, -1.0, 0.0]: at t = 0 both ends of this fall are at the same "
            "place",
        ),
        (
            SPRINGS | {"contact.stiffness": 1e9, "integrator": {"method": "rk4", "step": 1e-3}},
            "integrator.step = 0.001: too large for the stiffest motion",
        ),
    ],
    ids=lambda case: str(case)[:50],
)
def test_a_bad_contact_is_a_single_line_error(changes: Any, message: str) -> None:
    """What contradicts itself or cannot be is refused in one line with its keys and values."""
    with pytest.raises(crane_sim.SceneError) as caught:
        load_scene(SCENE, changes)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_springs_without_stiffness_are_absent() -> None:
    """A compliant contact of stiffness 0 gives the model, so the bits, of none."""
    without = load_scene({key: value for key, value in SCENE.items() if key != "contact"})
    assert load_scene(SCENE, SPRINGS | {"contact.stiffness": 0.0}).model._replace(
        falls=None
    ) == without.model._replace(falls=None)


def test_points_are_relative_to_the_spreader() -> None:
    """A file gives points relative to the spreader, the model to the centre of mass."""
    model = load_scene(SCENE).model
    np.testing.assert_array_equal(
        model.contact.points, np.array(SCENE["contact"]["points"]) + (0.0, 0.0, 1.0)
    )


def test_the_stiffest_motion_is_that_of_all_directions() -> None:
    """Two falls far apart turn a slim load faster than they lift it: ω² = 2 k s² / I.

    That is above 2 k / m.
    """
    ends = [[0, 3, 0], [0, -3, 0]]
    falls = {"top": ends, "bottom": ends, "axial_stiffness": 2e6}
    heavy = {
        "trolley.mass": 1e12,
        "bridge.mass": 1e12,
        "contact": None,
        "integrator": {"method": "rk4", "step": 1.0},
    }
    with pytest.raises(crane_sim.SceneError) as caught:
        load_scene(SCENE | {"falls": falls}, heavy)
    assert f"{np.sqrt(2.0 * 2e5 * 9.0 / 1500.0):.4g} rad/s" in str(caught.value)
