"""Many groups at once, of drives, structure, wind, sea and ground: the energy balance holds."""

from typing import Any

import numpy as np
import pytest

import crane_sim

SEA = {
    "heave": {"amplitude": 0.3, "frequency": 1.1},
    "roll": {"amplitude": 0.04, "frequency": 0.9, "phase": 1.0},
}
WIND = {
    "speed": 9.0,
    "height": 40.0,
    "origin_height": 70.0,
    "gusts": {"spectrum": "von_karman", "intensity": 0.15},
}
WINDAGE = {"area": 8.0, "drag_coefficient": 1.3, "centre": [0.3, 0.0, 0.0]}
NO_LAW = {"control": None, "reference": None, "actuators": {}}
BODY = {
    "mass": 4e3,
    "inertia": [2.8e3, 8.9e3, 9.3e3],
    "attachment": [0.1, 0.0, 0.7],
    "windage": WINDAGE,
}
TORSION = {"stiffness": 6e3, "damping": 50.0}
RUBS = {"coulomb": 600.0, "static": 800.0, "viscous": 50.0, "stribeck": 0.01}
HOLDS = {"coulomb": 3e5, "static": 4e5, "stribeck": 0.01, "stiffness": 1e8, "damping": 1e5}
SLEWS, LUFFS = {"coulomb": 1e4, "static": 1.2e4}, {"coulomb": 1e7, "static": 1.1e7}
PLAY = [{"inertia": 2e3, "play": 2e-3, "stiffness": 1e7, "damping": 1.4e4}]
BENDS = {
    "lateral": {"stiffness": 3e8, "damping_ratio": 0.01},
    "vertical": {"stiffness": 3e8, "damping_ratio": 0.01},
}
JIB = {"mass": 1.05e4, "centre": 30.0, "inertia": 3.15e6}
MOTOR = {"motor": {"ratio": 90.0, "inertia": 2.0}}
TURNS = {"initial.rigging": {"angular_velocity": [0.05, 0.1, 0.3]}}
SHEAVES = {"radius": 0.2, "inertia": 0.5, "loss": {"kind": "efficiency", "efficiency": 0.98}}
REEVING = {
    "falls": 4,
    "lead_sheaves": 1,
    "sheaves": SHEAVES,
    "drum": {"radius": 0.2, "inertia": 60.0},
}
COMBINATIONS: dict[str, tuple[str, dict[str, Any]]] = {
    "torsion at sea, in wind, friction, play": (
        "bridge_hook_and_sling",
        TURNS
        | {"rope.torsion": TORSION, "payload.windage": WINDAGE, "wind": WIND, "base_motion": SEA}
        | {
            "friction": {"trolley": RUBS},
            "backlash": {"bridge": PLAY},
            "initial.v": [0.3, -0.2, 0.1, 0.2, -0.1],
        },
    ),
    "torsion, a jib that bends, friction, motor, play, at sea, in wind": (
        "tower_flexible_jib",
        NO_LAW
        | TURNS
        | {
            "rope.torsion": TORSION,
            "payload": BODY,
            "wind": WIND,
            "base_motion": SEA,
            "backlash": {"trolley": PLAY},
        }
        | {"friction": {"slew": SLEWS, "trolley": RUBS}, "actuators.slew": MOTOR}
        | {"initial.v": [0.02, -0.3, 0.2, 0.05, 0.1]},
    ),
    "torsion, a load taken up, a boom that bends, bristles, sheaves": (
        "mobile_lift",
        NO_LAW
        | TURNS
        | {
            "rope.torsion": TORSION,
            "rope.reeving": REEVING,
            "flexibility": BENDS,
            "lugre": {"telescope": HOLDS},
        }
        | {
            "friction": {"slew": SLEWS, "boom": LUFFS},
            "actuators.boom": MOTOR,
            "initial.v": [0.02, 0, 0, 0, 0.05, 0.1],
        },
    ),
    "falls of a knuckle boom at sea, in wind, drives by speed": (
        "knuckle_ship_falls",
        {
            "payload.windage": WINDAGE,
            "wind": WIND,
            "initial.q": ["80 deg", "55 deg", "-10 deg", 2.7],
        },
    ),
    "falls below a jib that bends, friction, springy ground, at sea, in wind": (
        "tower_set_down",
        {
            "flexibility": BENDS | {"jib": JIB},
            "payload.windage": WINDAGE,
            "wind": WIND,
            "base_motion": SEA,
        }
        | {
            "contact.kind": "compliant",
            "contact.stiffness": 1e6,
            "contact.damping": 0.3,
            "contact.height": -17.7,
        }
        | {"initial.v": [0.02, 0.3, 0.2]},
    ),
    "falls of a davit at sea, in wind": (
        "pendulum_lifeboat",
        {"payload.windage": WINDAGE, "wind": WIND},
    ),
}


LONG = "falls below a jib that bends, friction, springy ground, at sea, in wind"


@pytest.mark.long(cases=[LONG])
@pytest.mark.parametrize("name", COMBINATIONS)
def test_energy_is_kept_by_many_groups_at_once(name: str) -> None:
    """The balance of energy closes to 1e-9 of the largest energy, in numbers."""
    scene, changes = COMBINATIONS[name]
    exact = {"method": "dop853", "rtol": 1e-10, "atol": 1e-11}
    run = crane_sim.simulate(scene, overrides=changes | {"duration": 0.1, "integrator": exact})
    assert (
        np.isfinite(run.q).all()
        and np.isfinite(run.tensions).all()
        and np.ptp(run.q, axis=0).max() > 1e-4
    )
    assert run.summary["energy_audit_max"] < 1e-9
