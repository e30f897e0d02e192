"""Overhead cranes on a moving base."""

from typing import Any

import numpy as np

SHIP = {
    "surge": {"amplitude": 0.3, "frequency": 1.1, "phase": 0.4},
    "sway": {"amplitude": 0.4, "frequency": 1.3},
    "heave": {"amplitude": 0.5, "frequency": 0.9, "phase": 1.0},
    "roll": {"amplitude": 0.3, "frequency": 1.2, "phase": 0.2},
    "pitch": {"amplitude": 0.2, "frequency": 1.7, "phase": 0.7},
    "yaw": {"amplitude": 0.4, "frequency": 0.8, "phase": 0.3},
}


MASSES, LENGTHS = [2.0, 1.0, 4.0], [1.0, 0.7, 0.9]


DIRECTIONS = np.array([[0.6, 0.0, -0.8], [0.0, 0.6, -0.8], [0.48, -0.36, -0.8]])


RATES = np.array([[0.0, 0.5, 0.0], [0.3, 0.0, 0.0], [0.3, 0.4, 0.0]])


def start_of(lengths: Any, units: Any, rates: Any) -> tuple[Any, Any]:
    """Return positions and velocities (N + 1, 3) of trolley, at rest in the origin, and nodes."""
    links, relative = (np.array(lengths)[:, None] * np.array(part) for part in (units, rates))
    return np.cumsum(np.vstack([np.zeros(3), links]), axis=0), np.cumsum(
        np.vstack([np.zeros(3), relative]), axis=0
    )


PLANE = {name: SHIP[name] for name in ("surge", "heave", "pitch")}
