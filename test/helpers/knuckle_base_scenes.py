"""The document of a scene: a knuckle crane on a moving base."""

from typing import Any

from ship_motion import SHIP

CRANE: dict[str, Any] = {
    "crane": "knuckle",
    "duration": 4.0,
    "boom": {"length": 5.0, "mass": 8.0, "inertia": 16.0},
    "jib": {"length": 3.0, "mass": 4.0, "inertia": 3.0},
    "tower": {"inertia": 5.0},
    "payload": {"mass": 1.5},
    "initial": {"q": [0.2, 0.7, -0.3, 2.0, 0.1, -0.2]},
    "base_motion": SHIP,
}
