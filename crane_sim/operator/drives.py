"""Drives by speed for an operator: a scene without its law, whose actuated joints all follow speeds within ramps.

Joints that are driven by force, torque or acceleration get a frequency converter: `drive: velocity` with a PI loop
whose joint, with all that hangs on it, has both poles at `BANDWIDTH`, and a reference within speed, acceleration and
jerk. Winches by rate get the same as limit and rate limit. What the scene says of a drive stays.
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
RAMP_SHARE = 0.5
"""Share of the effort that a drive has left beside the static load, for its ramps."""
RISE = 0.25
"""Seconds in which a reference's acceleration reaches its largest value."""
SOFT_MARGIN = 0.02
"""Part of a joint's travel by which soft limits stand inside its ends."""
SHORTEST = 0.1
"""Part of a rope's length at the start below which it is not hoisted, where the scene has no limits of it."""
DURATION = 3600.0
"""Seconds of a run that the operator does not end before."""


class Pace(NamedTuple):
    """What an operator expects of a joint whose scene says nothing; estimates."""

    speed: float  # m/s or rad/s
    acceleration: float


_PACES = {
    "slew": Pace(0.1, 0.05),
    "boom": Pace(0.05, 0.05),
    "jib": Pace(0.08, 0.08),
    "telescope": Pace(0.3, 0.15),
    "rope": Pace(0.4, 0.4),
    "hoist": Pace(0.4, 0.4),
}
_PACE = {"rad": Pace(0.1, 0.05), "m": Pace(0.5, 0.25)}  # of other joints, by their units
_OF_LAWS = ("control", "inputs", "reference")  # groups that an operator replaces
_OF_EFFORTS = ("lag", "rate_limit", "deadband")  # keys of a drive by effort that one by speed does not have


def with_operator_drives(
    scene: Scene, duration: float | None = None, speeds: Mapping[str, float] | None = None
) -> Scene:
    """Return the scene for an operator: no law, inputs or reference, and drives that all follow speeds.

    Args:
        scene: any.
        duration: s of the run.
        speeds: largest speeds of joints, in place of the scene's or the usual ones.

    Raises:
        SceneError: there is nothing to drive, or a joint takes positions; the message is one line.
    """
    speeds = speeds or {}
    _check(scene, speeds)
    document = without_nulls({key: value for key, value in scene.to_dict().items() if key not in _OF_LAWS})
    document["duration"] = DURATION if duration is None else duration
    given = document.pop("actuators", {})
    common = given.pop(ALL, {})
    needs = _needs(scene, speeds)
    document["actuators"] = {
        joint: _drive(scene, i, common | given.get(joint, {}), needs[joint], joint in speeds)
        for i, joint in enumerate(scene.actuated)
    }
    return load_scene(document)


def _check(scene: Scene, speeds: Mapping[str, float]) -> None:
    """Raise SceneError where nothing takes a speed, or a speed belongs to no joint."""
    if not scene.actuated:
        raise SceneError(f"scene {scene.name}: has no joint that is driven; nothing to operate")
    if "m" in scene.effort_units:
        joint = scene.actuated[scene.effort_units.index("m")]
        raise SceneError(f"scene {scene.name}: the {joint} takes positions, an operator gives speeds; another drive?")
    for joint, speed in speeds.items():
        if joint not in scene.actuated:
            raise SceneError(f"--speed {joint}: {unknown_key(joint, scene.actuated, 'joint')}")
        if not 0.0 < speed < inf:
            raise SceneError(f"--speed {joint}={speed:g}: must be a number greater than 0")


class Need(NamedTuple):
    """What a joint's drive has to move."""

    pace: Pace
    inertia: float  # kg or kg m², others locked


def _needs(scene: Scene, speeds: Mapping[str, float]) -> dict[str, Need]:
    """Return the pace of each joint, slower where its drive is too weak for the usual ramp, and its inertia."""
    mechanics = joint_mechanics(scene)
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    records = ideal_drives(len(scene.actuated)) if scene.hardware is None else scene.hardware.drives
    needs = {}
    for i, (joint, drive) in enumerate(zip(scene.actuated, records, strict=True)):
        usual = _PACES.get(joint, _PACE.get(units[joint], _PACE["m"]))
        motor = float(drive.base_speed) if 0.0 < drive.base_speed < inf and drive.peak < inf else usual.speed
        load, inertia = float(mechanics.static_load[i]), float(mechanics.inertia_others_locked[i])
        left = float(min(drive.high, drive.peak) - load), float(load - max(drive.low, -drive.peak))
        ramp = RAMP_SHARE * min(left) / inertia
        limited = min(usual.acceleration, ramp) if ramp > 0.0 else usual.acceleration
        needs[joint] = Need(Pace(speeds.get(joint, motor), limited), inertia)
    return needs


def _drive(scene: Scene, i: int, given: dict[str, Any], need: Need, asked: bool) -> dict[str, Any]:
    """Return the group of a drive by speed; `given` is the scene's own, `asked`: the operator named the speed."""
    pace = need.pace
    if scene.effort_units[i] == "m/s":
        ramp = {"limit": pace.speed, "rate_limit": pace.acceleration}
        return ramp | {key: value for key, value in given.items() if not (asked and key == "limit")}
    servo = {"max_speed": pace.speed, "max_acceleration": pace.acceleration, "max_jerk": pace.acceleration / RISE}
    if given.get("drive", "effort") != "effort":
        own = {key: value for key, value in given["servo"].items() if key != "position_gain"}
        servo |= {key: value for key, value in own.items() if not (asked and key == "max_speed")}
        if "max_acceleration" in own and "max_jerk" not in own:
            servo["max_jerk"] = own["max_acceleration"] / RISE
        return given | {"drive": "velocity", "servo": servo}
    loop = {"gain": 2.0 * BANDWIDTH * need.inertia, "integral_time": 2.0 / BANDWIDTH}
    kept = {key: value for key, value in given.items() if key not in _OF_EFFORTS}
    return kept | {"drive": "velocity", "servo": loop | servo}


def driven_joints(scene: Scene) -> tuple[DrivenJoint, ...]:
    """Return the joints (nu,) of a scene from `with_operator_drives`, with speeds, ramps and soft limits."""
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    start = dict(zip(scene.joint_names, scene.initial_q, strict=True))
    joints = []
    for i, name in enumerate(scene.actuated):
        low, high = _travel(scene, i, start[name])
        lag = getattr(getattr(scene.file, name, None), "time_constant", None) or 0.0
        rate = scene.effort_units[i] == "m/s"
        joints.append(DrivenJoint(name, units[name], _bounds(scene, i), low, high, lag if rate else 0.0))
    return tuple(joints)


def _bounds(scene: Scene, i: int) -> Bounds:
    """Return the bounds of a joint's reference."""
    hardware = scene.hardware
    if scene.commands[i] == COMMANDS[VELOCITY]:
        servo = hardware.servos[i]
        return Bounds(float(servo.max_speed), float(servo.max_acceleration), float(servo.max_jerk))
    drive = hardware.drives[i]
    return Bounds(float(min(drive.high, -drive.low)), float(drive.rate_limit), inf)


def _travel(scene: Scene, i: int, start: float) -> tuple[float, float]:
    """Return the ends of a joint's travel that soft limits keep: inside its limits and limit switches."""
    name, drive = scene.actuated[i], scene.hardware.drives[i]
    ends = [(limit.low, limit.high) for limit in scene.limits if limit.joint == name]
    low = max([float(drive.switch_low), *(end[0] for end in ends)])
    high = min([float(drive.switch_high), *(end[1] for end in ends)])
    if low == -inf and name in ("rope", "hoist"):
        low = SHORTEST * start
    margin = SOFT_MARGIN * (high - low) if high - low < inf else 0.0
    return low + margin, high - margin
