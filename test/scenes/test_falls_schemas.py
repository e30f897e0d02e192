"""Scene files of loads on falls, by support: rest, energy at sea, contact, refused keys."""

import warnings
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import acceleration, load_scene

ENDS = [[x, y, 0.0] for x in (0.2, -0.2) for y in (0.3, -0.3)]
LOAD = {"mass": 100.0, "inertia": [30.0, 20.0, 40.0], "attachment": [0.05, 0.02, 0.5]}
FALLS = {
    "top": ENDS,
    "bottom": [[0.7 * x, 0.9 * y, 0.0] for x, y, _ in ENDS],
    "axial_stiffness": 4e4,
}
SLEW = {
    "initial": {"q": [0.4, 6.0, 2.0]},
    "slew": {"drive": "force", "inertia": 5e3},
    "trolley": {"mass": 80.0},
}
BOOM = {
    "boom": {"mass": 100.0, "centre": 2.0, "inertia": 80.0},
    "superstructure": {"inertia": 600.0, "foot": [0.5, 1.2]},
}
KNUCKLE = {
    "boom": {"length": 5.0, "mass": 80.0, "inertia": 170.0},
    "jib": {"length": 4.0, "mass": 60.0, "inertia": 80.0},
}
CRANES: dict[str, Any] = {
    "tower": SLEW,
    "bent tower": SLEW
    | {
        "crane": "tower",
        "flexibility": {
            "vertical": {"stiffness": 1e5},
            "jib": {"mass": 50.0, "centre": 3, "inertia": 80},
        },
    },
    "mobile": BOOM
    | {
        "telescope": {"mass": 60.0, "centre": 1.5, "inertia": 40.0},
        "initial": {"q": [0.4, 0.6, 7.0, 2.0]},
    },
    "knuckle": KNUCKLE | {"tower": {"inertia": 200.0}, "initial": {"q": [0.4, 0.6, -0.2, 2.0]}},
    "pendulum": {"initial": {"tip": [1.0, 2.0, 3.0], "length": 2.0}},
}
SHIP_MOTION = {
    "heave": {"amplitude": 0.2, "frequency": 1.1},
    "roll": {"amplitude": 0.05, "frequency": 0.9},
}


def scene_document(name: str) -> dict[str, Any]:
    """Return the scene file of a crane whose load hangs at rest."""
    exact = {"method": "dop853", "rtol": 1e-11, "atol": 1e-12}
    common = {"crane": name, "duration": 0.3, "falls": FALLS, "payload": LOAD, "integrator": exact}
    return common | CRANES.get(name, {})


@pytest.mark.parametrize("name", CRANES)
def test_the_load_begins_at_rest(name: str) -> None:
    """A load without a given position hangs in equilibrium, also on slewed or bent supports."""
    scene = load_scene(scene_document(name))
    q = np.array(scene.initial_q)
    first = scene.joint_names.index("payload_x")
    qdd = acceleration(scene, q, 0.0 * q, np.zeros(len(scene.actuated)))
    # m/s² or 1/s²: a place is rounded to 1e-10 m
    assert np.abs(qdd[first : first + 7]).max() < 1e-6
    # it is rotated with the support
    assert np.abs(q[first + 3 : first + 7]).max() < 1.0 or name == "pendulum"


@pytest.mark.parametrize("name", CRANES)
def test_runs_at_sea_keep_their_balance_of_energy(name: str) -> None:
    """A load released with 20° of yaw (`skew`) on a moving base: energy audit at rounding."""
    scene = scene_document(name)
    run = crane_sim.simulate(
        scene | {"base_motion": SHIP_MOTION, "initial": scene["initial"] | {"skew": "20 deg"}}
    )
    assert run.summary["energy_audit_max"] < 1e-9


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("tower", {"rope": {"drive": "rate"}}, "rope: stands beside falls; leave out one of both"),
        ("pendulum", {"rope": {"length": 2.0}}, "rope: stands beside falls; leave out one of both"),
        ("mobile", {"links": [{"mass": 1.0, "length": 1.0}]}, "links: stands beside falls"),
        (
            "tower",
            {"falls": None, "hoist": {}},
            "hoist: belongs to falls, here are none; leave out hoist",
        ),
        (
            "tower",
            {"payload": {"mass": 1.0}},
            "payload.inertia: is missing; a load on falls is a rigid body",
        ),
        (
            "tower",
            {"payload": LOAD | {"inertia": [1, 1, 10]}},
            "payload.inertia = [1.0, 1.0, 10.0]: no rigid body",
        ),
        (
            "mobile",
            {"rope": {"reeving": {"falls": 4}}},
            "rope: stands beside falls; leave out one of both",
        ),
        (
            "knuckle",
            {"springs": {"rope": {"stiffness": 1.0, "rest": 1.0}}},
            "springs.rope: belongs to one rope and a point mass, here is falls; leave out one of "
            "both",
        ),
    ],
    ids=lambda case: str(case)[:30],
)
def test_what_contradicts_falls_is_a_single_line_error(
    name: str, changes: Any, message: str
) -> None:
    """Keys of a rope with falls, and keys of falls without, are refused in a line with both."""
    with pytest.raises(crane_sim.SceneError) as caught:
        load_scene(scene_document(name) | changes)
    assert message in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "changes", [{"payload": LOAD | {"mass": 1e308}}, {"gravity": 1e308}], ids=["mass", "gravity"]
)
def test_a_search_for_rest_that_fails_is_a_single_line_error(changes: Any) -> None:
    """Weights beyond all numbers end the search for rest in one line, without NumPy's warning."""
    with (
        warnings.catch_warnings(),
        pytest.raises(crane_sim.SceneError, match="falls: no position of rest was found"),
    ):
        warnings.simplefilter("error")
        load_scene(scene_document("pendulum") | changes)


def test_a_search_for_rest_goes_on_where_ends_meet() -> None:
    """The search finds rest although both ends of one of two falls are at one place at first.

    That fall is hung lower by twice its length.
    """
    body, ends = (
        {"mass": 100.0, "inertia": [30.0, 20.0, 40.0]},
        {"bottom": [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]},
    )
    falls = FALLS | ends | {"top": [[1.0, 0.0, 0.0], [-1.0, 0.0, -2.0]]}
    start = {"initial": {"length": 1.0}}
    scene = load_scene(scene_document("pendulum") | start | {"payload": body, "falls": falls})
    q = np.array(scene.initial_q)
    qdd = acceleration(scene, q, 0.0 * q, np.zeros(2))
    assert np.abs(qdd[3:]).max() < 1e-6  # m/s² or 1/s²: a place is rounded to 1e-10 m
