"""The servo drives of a scene in numbers, checked against its joints."""

from math import inf
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.hardware.records import effort_servos
from crane_sim.hardware.servos import COMMANDS
from crane_sim.scenes.schema.hardware import (
    ALL,
    ActuatorGroup,
    EffortLoss,
    ServoGroup,
    group_name,
    merge_groups,
)
from crane_sim.scenes.schema.motors import motor_of
from crane_sim.scenes.schema.scene_file import SceneFile

EFFORT, VELOCITY, POSITION = COMMANDS


def servos_of(file: SceneFile) -> Any:
    """Return records of SERVO (nu,), None where all drives are commanded efforts.

    Raises:
        SceneError: keys of a drive contradict each other, or do not fit the joint.
    """
    groups = {joint: merge_groups(file.actuators, joint, ActuatorGroup) for joint in file.actuated}
    followed = [joint for joint, group in groups.items() if group.drive != EFFORT]
    for name, group in file.actuators.items():
        if group.servo is not None and not (followed if name == ALL else name in followed):
            raise SceneError(
                f"actuators.{name}.servo: belongs to a drive with drive = {VELOCITY!r} or "
                f"{POSITION!r}"
            )
    if not followed:
        return None
    servos = effort_servos(len(file.actuated))
    for servo, (joint, group), unit in zip(servos, groups.items(), file.effort_units, strict=True):
        if group.drive != EFFORT:
            _fill(servo, group, _checked_servo(file, joint, group, unit))
    return servos


def _fill(servo: Any, group: ActuatorGroup, settings: ServoGroup) -> None:
    """Write the parameters of a servo drive into its record."""
    servo.kind, servo.ideal = COMMANDS.index(group.drive), settings.gain == inf
    servo.gain = 0.0 if servo.ideal else settings.gain
    servo.stiffness = servo.gain / settings.integral_time if settings.integral_time else 0.0
    servo.position_gain = settings.position_gain or 0.0
    servo.max_speed = settings.max_speed or inf
    servo.max_acceleration = settings.max_acceleration or inf
    servo.max_jerk = settings.max_jerk or inf


def _checked_servo(file: SceneFile, joint: str, group: ActuatorGroup, unit: str) -> ServoGroup:
    """Return the settings of a joint's servo drive; SceneError where keys are contradictory."""
    drive = f"actuators.{group_name(file.actuators, joint, 'drive')}.drive = {group.drive!r}"
    if unit in ("m/s", "m"):
        rest = "it follows by itself, without a servo drive; name the other joints"
        raise SceneError(f"{drive}: the {joint} is driven in {unit}: {rest}")
    if group.servo is None:
        raise SceneError(f"{drive}: needs its gain, in actuators.{joint}.servo")
    for key in ("lag", "rate_limit", *(["deadband"] if group.drive == POSITION else [])):
        if getattr(group, key):
            name = group_name(file.actuators, joint, key)
            given = f"actuators.{name}.{key} = {getattr(group, key):g}"
            raise SceneError(f"{given}: not with drive = {group.drive!r}; leave it out")
    _check_keys(
        f"actuators.{group_name(file.actuators, joint, 'servo')}.servo", group.drive, group.servo
    )
    if group.servo.gain == inf:
        _check_exact(file, joint, group)
    return group.servo


def _check_keys(key: str, drive: str, servo: ServoGroup) -> None:
    """Reject settings of a servo drive that lack what its kind needs, or have what it does not."""
    exact = servo.gain == inf
    if drive == POSITION and servo.max_speed is None:
        raise SceneError(f"{key}.max_speed: is missing, drive = {drive!r} needs one")
    if drive == POSITION and not exact and servo.position_gain is None:
        raise SceneError(f"{key}.position_gain: is missing, drive = {drive!r} needs one")
    if servo.position_gain is not None and (drive == VELOCITY or exact):
        owner = f"drive = {POSITION!r} and a finite gain"
        raise SceneError(f"{key}.position_gain = {servo.position_gain:g}: belongs to {owner}")
    if exact and servo.integral_time is not None:
        raise SceneError(f"{key}.integral_time = {servo.integral_time:g}: not with gain = inf")
    if exact and servo.max_acceleration is None:
        raise SceneError(f"{key}.max_acceleration: is missing, gain = inf needs one")


def _check_exact(file: SceneFile, joint: str, group: ActuatorGroup) -> None:
    """Reject what keeps a drive from an exact motion: limits, impacts, play, friction, faults."""
    _refuse_effort_limits(file, joint, group)
    if getattr(file, "events", ()) and not hasattr(file, "falls"):
        why = (
            "jerks the joints, which servo.gain = inf does not let go back to their references; "
            "give a finite gain"
        )
        raise SceneError(f"events: an exchange of the load {why}")
    if joint in getattr(file, "backlash", {}):
        raise SceneError(
            f"backlash.{joint}: a joint with play cannot follow exactly, as servo.gain = inf does"
        )
    _refuse_friction(file, joint)
    for name, fault in file.faults.items():
        if isinstance(fault, EffortLoss) and fault.joint == joint:
            raise SceneError(
                f"faults.{name}: the drive of {joint} follows exactly, servo.gain = inf: it loses "
                "nothing"
            )


def _refuse_effort_limits(file: SceneFile, joint: str, group: ActuatorGroup) -> None:
    motor = motor_of(file, joint)
    limits = {"limit": group.limit is not None, "motor": motor is not None and motor.torque < inf}
    for key, given in limits.items():
        if given:
            name = group_name(file.actuators, joint, key)
            raise SceneError(
                f"actuators.{name}.{key}: limits the effort, and servo.gain = inf follows exactly"
            )


def _refuse_friction(file: SceneFile, joint: str) -> None:
    for key in ("friction", "lugre"):
        groups = getattr(file, key, None) or {}
        part = groups.get(joint) if isinstance(groups, dict) else getattr(groups, joint, None)
        if part is not None:
            raise SceneError(
                f"{key}.{joint}: a joint that may stick cannot follow exactly, as servo.gain = inf "
                "does"
            )
    winch = getattr(file, joint, None)
    if getattr(winch, "friction", None) is not None:
        raise SceneError(
            f"{joint}.friction: a winch that may stick cannot follow exactly, as servo.gain = inf "
            "does"
        )
