"""Tip servos: state of the cable below the suspension point, and the efforts that move this point.

Equations are those of Smith & Egeland, "Nonparametric adaptive payload tracking for an offshore
crane". A tip servo is the lowest loop of a tracking law: a `Servo` or a `PositionServo` of the
crane `pendulum`, whose suspension point is driven, by accelerations [m/s²] or positions [m]; or a
`knuckle_boom.BoomServo`. Vectors are in the axes of the base and relative to it; the horizontal
ones have the components x and y of the base.
"""

from typing import Any, NamedTuple, Protocol

from crane_sim.files.types import NonNegative, Positive


class TipServo(Protocol):
    """Interface of a tip servo; gains kp [1/s²] and kd [1/s] on the tip's position and rate.

    The tip is the suspension point; kp acts on its position error, kd on the rate of this error.
    """

    kp: float
    kd: float

    def cable_state(self, length: Any, q: Any, v: Any) -> Any:
        """Return the CableState at q, v (nq,) for a rope of the nominal length [m]."""
        ...

    def suspension_efforts(self, t: Any, setpoint: Any, cable: Any) -> Any:
        """Return the efforts (nu,) that move the tip to a TipSetpoint at t [s] (eq. 64)."""
        ...

    def acceleration_efforts(self, t: Any, cable: Any, a: Any) -> Any:
        """Return the efforts (nu,) for the tip's horizontal acceleration a (2,) [m/s²].

        The time t is in s.

        A `PositionServo` has none.
        """
        ...


class CableState(NamedTuple):
    """The ends of a cable, the suspension point and the payload, and the direction of the cable."""

    tip: tuple[float, float]  # m, the suspension point's horizontal position
    dtip: tuple[float, float]  # m/s
    payload: tuple[float, float]  # m, the payload's horizontal position, y in the paper
    dpayload: tuple[float, float]  # m/s
    n: tuple[float, float, float]  # unit vector from the suspension point to the payload
    dn: tuple[float, float, float]  # 1/s, derivative of n
    crane_state: tuple[Any, Any] | None  # (support state, payload state) of the nominal crane that
    # carries the suspension point; None where the point itself is driven


def driven_cable_state(servo, length, q, v):
    """Return the CableState below a driven suspension point.

    Joints are the tip's x, y, z [m] and the unit vector from the tip to the payload.
    """
    n, dn = (q[3], q[4], q[5]), (v[3], v[4], v[5])
    payload = (q[0] + length * n[0], q[1] + length * n[1])
    return CableState(
        (q[0], q[1]),
        (v[0], v[1]),
        payload,
        (v[0] + length * dn[0], v[1] + length * dn[1]),
        n,
        dn,
        None,
    )


def compute_tracking_acceleration(servo, setpoint, cable):
    """Return the acceleration (2,) [m/s²] of eq. 64, by the gains kp and kd of a servo."""
    x, v, a = setpoint  # position, velocity, acceleration
    ax = a[0] - servo.kd * (cable.dtip[0] - v[0]) - servo.kp * (cable.tip[0] - x[0])
    ay = a[1] - servo.kd * (cable.dtip[1] - v[1]) - servo.kp * (cable.tip[1] - x[1])
    return ax, ay


class Servo(NamedTuple):
    """Servo of the suspension point: natural frequency 26 rad/s, damping ratio 0.7.

    The law accelerates this point.
    """

    kp: Positive = 676.0  # 1/s², gain on the position error of the suspension point
    kd: NonNegative = 36.4  # 1/s, gain on its velocity error
    cable_state = driven_cable_state

    def suspension_efforts(self, t, setpoint, cable):
        """Return the acceleration (2,) [m/s²] that is commanded, see `TipServo`."""
        return compute_tracking_acceleration(self, setpoint, cable)

    def acceleration_efforts(self, t, cable, a):
        """Return a itself, which is commanded."""
        return a


class PositionServo(NamedTuple):
    """Gains of the servo in a plant whose suspension point takes positions as commands."""

    kp: float  # 1/s²
    kd: float  # 1/s
    cable_state = driven_cable_state

    def suspension_efforts(self, t, setpoint, cable):
        """Return position commands (2,) [m] by which the plant's servo follows the setpoint.

        Its acceleration of the point is then the one of the setpoint.
        """
        x, v, a = setpoint
        # s, s²: x + kd/kp v + 1/kp a, the servo's law inverted
        lead, per_kp = self.kd / self.kp, 1.0 / self.kp
        return x[0] + lead * v[0] + per_kp * a[0], x[1] + lead * v[1] + per_kp * a[1]
