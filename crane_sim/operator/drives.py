"""Speed drives for an operator: a scene without its law, whose actuated joints follow speeds.

Ramps bound the accelerations.

Joints that are driven by force, torque or acceleration get a frequency converter: `drive: velocity`
with a PI loop and a reference within bounds of speed, acceleration and jerk. The PI loop places
both poles at `BANDWIDTH` for the joint and everything that it moves. Winches that are driven by
speed get these bounds as `limit` and `rate_limit`. Settings in the scene are kept.
"""

from collections.abc import Mapping
from math import inf
from typing import Any, NamedTuple

from crane_sim.files.document import without_nulls
from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.hardware.records import ideal_drives
from crane_sim.hardware.reference_profiles import Bounds
from crane_sim.hardware.servos import COMMANDS, VELOCITY
from crane_sim.operator.desk import DrivenJoint
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.scenes.schema.hardware import ALL
from crane_sim.simulation.hardware import joint_mechanics

BANDWIDTH = 10.0
"""rad/s, both poles of a speed loop on its joint: that of `bridge_speed_drive`."""
RAMP_EFFORT_FRACTION = 0.5
"""Fraction of a drive's effort beyond the static load that its ramps use."""
JERK_TIME = 0.25
"""Seconds in which a reference's acceleration reaches its largest value."""
SOFT_LIMIT_MARGIN = 0.02
"""Margin of the soft limits, as a fraction of the travel."""
MIN_ROPE_FRACTION = 0.1
"""Minimum length of a rope as a fraction of the initial one, if the scene sets none."""
DURATION = 3600.0
"""Default duration of a run [s], if it is not stopped earlier."""


class SpeedBounds(NamedTuple):
    """Largest speed and acceleration of a joint."""

    speed: float  # m/s or rad/s
    acceleration: float  # m/s² or rad/s²


_DEFAULTS_BY_JOINT = {  # estimates, for drives whose scene sets none
    "slew": SpeedBounds(0.1, 0.05),
    "boom": SpeedBounds(0.05, 0.05),
    "jib": SpeedBounds(0.08, 0.08),
    "telescope": SpeedBounds(0.3, 0.15),
    "rope": SpeedBounds(0.4, 0.4),
    "hoist": SpeedBounds(0.4, 0.4),
}
# of all other joints
_DEFAULTS_BY_UNIT = {"rad": SpeedBounds(0.1, 0.05), "m": SpeedBounds(0.5, 0.25)}
LAW_GROUPS = ("control", "inputs", "reference")  # of a scene, replaced by an operator
_EFFORT_DRIVE_KEYS = ("lag", "rate_limit", "deadband")  # that a speed drive does not have


def with_operator_drives(
    scene: Scene, duration: float | None = None, speeds: Mapping[str, float] | None = None
) -> Scene:
    """Return the scene for an operator: no law, inputs or reference, and only speed drives.

    Args:
        scene: any.
        duration: s of the run.
        speeds: largest speeds of joints, in place of the scene's or the default ones.

    Raises:
        SceneError: there is nothing to drive, or a joint takes positions; the message is one line.
    """
    speeds = speeds or {}
    _check(scene, speeds)
    document = without_nulls(
        {key: value for key, value in scene.to_dict().items() if key not in LAW_GROUPS}
    )
    document["duration"] = DURATION if duration is None else duration
    given = document.pop("actuators", {})
    common = given.pop(ALL, {})
    requirements = _drive_requirements(scene, speeds)
    document["actuators"] = {
        joint: _make_actuator_group(
            scene, i, common | given.get(joint, {}), requirements[joint], joint in speeds
        )
        for i, joint in enumerate(scene.actuated)
    }
    return load_scene(document)


def _check(scene: Scene, speeds: Mapping[str, float]) -> None:
    """Raise SceneError where nothing takes a speed, or a speed belongs to no joint."""
    if not scene.actuated:
        raise SceneError(f"scene {scene.name}: has no actuated joint; nothing to operate")
    if "m" in scene.effort_units:
        joint = scene.actuated[scene.effort_units.index("m")]
        raise SceneError(
            f"scene {scene.name}: the {joint} takes positions, an operator gives speeds; another "
            "drive?"
        )
    for joint, speed in speeds.items():
        if joint not in scene.actuated:
            raise SceneError(f"--speed {joint}: {unknown_key(joint, scene.actuated, 'joint')}")
        if not 0.0 < speed < inf:
            raise SceneError(f"--speed {joint}={speed:g}: must be a number greater than 0")


class DriveRequirement(NamedTuple):
    """What a joint's drive has to move, and within which bounds."""

    bounds: SpeedBounds
    inertia: float  # kg or kg m², the other joints locked


def _drive_requirements(scene: Scene, speeds: Mapping[str, float]) -> dict[str, DriveRequirement]:
    """Return bounds and inertia of each joint.

    A drive that is too weak for the default ramp gets a slower one.
    """
    mechanics = joint_mechanics(scene)
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    records = ideal_drives(len(scene.actuated)) if scene.hardware is None else scene.hardware.drives
    requirements = {}
    for i, (joint, drive) in enumerate(zip(scene.actuated, records, strict=True)):
        default = _DEFAULTS_BY_JOINT.get(
            joint, _DEFAULTS_BY_UNIT.get(units[joint], _DEFAULTS_BY_UNIT["m"])
        )
        motor = (
            float(drive.base_speed)
            if 0.0 < drive.base_speed < inf and drive.peak < inf
            else default.speed
        )
        load, inertia = float(mechanics.static_load[i]), float(mechanics.inertia_others_locked[i])
        reserves = (
            float(min(drive.high, drive.peak) - load),
            float(load - max(drive.low, -drive.peak)),
        )
        ramp = RAMP_EFFORT_FRACTION * min(reserves) / inertia
        acceleration = min(default.acceleration, ramp) if ramp > 0.0 else default.acceleration
        requirements[joint] = DriveRequirement(
            SpeedBounds(speeds.get(joint, motor), acceleration), inertia
        )
    return requirements


def _make_actuator_group(
    scene: Scene, i: int, given: dict[str, Any], requirement: DriveRequirement, speed_given: bool
) -> dict[str, Any]:
    """Return the group `actuators` of actuated joint i with a speed drive.

    Args:
        given: the group in the scene, whose settings are kept.
        speed_given: the operator named the largest speed, which replaces that of the scene.
    """
    bounds = requirement.bounds
    if scene.effort_units[i] == "m/s":
        ramp = {"limit": bounds.speed, "rate_limit": bounds.acceleration}
        return ramp | {
            key: value for key, value in given.items() if not (speed_given and key == "limit")
        }
    jerk = bounds.acceleration / JERK_TIME
    servo = {"max_speed": bounds.speed, "max_acceleration": bounds.acceleration, "max_jerk": jerk}
    if given.get("drive", "effort") != "effort":
        own = {key: value for key, value in given["servo"].items() if key != "position_gain"}
        servo |= {
            key: value for key, value in own.items() if not (speed_given and key == "max_speed")
        }
        if "max_acceleration" in own and "max_jerk" not in own:
            servo["max_jerk"] = own["max_acceleration"] / JERK_TIME
        return given | {"drive": "velocity", "servo": servo}
    loop = {"gain": 2.0 * BANDWIDTH * requirement.inertia, "integral_time": 2.0 / BANDWIDTH}
    kept = {key: value for key, value in given.items() if key not in _EFFORT_DRIVE_KEYS}
    return kept | {"drive": "velocity", "servo": loop | servo}


def driven_joints(scene: Scene) -> tuple[DrivenJoint, ...]:
    """Return the joints (nu,) of a scene from `with_operator_drives`.

    They have speeds, ramps and soft limits.
    """
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    start = dict(zip(scene.joint_names, scene.initial_q, strict=True))
    joints = []
    for i, name in enumerate(scene.actuated):
        low, high = _travel(scene, i, start[name])
        joints.append(DrivenJoint(name, units[name], _bounds(scene, i), low, high, _lag(scene, i)))
    return tuple(joints)


def _lag(scene: Scene, i: int) -> float:
    """Return a joint's lag [s] behind its command: of drive, delay, and winch driven by speed."""
    drive = scene.hardware.drives[i]
    lag = float(drive.lag) + int(drive.delay) * scene.period
    if scene.effort_units[i] != "m/s":
        return lag
    return lag + (
        getattr(getattr(scene.file, scene.actuated[i], None), "time_constant", None) or 0.0
    )


def _bounds(scene: Scene, i: int) -> Bounds:
    """Return the bounds of a joint's reference."""
    hardware = scene.hardware
    if scene.commands[i] == COMMANDS[VELOCITY]:
        servo = hardware.servos[i]
        return Bounds(float(servo.max_speed), float(servo.max_acceleration), float(servo.max_jerk))
    drive = hardware.drives[i]
    return Bounds(float(min(drive.high, -drive.low)), float(drive.rate_limit), inf)


def _travel(scene: Scene, i: int, start: float) -> tuple[float, float]:
    """Return the soft limits of a joint: inside its limits and limit switches."""
    name, drive = scene.actuated[i], scene.hardware.drives[i]
    ends = [(limit.low, limit.high) for limit in scene.limits if limit.joint == name]
    low = max([float(drive.switch_low), *(end[0] for end in ends)])
    high = min([float(drive.switch_high), *(end[1] for end in ends)])
    if low == -inf and name in ("rope", "hoist"):
        low = MIN_ROPE_FRACTION * start
    margin = SOFT_LIMIT_MARGIN * (high - low) if high - low < inf else 0.0
    return low + margin, high - margin
