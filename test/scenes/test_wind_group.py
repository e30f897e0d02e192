"""The group `wind`: settings in contradiction, the chosen model, payloads that change."""

from typing import Any

import pytest

import crane_sim
from crane_sim.scenes.scene import load_scene

WINDAGE = {"area": 0.5, "drag_coefficient": 1.2}
GUSTS = {"spectrum": "dryden", "intensity": 0.2}
IN_WIND = {"payload": {"mass": 10.0, "windage": WINDAGE}, "wind": {"speed": 8.0}}
PENDULUM = {"crane": "pendulum", "duration": 1.0, "rope": {"length": 1.0}}
OVERHEAD = {
    "crane": "overhead",
    "duration": 1.0,
    "trolley": {"drive": "force", "mass": 5.0},
    "cable": {"lengths": [1.0], "node_masses": [1.0]},
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"wind": None}, "payload.windage: is for wind, and there is none"),
        ({"payload.windage": None}, "wind: presses on nothing; give one of payload.windage"),
        (
            {"payload_drag": {"coefficient": 1.0}},
            "payload_drag: is drag of still air, and there is a wind",
        ),
        ({"wind.speed": -1.0}, "wind.speed = -1.0: must be greater than or equal to 0"),
        ({"wind.height": -10.0}, "wind.height = -10.0: must be greater than 0"),
        (
            {"wind.origin_height": -1.0},
            "wind.origin_height = -1.0: must be greater than or equal to 0",
        ),
        (
            {"payload.windage.area": -1.0},
            "payload.windage.area = -1.0: must be greater than or equal to 0",
        ),
        (
            {"wind.profile": {"law": "powr"}},
            "wind.profile: law 'powr' is unknown; possible: power, logarithmic",
        ),
        (
            {"wind.profile": {"law": "logarithmic", "roughness": 2.0}},
            "lowest = 1: must be greater than roughness = 2",
        ),
        (
            {
                "wind.profile": {"law": "logarithmic", "roughness": 20.0, "lowest": 30.0},
                "wind.origin_height": 9.0,
            },
            "wind.profile.roughness = 20: must be less than height = 10",
        ),
        (
            {"wind.profile": {"law": "power", "exponent": 0.2}, "wind.origin_height": 0.9},
            "wind.origin_height = 0.9: the payload starts 1 m below the origin, in the ground, "
            "where wind.profile",
        ),
        (
            {
                "wind.profile": {"law": "power", "exponent": 0.2, "lowest": 20.0},
                "wind.origin_height": 9.0,
            },
            "wind.height = 10: must not be less than wind.profile.lowest = 20",
        ),
        ({"wind.gusts": {"spectrum": "dryden"}}, "wind.gusts: take either intensity or deviations"),
        (
            {"wind.gusts": GUSTS | {"deviations": [1, 1, 1]}},
            "wind.gusts: take either intensity or deviations",
        ),
        (
            {"wind": {"speed": 0.0, "gusts": {"spectrum": "kaimal", "deviations": [1, 1, 1]}}},
            "wind.gusts: a mean of 0.01 m/s or more carries them, here wind.speed = 0",
        ),
        (
            {"wind.height": 2.0, "wind.gusts": GUSTS},
            "wind.height = 2: the scales of dryden are known from 3.048",
        ),
        (
            {"wind": {"speed": 1e-300, "gusts": GUSTS}},
            "wind.gusts: a mean of 0.01 m/s or more carries them",
        ),
        ({"wind.gusts": GUSTS | {"cut_off": 1e-6}}, "wind.gusts.cut_off = 1e-06: must be"),
        ({"wind.gusts": GUSTS | {"cut_off": 1e9}}, "wind.gusts.cut_off = 1e+09: must be"),
        (
            {"wind.gusts": GUSTS | {"lengths": [1.0, 1.0]}},
            "wind.gusts.lengths: has 2 values, too few",
        ),
    ],
    ids=lambda case: str(case)[:50],
)
def test_a_bad_wind_is_a_single_line_error(changes: Any, message: str) -> None:
    """What contradicts itself or cannot be is refused in one line with its keys and values."""
    with pytest.raises(crane_sim.SceneError) as caught:
        load_scene(
            PENDULUM
            | {"payload": {"mass": 10.0, "windage": dict(WINDAGE)}, "wind": {"speed": 8.0}},
            changes,
        )
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_closed_form_gives_way_to_the_model_that_feels_wind() -> None:
    """Cranes with a closed form in still air are chains or elastic cables in wind.

    `straight` is refused.
    """
    two = {"cable": {"lengths": [1.0, 1.0], "node_masses": [1.0, 10.0]}}
    spring = {
        "cable": {"model": "elastic", "lengths": [1.0], "node_masses": [10.0], "stiffness": 1e3}
    }
    heavy = {"cable": {"model": "auto", "lengths": [1.0, 1.0], "node_masses": [1e-3, 10.0]}}
    for changes, still, windy in (
        ({}, "RodCrane", "PlanarCrane"),
        (two, "DoubleCrane", "PlanarCrane"),
        (spring, "SpringCrane", "ElasticCrane"),
        (heavy, "RodCrane", "PlanarCrane"),
    ):
        assert type(load_scene(OVERHEAD | changes).model).__name__ == still
        assert type(load_scene(OVERHEAD | changes | IN_WIND).model).__name__ == windy
    with pytest.raises(crane_sim.SceneError, match=r"'straight': takes neither .* nor wind"):
        load_scene(OVERHEAD | heavy | IN_WIND, {"cable.model": "straight"})


@pytest.mark.parametrize(
    ("document", "below"),
    [
        (OVERHEAD | {"initial": {"angles": ["60 deg"]}}, 0.5),
        (OVERHEAD | {"dimensions": 3, "initial": {"directions": [[0.6, 0.0, -0.8]]}}, 0.8),
        (
            OVERHEAD
            | {
                "cable": {
                    "model": "elastic",
                    "lengths": [1.0],
                    "node_masses": [1.0],
                    "stiffness": 1e3,
                },
                "initial": {"positions": [[0.0, -0.7]]},
            },
            0.7,
        ),
        (PENDULUM | {"initial": {"tip": [0.0, 0.0, 0.5], "direction": [0.6, 0.0, -0.8]}}, 0.3),
        (
            {
                "crane": "knuckle",
                "duration": 1.0,
                "boom": {"length": 1.0, "mass": 1.0, "inertia": 1.0},
                "jib": {"length": 2.0, "mass": 1.0, "inertia": 1.0},
                "tower": {"inertia": 1.0},
                "initial": {"q": [0.0, "30 deg", 0.0, 2.0, "60 deg", 0.0]},
            },
            0.5,
        ),
    ],
    ids=["plane", "space", "elastic", "pendulum", "knuckle"],
)
def test_a_payload_in_the_ground_is_refused(document: dict[str, Any], below: float) -> None:
    """The payload's initial height is that of each crane's geometry: 1 mm above ground is valid."""
    wind = {"wind.profile": {"law": "power", "exponent": 0.2}}
    load_scene(document | IN_WIND, wind | {"wind.origin_height": below + 1e-3})
    with pytest.raises(
        crane_sim.SceneError,
        match=f"the payload starts {below:g} m below the origin, in the ground",
    ):
        load_scene(document | IN_WIND, wind | {"wind.origin_height": below - 1e-3})


def test_events_change_the_mass_alone() -> None:
    """A payload that changes keeps its windage: the event has a mass and no other key."""
    event = {"at": 0.5, "set": {"payload": {"mass": 3.0, "windage": WINDAGE}}}
    with pytest.raises(
        crane_sim.SceneError, match=r"events\[0\].set.payload: unknown key 'windage'"
    ):
        load_scene(OVERHEAD | IN_WIND | {"events": [event]})
