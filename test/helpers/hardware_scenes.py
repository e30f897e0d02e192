"""A small crane with hardware for tests of sensors, actuators and faults: compiled once."""

from math import cos
from typing import Any

import numpy as np

from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.plant import Plant

PERIOD = 0.01  # s, of a scene without a law
# kg; without a time it begins when it is set
MASS: dict[str, Any] = {"kind": "payload", "mass": 2.0}
ROD: dict[str, Any] = {
    "crane": "overhead",
    "duration": 2.0,
    "trolley": {"mass": 10.0},
    "cable": {"lengths": 2.0, "node_masses": 5.0},
    "initial": {"angles": 0.3, "v": 0.5},
    "integrator": {"method": "rk4", "step": 0.005},
}
"""A trolley with a payload: joints trolley and swing_1."""


def rod(**groups: Any) -> Scene:
    """Return the scene with further groups, and a fault that changes its payload when it is set."""
    return load_scene(ROD | groups | {"faults": {"never": MASS} | groups.get("faults", {})})


def history(
    scene: Scene, periods: int, demand: Any = lambda t: 5.0 * cos(3.0 * t)
) -> tuple[Any, Any, Any]:
    """Return (true, measured, applied) of every period.

    True and measured coordinates are (K, 4), efforts (K,).
    """
    plant, true, measured, applied = Plant(scene), [], [], []
    for _ in range(periods):
        true.append((*plant.q, *plant.v))
        measured.append((*plant.seen[0], *plant.seen[1]))
        plant.advance((demand(plant.t),))
        applied.append(plant.applied[0])
    return np.array(true), np.array(measured), np.array(applied)
