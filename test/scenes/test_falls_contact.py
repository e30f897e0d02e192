"""Contact of a load on falls below every support, with wind, exchange and a moving base at once."""

from typing import Any

import numpy as np
import pytest
from test_falls_schemas import LOAD, SHIP_MOTION, scene_document

import crane_sim
from crane_sim import load_scene

pytestmark = pytest.mark.long

CORNERS = [[x, y, -0.9] for x in (0.4, -0.4) for y in (0.5, -0.5)]
RUBBING = {"friction": 0.5, "slip_velocity": 0.1}  # a slower one has the run take many more steps
BELOW = 0.4  # m, of the corners below the load's centre
WINDAGE = {"area": 2.0, "drag_coefficient": 1.2, "centre": [0.1, 0.0, 0.1]}
WIND = {"speed": 10.0, "height": 10.0, "origin_height": 10.0}
HEAVIER = {
    "mass": 150.0,
    "inertia": [60.0, 45.0, 75.0],
    "attachment": [0.05, 0.02, 0.6],
    "windage": WINDAGE,
}
STUCK = {"coulomb": 2e5, "static": 2e5}
HELD = {
    "tower": ("slew",),
    "mobile": ("slew", "boom", "telescope"),
    "knuckle": ("boom", "jib"),
    "pendulum": (),
}
DRAGGED = {"tower": "trolley", "mobile": None, "knuckle": "slew", "pendulum": "tip_x"}
KINDS: dict[str, Any] = {
    "rigid": {},
    "compliant": {"kind": "compliant", "stiffness": 2e4, "damping": 0.5},
}


def table(*points: tuple[float, float]) -> dict[str, Any]:
    """Return an input that is linear between (time, value)."""
    times, values = zip(*points, strict=True)
    return {"kind": "table", "times": times, "values": values}


def landing(name: str, kind: str) -> dict[str, Any]:
    """Return a load set down in wind at sea, dragged, exchanged and taken up, with friction."""
    scene = scene_document(name) | {
        "duration": 1.0,
        "payload": LOAD | {"windage": WINDAGE},
        "wind": WIND,
    }
    crane = load_scene(scene)
    centre = crane.initial_q[crane.joint_names.index("payload_z")]
    scene["contact"] = {"points": CORNERS, "height": centre - BELOW - 0.02, **RUBBING} | KINDS[kind]
    scene["events"] = [{"at": 0.5, "set": {"payload": HEAVIER, "contact": {"points": CORNERS}}}]
    scene["integrator"] = {"method": "dop853", "rtol": 1e-8, "atol": 1e-9}
    scene |= {"base_motion": SHIP_MOTION, "friction": {joint: STUCK for joint in HELD[name]}}
    pull = (
        {DRAGGED[name]: table((0.0, 0.0), (0.3, 0.0), (0.35, 500.0), (0.6, 0.0))}
        if DRAGGED[name]
        else {}
    )
    if name == "pendulum":
        del scene["friction"]
        scene["suspension"] = {"drive": "acceleration", "height": "driven"}
        lift = table(
            (0.0, 0.0), (0.05, -2.0), (0.1, 0.0), (0.55, 0.0), (0.6, 2.0), (0.8, 2.0), (0.9, 0.0)
        )
        pull = {"tip_x": table((0.3, 0.0), (0.35, 2.0), (0.4, 0.0)), "tip_z": lift}
    else:
        scene["hoist"] = {"drive": "rate", "time_constant": 0.1}
        pull["hoist"] = table(
            (0.0, 0.0), (0.1, 0.4), (0.3, 0.4), (0.4, 0.0), (0.55, 0.0), (0.6, -0.5)
        )
    return scene | {"inputs": pull}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", HELD)
def test_a_load_is_set_down_and_taken_up(name: str, kind: str) -> None:
    """On any support energy balances, falls only pull, and rigid corners stay above ground."""
    run = crane_sim.simulate(landing(name, kind))
    assert run.summary["energy_audit_max"] < 1e-9 and run.summary["negative_tension_steps"] == 0
    assert run.summary["peak_contact_force"] > 500.0  # N: half the load's weight at least
    assert run.tensions.min() == 0.0  # a fall was slack
    i = run.scene.joint_names.index("payload_z")
    w, a, b, c = run.q[:, i + 1 : i + 5].T
    row = np.stack([2.0 * (a * c - w * b), 2.0 * (b * c + w * a), 1.0 - 2.0 * (a * a + b * b)])
    heights = run.q[:, i] + (np.array(CORNERS) + LOAD["attachment"]) @ row
    deepest = float((heights - run.scene.document["contact"]["height"]).min())
    # springs give way by m g / 4 k
    assert -1e-9 < deepest < 1e-6 if kind == "rigid" else -0.1 < deepest < -0.005
