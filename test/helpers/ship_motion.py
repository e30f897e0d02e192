"""A base motion like that of a ship."""

SHIP = {
    "surge": {"amplitude": 0.3, "frequency": 0.9, "phase": 0.4},
    "sway": {"amplitude": 0.2, "frequency": 1.3},
    "heave": {"amplitude": 0.4, "frequency": 1.1, "phase": 1.0},
    "roll": {"amplitude": 0.3, "frequency": 1.7, "offset": 0.1},
    "pitch": {"amplitude": 0.25, "frequency": 1.2, "phase": 2.0},
    "yaw": {"amplitude": 0.6, "frequency": 0.7},
}
