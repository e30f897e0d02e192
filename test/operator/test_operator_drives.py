"""Scenes for an operator: every drive follows a speed, and nothing else of the scene changes."""

from math import inf, nan
from typing import Any

import pytest
import yaml

from crane_sim import load_scene
from crane_sim.files.errors import SceneError
from crane_sim.operator.drives import (
    BANDWIDTH,
    DURATION,
    JERK_TIME,
    SOFT_LIMIT_MARGIN,
    driven_joints,
    with_operator_drives,
)
from crane_sim.simulation.plant import Plant


def actuators_of(
    name: str, overrides: dict[str, Any] | None = None, **options: Any
) -> dict[str, Any]:
    """Return the drives of a scene for an operator."""
    return with_operator_drives(load_scene(name, overrides), **options).to_dict()["actuators"]


@pytest.mark.parametrize("name", ["tower_gust", "overhead_spatial"])
def test_a_scene_loses_its_law_and_keeps_its_crane(name: str) -> None:
    """Law, inputs and reference are left out, the run is long; all but the drives is unchanged."""
    scene = load_scene(name)
    before, after = scene.to_dict(), with_operator_drives(scene).to_dict()
    assert after.pop("duration") == DURATION
    dropped = {"control", "inputs", "reference", "duration", "actuators"}
    assert {key: value for key, value in before.items() if key not in dropped} == {
        key: value for key, value in after.items() if key != "actuators"
    }
    assert with_operator_drives(scene, duration=5.0).duration == 5.0


def test_drives_by_force_follow_speeds() -> None:
    """A force drive gets a loop with both poles at the bandwidth on its inertia.

    It keeps its limit.
    """
    trolley = actuators_of("tower_gust")["trolley"]
    # trolley, hook block and machine: the rope's direction is locked
    mass, omega = 5000.0, BANDWIDTH
    servo = trolley["servo"]
    assert trolley["drive"] == "velocity" and trolley["limit"] == 8.0e3
    assert servo["gain"] == pytest.approx(2.0 * omega * mass, rel=1e-6)
    assert servo["gain"] / servo["integral_time"] == pytest.approx(omega**2 * mass, rel=1e-6)
    assert servo["max_jerk"] == pytest.approx(servo["max_acceleration"] / JERK_TIME)


def test_weak_drives_get_slow_ramps() -> None:
    """A ramp takes at most half of what the drive has left beside the static load."""
    slew = actuators_of("tower_gust")["slew"]
    inertia = slew["servo"]["gain"] / (2.0 * BANDWIDTH)
    assert slew["servo"]["max_acceleration"] == pytest.approx(0.5 * 240.0e3 / inertia, rel=1e-6)


@pytest.mark.parametrize("name", ["tower_gust", "mobile_lift", "knuckle_setpoint"])
def test_a_driven_scene_is_a_file(name: str) -> None:
    """It goes to the nodes as YAML, which has plain numbers only, and reads as the same scene."""
    document = with_operator_drives(load_scene(name)).to_dict()
    assert yaml.safe_load(yaml.safe_dump(document)) == document


def test_what_the_scene_says_of_a_drive_stays() -> None:
    """A speed drive keeps its settings, a winch of imposed motion its limit.

    The operator's speed precedes them.
    """
    own = load_scene("bridge_speed_drive").to_dict()["actuators"]
    drives = actuators_of("bridge_speed_drive")
    assert {joint: drives[joint] for joint in own} == own
    assert actuators_of("tower_gust")["rope"]["limit"] == 0.42
    faster = actuators_of("bridge_speed_drive", speeds={"trolley": 0.7, "rope": 0.1})
    assert (
        faster["trolley"]["servo"] == own["trolley"]["servo"] | {"max_speed": 0.7}
        and faster["rope"]["limit"] == 0.1
    )


def test_keys_of_drives_by_effort_are_left_out() -> None:
    """Lag, rate limit and dead band of an effort do not pass over to a drive by speed.

    Those for all joints do not either.
    """
    changes = {"actuators.all": {"lag": 0.1, "rate_limit": 1e5}, "actuators.slew.deadband": 10.0}
    drives = actuators_of("knuckle_setpoint", changes)
    assert all(not {"lag", "rate_limit", "deadband"} & drive.keys() for drive in drives.values())
    position = {
        "drive": "position",
        "servo": {"gain": 50.0, "position_gain": 1.0, "max_speed": 0.2},
    }
    slew = actuators_of("knuckle_setpoint", {"actuators": {"slew": position}, "control": None})[
        "slew"
    ]
    assert (
        slew["drive"] == "velocity"
        and "position_gain" not in slew["servo"]
        and slew["servo"]["gain"] == 50.0
    )


def test_soft_limits_stand_inside_the_travel() -> None:
    """Soft limits are a part of the travel inside limits and switches; so is the shortest rope."""
    changes = {"actuators.trolley.limit_switches": [-8.0, 8.5]}
    trolley, bridge, rope = driven_joints(
        with_operator_drives(load_scene("bridge_speed_drive", changes))
    )
    margin = SOFT_LIMIT_MARGIN * 16.5
    assert (trolley.low, trolley.high) == pytest.approx((-8.0 + margin, 8.5 - margin))
    assert (bridge.low, bridge.high) == (-inf, inf) and rope.lag == 0.2
    *_, free = driven_joints(with_operator_drives(load_scene("knuckle_setpoint")))
    assert (free.name, free.low, free.high) == ("rope", pytest.approx(0.2), inf)


@pytest.mark.parametrize(
    ("name", "speeds", "line"),
    [
        ("overhead_sway", {}, "scene overhead_sway: has no actuated joint"),
        ("offshore_vision", {}, "scene offshore_vision: the tip_x takes positions"),
        ("tower_gust", {"slw": 1.0}, "--speed slw: unknown joint 'slw', did you mean 'slew'?"),
        ("tower_gust", {"slew": -1.0}, "--speed slew=-1: must be a number greater than 0"),
        ("tower_gust", {"slew": nan}, "--speed slew=nan: must be a number greater than 0"),
    ],
)
def test_scenes_that_no_operator_has(name: str, speeds: dict[str, float], line: str) -> None:
    """What cannot be driven is refused in one line."""
    with pytest.raises(SceneError) as error:
        with_operator_drives(load_scene(name), speeds=speeds)
    assert str(error.value).startswith(line) and "\n" not in str(error.value)


def test_a_crane_without_commands_stands() -> None:
    """A knuckle boom with speed drives stands under gravity where it is with all speeds zero."""
    scene = with_operator_drives(load_scene("knuckle_setpoint"), duration=1.0)
    plant = Plant(scene.with_external_commands())
    for _ in range(50):
        plant.advance((0.0,) * 4)
    moved = [abs(a - b) for a, b in zip(plant.q, scene.initial_q, strict=True)]
    assert max(moved[:4]) < 1e-6  # the loop's integral begins with the static load


def test_lags_are_those_of_drive_and_winch() -> None:
    """The lag behind a command is the drive's delay and lag, and a speed winch's time constant."""
    changes = {"actuators.rope.lag": 1.0, "actuators.rope.delay": 0.5}
    scene = with_operator_drives(load_scene("bridge_hook_and_sling", changes))
    plain = with_operator_drives(load_scene("bridge_hook_and_sling"))
    lags = [
        {joint.name: joint.lag for joint in driven_joints(each)}["rope"] for each in (scene, plain)
    ]
    assert lags[0] - lags[1] == pytest.approx(1.5)
