"""Motors of a scene's joints: their checks, and the inertia that they add."""

from math import inf

from crane_sim.files.errors import SceneError
from crane_sim.scenes.schema.hardware import ActuatorGroup, MotorGroup, group_name, merge_groups
from crane_sim.scenes.schema.scene_file import SceneFile

MOTOR_EFFORT_UNITS = ("N", "N m")


def motor_of(file: SceneFile, joint: str) -> MotorGroup | None:
    """Return the motor of a joint, None where it has none or is not actuated.

    Raises:
        SceneError: the joint is not driven by force or torque, or keys of the motor contradict each
            other.
    """
    if not file.actuators:
        return None
    key = f"actuators.{group_name(file.actuators, joint, 'motor')}.motor"
    motor = merge_groups(file.actuators, joint, ActuatorGroup).motor
    unit = dict(zip(file.actuated, file.effort_units, strict=True)).get(joint)
    if motor is None or unit is None:
        return None
    if unit not in MOTOR_EFFORT_UNITS:
        raise SceneError(
            f"{key}: belongs to a drive by force or torque; the {joint} is driven in {unit}"
        )
    _check_curve(key, motor)
    return motor


def _check_curve(key: str, motor: MotorGroup) -> None:
    """Reject a torque-speed curve that is incomplete or does not fall."""
    if (motor.torque == inf) != (motor.no_load_speed == inf):
        missing = "torque" if motor.torque == inf else "no_load_speed"
        raise SceneError(f"{key}.{missing}: is missing, a curve has torque and no_load_speed")
    if motor.base_speed > 0.0 and motor.torque == inf:
        raise SceneError(
            f"{key}.base_speed = {motor.base_speed:g}: belongs to a curve; give torque and "
            "no_load_speed"
        )
    if not motor.base_speed < motor.no_load_speed:
        raise SceneError(
            f"{key}.base_speed = {motor.base_speed:g}: must be less than no_load_speed"
        )


def reflected_inertia(file: SceneFile, joint: str) -> float:
    """Return ratio² × inertia [kg or kg m²] of a joint's motor, 0 without one.

    Raises:
        SceneError: see `motor_of`.
    """
    motor = motor_of(file, joint)
    return motor.ratio**2 * motor.inertia if motor is not None else 0.0
