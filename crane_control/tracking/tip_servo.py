"""Tip servos: state of the cable below the suspension point, and the efforts that move this point.

Equations are those of Smith & Egeland, "Nonparametric adaptive payload tracking for an offshore crane".
A tip servo is the lowest loop of a tracking law: a `Servo`, a `suspension.PositionServo` or a `knuckle_boom.BoomServo`.
Vectors are in the axes of the base and relative to it; the horizontal ones have the components x and y of the base. The
default implementations here are those for the crane `pendulum`, whose suspension point is driven: its efforts are the
commands of that drive, accelerations [m/s²] or positions [m].
"""

from typing import Any, NamedTuple

from crane_sim.files.types import NonNegative, Positive
from crane_sim.numerics.jit import generic


class Servo(NamedTuple):
    """Servo of the suspension point, which the law accelerates: natural frequency 26 rad/s, damping ratio 0.7."""

    kp: Positive = 676.0  # 1/s², gain on the position error of the suspension point
    kd: NonNegative = 36.4  # 1/s, gain on its velocity error


class CableState(NamedTuple):
    """The ends of a cable, the suspension point and the payload, and the direction of the cable."""

    tip: tuple[float, float]  # m, the suspension point's horizontal position
    dtip: tuple[float, float]  # m/s
    payload: tuple[float, float]  # m, the payload's horizontal position, y in the paper
    dpayload: tuple[float, float]  # m/s
    n: tuple[float, float, float]  # unit vector from the suspension point to the payload
    dn: tuple[float, float, float]  # 1/s, derivative of n
    crane_state: tuple[Any, Any] | None  # (support state, payload state) of the nominal crane that carries the
    # suspension point; None where the point itself is driven


@generic
def compute_cable_state(servo, length, q, v):
    """Return the CableState at joint positions q and velocities v (nq,) for a rope of the nominal length [m].

    Joints are the tip's x, y, z [m] and the unit vector from the tip to the payload.
    """
    n, dn = (q[3], q[4], q[5]), (v[3], v[4], v[5])
    payload = (q[0] + length * n[0], q[1] + length * n[1])
    return CableState((q[0], q[1]), (v[0], v[1]), payload, (v[0] + length * dn[0], v[1] + length * dn[1]), n, dn, None)


@generic
def compute_efforts_for_acceleration(servo, t, cable, a):
    """Return the efforts (nu,) that give the suspension point the horizontal acceleration a (2,) [m/s²] at time t [s].

    `cable` is the CableState at t. By default the efforts are a itself, for cranes whose commands are accelerations.
    """
    return a


@generic
def compute_suspension_efforts(servo, t, setpoint, cable):
    """Return the efforts (nu,) that move the suspension point of a CableState to a TipSetpoint at t [s] (eq. 64)."""
    raise NotImplementedError


def compute_tracking_acceleration(servo, setpoint, cable):
    """Return the acceleration (2,) [m/s²] of eq. 64, by the gains kp and kd of a servo."""
    x, v, a = setpoint  # position, velocity, acceleration
    ax = a[0] - servo.kd * (cable.dtip[0] - v[0]) - servo.kp * (cable.tip[0] - x[0])
    ay = a[1] - servo.kd * (cable.dtip[1] - v[1]) - servo.kp * (cable.tip[1] - x[1])
    return ax, ay


@compute_suspension_efforts.register(Servo)
def _(servo, t, setpoint, cable):
    return compute_tracking_acceleration(servo, setpoint, cable)
