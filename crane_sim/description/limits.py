"""The limits of a URDF's joints: those of the scene, and a number larger than any value where it has none."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree

from crane_sim.description.robot import UNBOUNDED, add_limit

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

NONNEGATIVE_JOINTS = ("rope", "hoist")  # joints that are never below zero


class Limit(NamedTuple):
    """Limits of a joint; infinite where the scene has none."""

    lower: float  # m or rad
    upper: float
    effort: float  # N or N m, largest magnitude
    speed: float = inf  # m/s or rad/s, of a servo drive


def find_joint_limit(scene: Scene, joint: str) -> Limit:
    """Return the limit that a scene sets a joint: `limits` of its group, and `limit` of its actuator."""
    low = 0.0 if joint in NONNEGATIVE_JOINTS else -inf
    lower, upper = next(((span.low, span.high) for span in scene.limits if span.joint == joint), (low, inf))
    effort = speed = inf
    if scene.hardware is not None and joint in scene.actuated:
        index = scene.actuated.index(joint)
        if scene.effort_units[index] in ("N", "N m"):  # the efforts of a URDF are forces and torques
            drive = scene.hardware.drives[index]
            effort = float(max(abs(drive.low), abs(drive.high)))
        if scene.hardware.servos is not None:
            speed = float(scene.hardware.servos[index].max_speed)
    return Limit(lower, upper, effort, speed)


def add_limits(robot: ElementTree.Element, scene: Scene) -> None:
    """Add the limits of all joints that have none yet; turning joints without any end become continuous."""
    for joint in robot.findall("joint"):
        if joint.get("type") == "fixed" or joint.find("limit") is not None:
            continue
        limit = find_joint_limit(scene, joint.attrib["name"])
        if joint.get("type") == "revolute" and not (isfinite(limit.lower) or isfinite(limit.upper)):
            joint.set("type", "continuous")
            if isfinite(limit.effort) or isfinite(limit.speed):
                add_limit(joint, None, min(limit.effort, UNBOUNDED), min(limit.speed, UNBOUNDED))
        else:
            lower, upper = max(limit.lower, -UNBOUNDED), min(limit.upper, UNBOUNDED)
            add_limit(joint, (lower, upper), min(limit.effort, UNBOUNDED), min(limit.speed, UNBOUNDED))
