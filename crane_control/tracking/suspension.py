"""Cranes that tracking laws accept: a driven suspension point, or a knuckle boom with a rope.

Below a driven suspension point hangs a pendulum.
"""

from crane_control.tracking.knuckle_boom import BoomServo, make_boom_servo
from crane_control.tracking.tip_servo import PositionServo, Servo
from crane_control.tracking.tracker import Pendulum
from crane_sim.files.errors import SceneError
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.supports.support import structure_of
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.trajectory import Trajectory


def nominal_pendulum(name: str, nominal: Scene) -> tuple[Pendulum, Trajectory]:
    """Return (nominal pendulum of the law called `name`, trajectory of the payload).

    Raises:
        SceneError: the law does not fit the scene.
    """
    law = f"control.law = {name!r}"
    if nominal.crane not in ("pendulum", "knuckle"):
        raise SceneError(
            f"{law}: is a law for the pendulum and the knuckle boom, not for crane = "
            f"{nominal.crane!r}"
        )
    check_has_one_rope(name, nominal)
    if nominal.crane == "pendulum" and len(nominal.actuated) != 2:
        raise SceneError(
            f"{law}: moves the suspension point in the horizontal plane only; take "
            "suspension.height: fixed"
        )
    if nominal.model.gravity <= 0.0:
        raise SceneError(
            f"gravity = {nominal.model.gravity:g}: {law} needs gravity, without it nothing moves "
            "the payload"
        )
    path = nominal.trajectory
    has_one_coordinate = path is not None and len(path.coordinates) == 1
    if path is None or path.of_joints or has_one_coordinate:
        raise SceneError(f"reference.path: {law} needs one of the payload's x and y")
    length = nominal.initial_q[3] if nominal.crane == "knuckle" else nominal.model.cable.length
    return Pendulum(length, nominal.model.gravity), path


def make_tip_servo(
    name: str, servo: Servo | None, nominal: Scene, base: AnyBase | None
) -> Servo | PositionServo | BoomServo:
    """Return the tip servo: the law's own, the one of a position plant, or of a knuckle boom.

    A position plant takes positions.

    Args:
        name: of the law.
        servo: of the law's settings, None where they leave it out.
        nominal: the law's nominal scene.
        base: the base's motion, None where it is not measured.

    Raises:
        SceneError: both the law and the plant have a servo, or the boom cannot follow the
            trajectory.
    """
    if nominal.crane == "knuckle":
        return make_boom_servo(name, servo or Servo(), nominal, base)
    plant_servo = structure_of(nominal.model.support).servo
    if plant_servo is None:
        return servo or Servo()
    if servo is not None:
        raise SceneError(
            "control.servo: the suspension has one itself; leave it out, or take drive: "
            "acceleration"
        )
    return PositionServo(plant_servo.kp, plant_servo.kd)


def check_has_one_rope(law: str, nominal: Scene) -> None:
    """Raise SceneError if the nominal crane has falls, further links or a rigid payload.

    `law` is the name of the law.
    """
    if isinstance(
        nominal.model, FallsCrane
    ):  # its joints are the position of the load, not swing angles
        line = (
            "supports only one rope and a point mass; the scene has falls, possible with them: "
            "lqr, joint_trajectory"
        )
        raise SceneError(f"control.law = {law!r}: {line}")
    if not isinstance(nominal.model, SuspendedCrane):
        return
    keys = ", ".join(getattr(nominal.file, "beyond_one_rope", ["links"]))
    remedy = "{links: [], payload: {mass: ..., inertia: null, attachment: null}}"
    raise SceneError(
        f"control.nominal: law {law!r} supports only one rope and a point mass; the nominal scene "
        f"has {keys}; leave that out there, as {remedy} does"
    )
