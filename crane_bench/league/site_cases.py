"""The league's cranes of ports and sites: hook and sling below bridge, tower and mobile crane, loads on falls.

Each is brought to a target in two ways: by force, where a law commands efforts, and by speed, where it commands drives
that follow speeds, as frequency converters do.
"""

from typing import Any

from crane_bench.league.trials import (
    LONGER_ROPE,
    OF_LENGTH,
    OF_MASS,
    SHORTER_ROPE,
    Entrant,
    FromScene,
    Group,
    Trial,
    set_point_trials,
    wind,
)

POINT_MASS = {"inertia": None, "attachment": None}
"""What a law that knows one rope and a point mass believes of a rigid payload."""
BODY = ("payload.mass", "payload.inertia")
"""Keys that another mass of the payload scales: its density changes."""
LQR = Entrant("lqr", "lqr")
WHOLE = {"control.nominal": {}}
"""The law believes in hook, sling and body."""


def speed_laws(drives: dict[str, Any], path: dict[str, Any], swing_feedback: bool) -> tuple[Entrant, ...]:
    """Return the entrants that command drives by speed.

    Args:
        drives: the drives, by dotted key of the scene.
        path: of the actuated joints from start to target, within the limits of the drives.
        swing_feedback: whether the payload swings by angles, which the law with feedback of the swing needs; it
            believes in the scene's point mass on a rope, the others know hook and sling.
    """
    path = path | {"of": "joints", "kind": "point_to_point"}
    shaped = path | {"shaping": {"kind": "zv"}}
    return (
        Entrant("speeds", "joint_trajectory", nominal={"reference.path": path}, changes=drives | WHOLE),
        Entrant("speeds, ZV", "joint_trajectory", nominal={"reference.path": shaped}, changes=drives | WHOLE),
        *((Entrant("anti-swing", "anti_swing", changes=drives),) if swing_feedback else ()),
    )


def speed_drive(gain: float, speed: float, acceleration: float) -> dict[str, Any]:
    """Return a drive that follows speeds.

    Args:
        gain: effort for a deviation of the speed, in the joint's units.
        speed: largest one, in the joint's unit/s.
        acceleration: largest one, in the joint's unit/s².
    """
    servo = {"gain": gain, "integral_time": 0.2, "max_speed": speed, "max_acceleration": acceleration}
    return {"drive": "velocity", "servo": servo | {"max_jerk": 5.0 * acceleration}}


def sling_trials(scene: str, known: dict[str, Any], still: dict[str, Any], gust: Trial) -> tuple[Trial, ...]:
    """Return the trials of a crane with hook and sling; arguments of `set_point_trials`, and the trial in a gust."""
    return (
        *set_point_trials(scene, known, still, {}, BODY),
        gust,
        Trial("rope -5 %", scene, known, still, {"links.0.length": SHORTER_ROPE}),
        Trial("rope +5 %", scene, known, still, {"links.0.length": LONGER_ROPE}),
    )


BRIDGE = {
    "inputs": None,
    "duration": 50.0,
    "initial": {"q": [-4.0, 0.0, 4.0, 0, 0]},
    "reference": {"q": [4.0, 6.0, 5.0]},
    "payload.attachment": [0.0, 0.0, 0.6],
    "actuators": {"trolley": {"limit": 5e3}, "bridge": {"limit": 12e3}, "rope": {"limit": 0.3}},
    "control": {
        "law": "lqr",
        "period": 0.02,
        "q": [1, 1, 4, 100, 100, 4, 4, 4, 400, 400],  # 1 / (1 m, 1 m, 0.5 m, 0.1 rad, ...)²
        "r": [1e-6, 1.6e-7, 11],  # 1 / (1 kN, 2.5 kN, 0.3 m/s)²
        "nominal": {"links": [], "payload": {"mass": 8120.0, **POINT_MASS}},
    },
}
"""The workshop crane of 10 t: a load that starts at rest goes across and along the hall and a metre lower."""
OF_BRIDGE = (
    LQR,
    *speed_laws(
        {
            "actuators.trolley": speed_drive(2.4e4, 0.4, 0.16) | {"limit": 5e3},
            "actuators.bridge": speed_drive(2.24e5, 0.63, 0.19) | {"limit": 12e3},
        },
        {"from": [-4.0, 0.0, 4.0], "to": [4.0, 6.0, 5.0], "velocity": [0.38, 0.6, 0.2], "acceleration": 0.15},
        swing_feedback=True,
    ),
)
OF_TOWER = (
    LQR,
    *speed_laws(
        {
            "actuators.slew": speed_drive(1.7e8, 0.08, 0.008) | {"limit": 240e3},
            "actuators.trolley": speed_drive(1e4, 1.0, 0.25) | {"limit": 8e3},
        },
        {
            "from": [0.0, 25.0, 25.0],
            "to": ["45 deg", 40.0, 20.0],
            "velocity": [0.07, 0.9, 0.4],
            "acceleration": [0.006, 0.2, 0.2],
        },
        swing_feedback=True,
    ),
)
OF_MOBILE = (
    LQR,
    *speed_laws(
        {
            "actuators.slew": speed_drive(3e7, 0.1, 0.015) | {"limit": 1e5},
            "actuators.boom": speed_drive(1e8, 0.02, 0.01),
            "actuators.telescope": speed_drive(1e5, 0.2, 0.1),
        },
        {
            "from": [0.0, "65 deg", 36.0, 22.0],
            "to": ["20 deg", "65 deg", 36.0, 18.0],
            "velocity": [0.09, 0.02, 0.2, 0.45],
            "acceleration": [0.012, 0.01, 0.1, 0.2],
        },
        swing_feedback=True,
    ),
)
CONTAINER = {
    "inputs": None,
    "reference": {"q": [30.0, 0.0, 32.0]},
    "actuators": {"trolley": {"limit": 60e3}, "bridge": {"limit": 200e3}, "hoist": {"limit": 0.8}},
    "control": {
        "law": "lqr",
        "period": 0.02,
        "q": 2 * [1, 1, 1, 1, 1, 1, 100, 100, 100, 100],  # 1 / (1 m, ..., of the attitude 0.1)²
        "r": [2.5e-9, 1e-10, 4],  # 1 / (20 kN, 100 kN, 0.5 m/s)²
    },
}
"""A ship-to-shore crane moves a container by 30 m and lowers it by 6 m."""
OF_CONTAINER = (
    LQR,
    *speed_laws(
        {
            "actuators.trolley": speed_drive(8e5, 4.0, 0.6) | {"limit": 60e3},
            "actuators.bridge": speed_drive(1.4e7, 0.5, 0.1) | {"limit": 200e3},
        },
        {
            "from": [0.0, 0.0, 26.0],
            "to": [30.0, 0.0, 32.0],
            "velocity": [3.0, 0.5, 0.7],
            "acceleration": [0.4, 0.1, 0.4],
        },
        swing_feedback=False,
    ),
)
ON_SHIP = {
    "inputs": None,
    "contact": None,
    "base_motion": None,
    "actuators": {"slew": {"limit": 6e4}, "boom": {"limit": 4e5}, "jib": {"limit": 4e5}, "hoist": {"limit": 0.5}},
    "reference": {"q": ["50 deg", "60 deg", "-15 deg", 3.0]},
    "control": {
        "law": "lqr",
        "period": 0.02,
        "q": 2 * [25, 25, 25, 4, 4, 4, 4, 0.01, 0.01, 0.01, 0.01],  # 1 / (0.2 rad, ..., 0.5 m, ..., 10)²
        "r": [2.5e-9, 1e-8, 1e-8, 11],  # 1 / (20 kN m, 10 kN m, 10 kN m, 0.3 m/s)²
    },
}
"""The crane of a research vessel slews its frame by 30 degrees and lowers it; above the deck there is no contact."""
STILL_SHIP = wind(0.0) | {"base_motion": {"sway": {"amplitude": 0.0, "frequency": 0.0}}}
SHIP_SEA = {"base_motion": FromScene("knuckle_sea")}
OF_SHIP = (
    LQR,
    *speed_laws(
        {"actuators": FromScene("knuckle_ship_falls")},
        {
            "from": ["80 deg", "55 deg", "-10 deg", 1.2],
            "to": ["50 deg", "60 deg", "-15 deg", 3.0],
            "velocity": [0.1, 0.04, 0.04, 0.3],
            "acceleration": [0.04, 0.04, 0.04, 0.2],
        },
        swing_feedback=False,
    ),
)
TOWER = {"wind": None, "payload.windage": None}
"""The scene without its wind, which is the trial's."""
TOWER_WIND = Trial("gust", "tower_gust", TOWER, dict.fromkeys(TOWER, FromScene("tower_gust")), seeded="wind.gusts.seed")
BODY_AND_SLING = {**dict.fromkeys(BODY, OF_MASS), "links.0.length": OF_LENGTH}
"""What samples vary of a crane with hook and sling."""
SITE_GROUPS = (
    Group(
        "bridge crane, hook and sling",
        "target",
        OF_BRIDGE,
        sling_trials(
            "bridge_hook_and_sling", BRIDGE, wind(0.0), Trial("gust", "bridge_hook_and_sling", BRIDGE, wind(4e3))
        ),
        BODY_AND_SLING,
    ),
    Group(
        "tower crane, hook and sling",
        "target",
        OF_TOWER,
        sling_trials("tower_gust", TOWER, {}, TOWER_WIND),
        BODY_AND_SLING,
    ),
    Group(
        "mobile crane, hook and sling",
        "target",
        OF_MOBILE,
        sling_trials("mobile_lift", {}, wind(0.0), Trial("gust", "mobile_lift", {}, wind(4e3))),
        BODY_AND_SLING,
    ),
    Group(
        "ship-to-shore crane, container on falls",
        "target",
        OF_CONTAINER,
        tuple(set_point_trials("port_sts_container", CONTAINER, wind(0.0), {"gust": wind(20e3)}, BODY)),
        dict.fromkeys(BODY, OF_MASS),
    ),
    Group(
        "ship's knuckle boom, frame on falls",
        "target",
        OF_SHIP,
        tuple(
            set_point_trials(
                "knuckle_ship_falls", ON_SHIP, STILL_SHIP, {"irregular sea": SHIP_SEA, "gust": wind(1e3)}, BODY
            )
        ),
        dict.fromkeys(BODY, OF_MASS),
    ),
)
