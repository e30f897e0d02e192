"""A group whose strength is zero has no effect: the crane accelerates as the one without it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from crane_sim import system
from crane_sim.scenes.scene import Scene, load_scene

DRY = {"coulomb": 0.0, "static": 0.0, "stribeck": 0.01}
STILL = {
    "heave": {"amplitude": 0.0, "frequency": 0.7},
    "roll": {"amplitude": 0.0, "frequency": 0.5},
}
CALM = {"speed": 0.0, "height": 40.0, "origin_height": 50.0}
CALM_GUSTS = {"spectrum": "kaimal", "intensity": 0.0}
STEADY = {"speed": 9.0, "height": 40.0, "origin_height": 50.0}
SWING = {"tangential": 0.0, "radial": 0.0}
LOSSLESS = {"falls": 1}
NOTHING = {"payload_force": {"x": {"kind": "constant", "value": 0.0}}}
SPRINGLESS = {"boom": {"stiffness": 0.0, "rest": 0.8}, "jib": {"stiffness": 0.0, "rest": 0.1}}
CORNERS = [[1.2, 2.8, -2.0], [-1.2, -2.8, -2.0]]
NO_LAW = {"control": None, "reference": None, "actuators": {}}
WINDAGE = {"area": 8.0, "drag_coefficient": 1.3}
WINDY = {"wind": STEADY, "payload.windage": WINDAGE}
CASES: tuple[
    tuple[str, Mapping[str, Any], Mapping[str, Any]], ...
] = (  # (scene, changes, the group)
    ("bridge_hook_and_sling", {}, {"friction": {"bridge": DRY, "trolley": DRY}}),
    (
        "bridge_hook_and_sling",
        {},
        {"actuators": {"bridge": {"motor": {"ratio": 50.0, "inertia": 0.0}}}},
    ),
    ("bridge_hook_and_sling", {}, {"base_motion": STILL}),
    ("bridge_hook_and_sling", {"rope.torsion": {"stiffness": 60.0}}, {"rope.torsion.damping": 0.0}),
    ("bridge_hook_and_sling", {"rope.slack": "stop"}, {"rope.reeving": LOSSLESS}),
    ("bridge_hook_and_sling", {}, NOTHING),
    (
        "tower_gust",
        NO_LAW | {"wind": None, "payload.windage": None},
        {"wind": CALM, "payload.windage": WINDAGE},
    ),
    ("tower_gust", NO_LAW | {"wind": STEADY}, {"wind.gusts": CALM_GUSTS}),
    (
        "tower_gust",
        NO_LAW | WINDY,
        {"slew.jib_windage": {"area": 0.0, "drag_coefficient": 1.6, "centre": 30.0}},
    ),
    ("tower_flexible_jib", NO_LAW, {"flexibility.lateral.damping_ratio": 0.0}),
    ("tower_sway", {"actuators": {}, "inputs": None}, {"friction": {"slew": DRY, "trolley": DRY}}),
    ("mobile_lift", NO_LAW, {"base_motion": STILL}),
    ("mobile_lift", NO_LAW, {"friction": {"boom": DRY, "slew": DRY}}),
    ("spreader_skew", {}, {"friction": {"trolley": DRY}}),
    ("spreader_skew", {}, {"base_motion": STILL}),
    (
        "spreader_skew",
        {},
        {"contact": {"kind": "compliant", "points": CORNERS, "height": -60.0, "stiffness": 0.0}},
    ),
    ("spreader_skew", {"falls.relaxation": None}, {"falls.relaxation": 0.0}),
    ("spreader_skew", {"falls.offsets": None}, {"falls.offsets": [0.0, 0.0, 0.0, 0.0]}),
    ("spreader_skew", {}, {"hoist.reeving": {"falls": 2}}),
    ("spreader_skew", {"hoist": {"drive": "force", "mass": 1e5}}, {"hoist.friction": DRY}),
    ("knuckle_hook_and_sling", NO_LAW, {"friction": {"boom": DRY}}),
    ("knuckle_hook_and_sling", NO_LAW, {"base_motion": STILL}),
    ("knuckle_setpoint", NO_LAW, {"swing_friction": SWING | {"model": "linear"}}),
    ("knuckle_setpoint", NO_LAW, {"swing_friction": SWING | {"model": "quadratic"}}),
    ("knuckle_setpoint", NO_LAW, {"payload_drag": {"coefficient": 0.0}}),
    ("knuckle_setpoint", NO_LAW, {"springs": SPRINGLESS}),
    ("pendulum_sea", {"wind": STEADY, "payload.windage": WINDAGE}, {"wind.gusts": CALM_GUSTS}),
    ("overhead_chain", {}, {"joints": {"stiffness": 0.0, "damping": 0.0}}),
    ("overhead_chain", {}, {"cable.inertia": 0.0}),
    ("overhead_chain", {}, {"base_motion": STILL}),
    ("overhead_spring", {}, {"cable.damping": 0.0}),
    ("overhead_swing", {}, {"friction": {"trolley": DRY}}),
)
SCATTER = 0.05  # m/s or rad/s, of the rates


def accelerate(scene: Scene) -> Any:
    """Return accelerations of a scene's crane in motion, for the same rates and efforts always."""
    rng, ends = np.random.default_rng(15), len(scene.actuated)
    v = np.array(scene.initial_v)
    v[:ends] += rng.uniform(-SCATTER, SCATTER, ends)
    x = system.state(scene.model, 0.3, np.array(scene.initial_q), v)
    return np.array(
        system.acceleration(scene.model, 0.3, x, tuple(rng.uniform(-1e3, 1e3, ends).tolist()))
    )


@pytest.mark.parametrize(
    ("name", "changes", "group"),
    CASES,
    ids=[f"{name}: {', '.join(group)}" for name, _, group in CASES],
)
def test_zero_strength_is_absence(
    name: str, changes: Mapping[str, Any], group: Mapping[str, Any]
) -> None:
    """Accelerations with the group are those without it, within 1e-12 of the largest.

    Not to the bit, as some add zeros elsewhere.
    """
    without, with_group = load_scene(name, changes), load_scene(name, {**changes, **group})
    expected = accelerate(without)
    assert abs(expected).max() > 1e-3  # m/s² or rad/s²
    np.testing.assert_allclose(
        accelerate(with_group), expected, rtol=0.0, atol=1e-12 * abs(expected).max()
    )
