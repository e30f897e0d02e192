"""Cartesian tracking of a payload on a suspension point (Smith & Egeland, eq. 64, 67, 74).

Horizontal coordinates relative to the base: y of the payload, tip of the suspension point, L the
cable's length. For small accelerations of the tip y'' = ω² (tip - y), ω the pendulum frequency (Oz
in the paper), ω² = g Lz / L², Lz the height of the tip above the payload, so the tip's setpoint is
y + w / ω², w the desired acceleration of the payload: w = yd'' - kd (y' - yd') - kp (y - yd) + u, u
the compensation of an estimated disturbance.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_control.tracking.vision import measure
from crane_sim.laws import with_initial_state
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.trajectory import Trajectory, higher_derivatives_at, reference_at

INITIAL_DAMPING = 0.2  # -, damping ratio that the gains give at the start of a ramp
# of Lz / L, its lower bound: for a horizontal cable the setpoint of the tip would be infinite
MIN_HEIGHT_RATIO = 0.1


class Pendulum(NamedTuple):
    """The nominal payload of the law."""

    length: float  # m, of the cable
    gravity: float  # m/s²


class Gains(NamedTuple):
    """Of the error of the payload, and what is fed forward to the suspension point, eq. 64."""

    kp: float  # 1/s²
    kd: float  # 1/s
    velocity: float  # 1: the setpoint's velocity is fed forward, 0: it is not
    acceleration: float  # likewise the reference's acceleration
    ramp: float  # s, in which kp and kd rise to their values, from ω² and 0.4 ω: with those the
    # tip's setpoint is the payload's reference plus damping and feedforward


class Tracker(NamedTuple):
    """The outer loop: from the payload's error to the setpoint of the suspension point."""

    pendulum: Pendulum
    gains: Gains
    trajectory: Trajectory
    camera: Any  # None: the payload is measured exactly
    disturbance_estimator: Any  # learner or observer, whose `estimate(pendulum, sample,
    # measurement)` is an `Estimate`, or None
    base: Any  # the base's motion, if that is measured and fed forward, or None

    def with_initial_state(self) -> "Tracker":
        """Return the tracker with its initial state."""
        return self._replace(
            camera=with_initial_state(self.camera),
            disturbance_estimator=with_initial_state(self.disturbance_estimator),
        )


class TipSetpoint(NamedTuple):
    """Setpoint of the tip: horizontal position [m], velocity [m/s], acceleration [m/s²]."""

    x: tuple[float, float]
    v: tuple[float, float]
    a: tuple[float, float]


class Sample(NamedTuple):
    """Time, suspension point and reference at one evaluation of the law."""

    t: float  # s
    tip: tuple[float, float]  # m
    goal: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]  # yd, yd', yd''


class Estimate(NamedTuple):
    """Estimates of a disturbance estimator at one sample: payload, disturbance, compensation."""

    position: tuple[float, float]  # m, of the payload
    velocity: tuple[float, float]  # m/s
    u: tuple[float, float]  # m/s², compensation of the disturbance
    du: tuple[float, float]  # m/s³, its rate of change, 0 where unknown
    d: tuple[float, float]  # m/s², the estimated disturbance
    length_ratio: tuple[float, float]  # nominal length over the estimated one, axis by axis


def estimate(estimator, pendulum, sample, measurement):
    """Return the Estimate at a Sample; by default the measured state and no disturbance.

    The default is for a tracker without an estimator.
    """
    if estimator is not None:
        return estimator.estimate(pendulum, sample, measurement)
    return Estimate(
        measurement.position, measurement.velocity, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (1.0, 1.0)
    )


def base_acceleration(base, gravity, t):
    """Return (apparent gravity, horizontal inertial acceleration (2,)) [m/s²] on a base.

    The base is measured.

    What a rotating base adds away from its origin is neglected.
    """
    if base is None:
        return gravity, (0.0, 0.0)
    x, y, z = base_kinematics_at(base, gravity, t).imposed
    return gravity - z, (x, y)


def pendulum_omega_sq(length, gravity, y, tip):
    """Return ω² [1/s²] of a payload at y [m] on a cable of this length [m] below the tip [m]."""
    rx, ry = y[0] - tip[0], y[1] - tip[1]
    height = sqrt(max(length * length - rx * rx - ry * ry, (MIN_HEIGHT_RATIO * length) ** 2))
    return gravity * height / (length * length)


@routine
def compute_tip_setpoint(tracker, t, tip, y, dy):
    """Return the TipSetpoint at `tip` (2,) and payload y, dy (2,).

    The state of camera and estimator is updated.
    """
    (x, v, a), (jerk, _) = (
        reference_at(tracker.trajectory, t),
        higher_derivatives_at(tracker.trajectory, t),
    )
    goal = ((x[0], x[1]), (v[0], v[1]), (a[0], a[1]))
    measurement = measure(tracker.camera, t, y, dy)
    estimates = estimate(
        tracker.disturbance_estimator, tracker.pendulum, Sample(t, tip, goal), measurement
    )
    gravity, base_acc = base_acceleration(tracker.base, tracker.pendulum.gravity, t)
    length = tracker.pendulum.length
    omega_sq0 = pendulum_omega_sq(
        length / estimates.length_ratio[0], gravity, estimates.position, tip
    )
    omega_sq1 = pendulum_omega_sq(
        length / estimates.length_ratio[1], gravity, estimates.position, tip
    )
    x0, v0 = axis_setpoint(tracker.gains, t, omega_sq0, estimates, tip, goal, jerk, base_acc, 0)
    x1, v1 = axis_setpoint(tracker.gains, t, omega_sq1, estimates, tip, goal, jerk, base_acc, 1)
    forward = tracker.gains.acceleration
    return TipSetpoint((x0, x1), (v0, v1), (forward * a[0], forward * a[1]))


def compute_ramp(ramp, t):
    """Return (factor at t [s] that rises smoothly from 0 to 1 in `ramp` [s], its rate [1/s])."""
    if t >= ramp:
        return 1.0, 0.0
    s = t / ramp
    return s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / ramp


def axis_setpoint(gains, t, omega_sq, estimates, tip, goal, jerk, base_acc, i):
    """Return (position, feedforward velocity) of the tip's setpoint along axis i, eq. 67 and 74.

    The velocity neglects the rate of ω²; the payload's acceleration in it is that of the model.
    """
    acceleration = omega_sq * (tip[i] - estimates.position[i]) + estimates.d[i] + base_acc[i]
    e, de = estimates.position[i] - goal[0][i], estimates.velocity[i] - goal[1][i]
    (factor, factor_rate), initial_kd = (
        compute_ramp(gains.ramp, t),
        2.0 * INITIAL_DAMPING * sqrt(omega_sq),
    )
    kp, kd = (
        factor * gains.kp + (1.0 - factor) * omega_sq,
        factor * gains.kd + (1.0 - factor) * initial_kd,
    )
    w = goal[2][i] - kd * de - kp * e + estimates.u[i] - base_acc[i]
    rate = jerk[i] + estimates.du[i] - kd * (acceleration - goal[2][i]) - kp * de
    rate -= factor_rate * ((gains.kd - initial_kd) * de + (gains.kp - omega_sq) * e)
    return estimates.position[i] + w / omega_sq, gains.velocity * (
        estimates.velocity[i] + rate / omega_sq
    )
