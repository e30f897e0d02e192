"""Which cranes tracking laws drive: a pendulum whose suspension point is driven, or a knuckle boom with a rope."""

from typing import NamedTuple

from crane_control.tracking.drives import Servo, suspension_effort
from crane_control.tracking.knuckle_boom import Boom
from crane_control.tracking.reach import boom_of
from crane_control.tracking.tracker import Pendulum
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.base_motion import Base, SplineBase
from crane_sim.trajectories.path import Path


class Positioned(NamedTuple):
    """The gains of a plant that is commanded the position of its suspension point."""

    kp: float  # 1/s²
    kd: float  # 1/s


@suspension_effort.register(Positioned)
def _(drive, t, demand, cable):
    x, v, a = demand
    lead, gain = drive.kd / drive.kp, 1.0 / drive.kp
    return x[0] + lead * v[0] + gain * a[0], x[1] + lead * v[1] + gain * a[1]


def pendulum_of(name: str, nominal: Scene) -> tuple[Pendulum, Path]:
    """Return the nominal payload of the law called `name`, and the payload's path.

    Raises:
        SceneError: it is no law for the scene.
    """
    law = f"control.law = {name!r}"
    if nominal.crane not in ("pendulum", "knuckle"):
        raise SceneError(f"{law}: is a law for the pendulum and the knuckle boom, not for crane = {nominal.crane!r}")
    if nominal.crane == "pendulum" and len(nominal.actuated) != 2:
        raise SceneError(f"{law}: moves the suspension point in its plane; take suspension.height: fixed")
    if nominal.model.gravity <= 0.0:
        raise SceneError(f"gravity = {nominal.model.gravity:g}: {law} needs some, or the payload follows nothing")
    path = nominal.path
    if path is None or path.of_joints or path.coordinates.rest is None:
        raise SceneError(f"reference.path: {law} needs one of the payload's x and y")
    length = nominal.initial_q[3] if nominal.crane == "knuckle" else nominal.model.cable.length
    return Pendulum(length, nominal.model.gravity), path


def drive_of(
    name: str, servo: Servo | None, nominal: Scene, base: Base | SplineBase | None
) -> Servo | Positioned | Boom:
    """Return what carries the suspension point: the law's own servo, that of a plant that takes positions, or a boom.

    Args:
        name, nominal: of the law, its nominal scene.
        servo: that of the law's settings, None where they leave it out.
        base: the base's motion, if that is measured.

    Raises:
        SceneError: the law has been given a servo beside the plant's, or the boom cannot follow the path.
    """
    if nominal.crane == "knuckle":
        return boom_of(name, servo or Servo(), nominal, base)
    its_own = nominal.model.support.servo
    if its_own is None:
        return servo or Servo()
    if servo is not None:
        raise SceneError("control.servo: the suspension has one itself; leave it out, or take drive: acceleration")
    return Positioned(its_own.kp, its_own.kd)
