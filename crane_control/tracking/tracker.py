"""Cartesian tracking of a payload that hangs on a suspension point (Smith & Egeland, eq. 64, 67, 74).

Horizontal coordinates relative to the base: y of the payload, tip of the suspension point, L the cable's length. For
small accelerations of the tip y'' = Oz² (tip - y), Oz² = g Lz / L², Lz the height of the tip above the payload, so the
tip is sent to tip_d = y + w / Oz², where w is the acceleration that the payload should have:
w = yd'' - kd (y' - yd') - kp (y - yd) + u, u what is learnt of a disturbance.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_control.tracking.vision import measure
from crane_sim.laws import fresh
from crane_sim.models.moving_base import carried_at
from crane_sim.numerics.jit import generic, kernel, routine
from crane_sim.trajectories.base_motion import Base, SplineBase
from crane_sim.trajectories.path import Path, further_at, reference_at

SOFT = 0.2  # of critical damping, of the gains before a ramp
LOWEST = 0.1  # of Lz / L: no cable nearer to the horizontal is believed in, whose tip would be sent to infinity


class Pendulum(NamedTuple):
    """The nominal payload of the law."""

    length: float  # m, of the cable
    gravity: float  # m/s²


class Gains(NamedTuple):
    """Of the error of the payload, and what is fed forward to the suspension point, eq. 64."""

    kp: float  # 1/s²
    kd: float  # 1/s
    velocity: float  # 1: the demanded position's velocity is fed forward, 0: it is not
    acceleration: float  # likewise the reference's acceleration
    ramp: float  # s, in which kp and kd come in, from those of a pendulum whose tip stays above the path


class Tracker(NamedTuple):
    """The law up to the suspension point, whatever carries that."""

    pendulum: Pendulum
    gains: Gains
    path: Path
    eye: Any  # a camera, or None: the payload is seen as it is
    learner: Any  # of a disturbance, or None
    base: Any  # the base's motion, if that is measured and fed forward, or None

    def fresh(self) -> "Tracker":
        """Return the law before its first state."""
        return self._replace(eye=fresh(self.eye), learner=fresh(self.learner))


class Demand(NamedTuple):
    """What the suspension point should do: horizontal position [m], velocity [m/s], acceleration [m/s²]."""

    x: tuple[float, float]
    v: tuple[float, float]
    a: tuple[float, float]


class Sample(NamedTuple):
    """Time, suspension point and reference at one evaluation of the law."""

    t: float  # s
    tip: tuple[float, float]  # m
    goal: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]  # yd, yd', yd''


class Estimate(NamedTuple):
    """Estimates of a learner at one sample: payload, disturbance, compensation."""

    y: tuple[float, float]  # m
    dy: tuple[float, float]  # m/s
    u: tuple[float, float]  # m/s², against the disturbance
    du: tuple[float, float]  # m/s³, its rate of change, as far as it is known
    d: tuple[float, float]  # m/s², the estimated disturbance
    rope: tuple[float, float]  # nominal length over the estimated one, axis by axis


@generic
def estimate(learner, pendulum, sample, measurement):
    """Return the Estimate of a learner at a Sample; without one, the measured state and no disturbance."""
    return Estimate(measurement.y, measurement.dy, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (1.0, 1.0))


@generic
def heave_and_push(base, gravity, t):
    """Return (gravity that the payload feels, horizontal push of the base (2,)) [m/s²], of a base that is measured.

    What a turning base adds to the push away from its origin is left out.
    """
    return gravity, (0.0, 0.0)


@heave_and_push.register(Base)
@heave_and_push.register(SplineBase)
def _(base, gravity, t):
    x, y, z = carried_at(base, gravity, t).imposed
    return gravity - z, (x, y)


@kernel
def stiffness(length, gravity, y, tip):
    """Return Oz² [1/s²] of a payload at y [m] on a cable of this length [m] below the tip [m]."""
    rx, ry = y[0] - tip[0], y[1] - tip[1]
    height = sqrt(max(length * length - rx * rx - ry * ry, (LOWEST * length) ** 2))
    return gravity * height / (length * length)


@routine
def demanded_tip(tracker, t, tip, y, dy):
    """Return the Demand on the suspension point at `tip` (2,) for the payload at y, dy (2,); the law may learn."""
    (x, v, a), (jerk, _) = reference_at(tracker.path, t), further_at(tracker.path, t)
    goal = ((x[0], x[1]), (v[0], v[1]), (a[0], a[1]))
    measurement = measure(tracker.eye, t, y, dy)
    estimates = estimate(tracker.learner, tracker.pendulum, Sample(t, tip, goal), measurement)
    gravity, push = heave_and_push(tracker.base, tracker.pendulum.gravity, t)
    length = tracker.pendulum.length
    square0 = stiffness(length / estimates.rope[0], gravity, estimates.y, tip)
    square1 = stiffness(length / estimates.rope[1], gravity, estimates.y, tip)
    x0, v0 = axis_demand(tracker.gains, t, square0, estimates, tip, goal, jerk, push, 0)
    x1, v1 = axis_demand(tracker.gains, t, square1, estimates, tip, goal, jerk, push, 1)
    forward = tracker.gains.acceleration
    return Demand((x0, x1), (v0, v1), (forward * a[0], forward * a[1]))


@kernel
def compute_ramp(ramp, t):
    """Return (share of what comes in within `ramp` [s], at time t [s], its rate [1/s]), smooth at both ends."""
    if t >= ramp:
        return 1.0, 0.0
    s = t / ramp
    return s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / ramp


@kernel
def axis_demand(gains, t, square, estimates, tip, goal, jerk, push, i):
    """Return (position, velocity to feed forward) that are demanded of the tip along axis i, eq. 67 and 74.

    The velocity leaves out how Oz² changes; the payload's acceleration in it is that of the model.
    """
    acceleration = square * (tip[i] - estimates.y[i]) + estimates.d[i]
    e, de = estimates.y[i] - goal[0][i], estimates.dy[i] - goal[1][i]
    (share, rising), soft = compute_ramp(gains.ramp, t), 2.0 * SOFT * sqrt(square)
    kp, kd = share * gains.kp + (1.0 - share) * square, share * gains.kd + (1.0 - share) * soft
    w = goal[2][i] - kd * de - kp * e + estimates.u[i] - push[i]
    rate = jerk[i] + estimates.du[i] - kd * (acceleration - goal[2][i]) - kp * de
    rate -= rising * ((gains.kd - soft) * de + (gains.kp - square) * e)
    return estimates.y[i] + w / square, gains.velocity * (estimates.dy[i] + rate / square)
