"""A trolley on a speed drive that takes goals of the trajectory action: a path of its joint."""

from typing import Any

SERVO = {
    "gain": 24e3,
    "integral_time": 0.2,
    "max_speed": 1.0,
    "max_acceleration": 0.5,
    "max_jerk": 5.0,
}
DOCUMENT: dict[str, Any] = {
    "crane": "overhead",
    "duration": 6.0,
    "trolley": {"mass": 1200.0},
    "cable": {"lengths": 4.0, "node_masses": 500.0},
    "actuators": {"trolley": {"drive": "velocity", "servo": SERVO}},
    "control": {"law": "joint_trajectory", "period": 0.01},
}
