"""The crane `pendulum` as laws see it: tip and payload from the joints, and how a demanded motion becomes an effort."""

from typing import NamedTuple

from crane_control.tracking import Pendulum
from crane_sim.explain import SceneError
from crane_sim.jit import generic, kernel
from crane_sim.quantities import NonNegative, Positive
from crane_sim.references import Path
from crane_sim.scene import Scene


class Servo(NamedTuple):
    """How the suspension point is driven by a law that commands its acceleration: 26 rad/s, 0.7 of critical damping."""

    kp: Positive = 676.0  # 1/s²
    kd: NonNegative = 36.4  # 1/s


class Positioned(NamedTuple):
    """The gains of a plant that is commanded the position of its suspension point."""

    kp: float  # 1/s²
    kd: float  # 1/s


@kernel
def tip_and_payload(length, q, v):
    """Return (tip, its velocity, payload, its velocity), horizontal, from the joints of a pendulum of this length [m].

    Joints are the tip's x, y, z [m] and the unit vector from the tip to the payload.
    """
    tip, dtip = (q[0], q[1]), (v[0], v[1])
    y = (q[0] + length * q[3], q[1] + length * q[4])
    return tip, dtip, y, (v[0] + length * v[3], v[1] + length * v[4])


@generic
def suspension_effort(drive, demand, tip, dtip):
    """Return the efforts (2,) that bring the suspension point at `tip` with velocity `dtip` to a Demand, eq. 64."""
    raise NotImplementedError


@suspension_effort.register(Servo)
def _(drive, demand, tip, dtip):
    x, v, a = demand
    ax = a[0] - drive.kd * (dtip[0] - v[0]) - drive.kp * (tip[0] - x[0])
    ay = a[1] - drive.kd * (dtip[1] - v[1]) - drive.kp * (tip[1] - x[1])
    return ax, ay


@suspension_effort.register(Positioned)
def _(drive, demand, tip, dtip):
    x, v, a = demand
    lead, gain = drive.kd / drive.kp, 1.0 / drive.kp
    return x[0] + lead * v[0] + gain * a[0], x[1] + lead * v[1] + gain * a[1]


def pendulum_of(name: str, nominal: Scene) -> tuple[Pendulum, Path]:
    """Return what the law called `name` believes of the payload, and the payload's path.

    Raises:
        SceneError: it is no law for the scene.
    """
    law = f"control.law = {name!r}"
    if nominal.crane != "pendulum":
        raise SceneError(f"{law}: is a law for the pendulum, not for crane = {nominal.crane!r}")
    if len(nominal.actuated) != 2:
        raise SceneError(f"{law}: moves the suspension point in its plane; take suspension.height: fixed")
    if nominal.model.gravity <= 0.0:
        raise SceneError(f"gravity = {nominal.model.gravity:g}: {law} needs some, or the payload follows nothing")
    path = nominal.path
    if path is None or path.of_joints or path.coordinates.rest is None:
        raise SceneError(f"reference.path: {law} needs one of the payload's x and y")
    return Pendulum(nominal.model.cable.length, nominal.model.gravity), path


def drive_of(servo: Servo | None, nominal: Scene) -> Servo | Positioned:
    """Return what carries the suspension point: the law's own servo, or that of a plant that takes positions.

    Raises:
        SceneError: the law has been given a servo beside the plant's.
    """
    its_own = nominal.model.support.servo
    if its_own is None:
        return servo or Servo()
    if servo is not None:
        raise SceneError("control.servo: the suspension has one itself; leave it out, or take drive: acceleration")
    return Positioned(its_own.kp, its_own.kd)
