"""Prescribed motions: functions of time with their first two derivatives.

A scene names a shape (SmoothMotion, SineMotion, PolynomialMotion, SplineMotion); each becomes the
same `Motion`, pieces of polynomials plus a sine, so that one compiled function evaluates them all.
"""

from math import cos, sin
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from crane_sim.files.types import Angle, Positive, Real
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.piecewise import find_piece, find_table_error, polynomial_at

MIN_INTERVAL = 1e-6  # s, between two values of a motion: its powers stay in the range of doubles


class Motion(NamedTuple):
    """The polynomial of the piece that t is in, in powers of t - starts[piece], plus a sine."""

    starts: Any  # (pieces,) s, increasing; the first piece also holds before
    coefficients: Any  # (pieces, degree + 1), from the constant on
    amplitude: float = 0.0
    frequency: float = 0.0  # rad/s
    phase: float = 0.0  # rad


class SmoothMotion(NamedTuple):
    """From one value to another by the quintic 10s³ - 15s⁴ + 6s⁵, at rest before and after."""

    begin: Real  # m, value before
    end: Real  # m, value after
    start: Real = 0.0  # s, when it begins
    duration: Annotated[Positive, Field(ge=MIN_INTERVAL)] = 1.0  # s, from begin to end

    def motion(self) -> Motion:
        """Return the motion."""
        change, span = self.end - self.begin, self.duration
        rise = [
            self.begin,
            0.0,
            0.0,
            10.0 * change / span**3,
            -15.0 * change / span**4,
            6.0 * change / span**5,
        ]
        rest = [0.0] * 5
        # any instant before: it holds there, too
        starts = np.array([self.start - 1.0, self.start, self.start + span])
        return Motion(starts, np.array([[self.begin, *rest], rise, [self.end, *rest]]))


class SineMotion(NamedTuple):
    """offset + amplitude sin(frequency t + phase)."""

    amplitude: Real  # m, size of the sine
    frequency: Real  # rad/s, of the sine
    offset: Real = 0.0  # m, added to the sine
    phase: Angle = 0.0  # rad, of the sine at t = 0

    def motion(self) -> Motion:
        """Return the motion."""
        return Motion(
            np.zeros(1), np.array([[self.offset]]), self.amplitude, self.frequency, self.phase
        )


class PolynomialMotion(NamedTuple):
    """The sum of coefficients[k] t^k, k from 0 on."""

    coefficients: Annotated[tuple[Real, ...], Field(min_length=1)]  # m, coefficient of t^k, k = 0,
    # 1, 2, ..., over s^k

    def motion(self) -> Motion:
        """Return the motion."""
        return Motion(np.zeros(1), np.array([self.coefficients]))


class SplineMotion(NamedTuple):
    """The cubic spline through (times, values), at rest before and after them."""

    times: Annotated[tuple[Real, ...], Field(min_length=2)]  # s, increasing
    values: Annotated[tuple[Real, ...], Field(min_length=2)]  # m, as many as times

    def find_error(self) -> str:
        """Return one line on what is wrong with the table, empty when nothing is."""
        return find_table_error(self.times, self.values, MIN_INTERVAL)

    def motion(self) -> Motion:
        """Return the motion."""
        # here: few scenes have one, and it takes long to import
        from scipy.interpolate import CubicSpline

        pieces = CubicSpline(self.times, self.values, bc_type="clamped").c[::-1].T
        before, after = (np.array([[self.values[i], 0.0, 0.0, 0.0]]) for i in (0, -1))
        return Motion(
            np.array([self.times[0] - 1.0, *self.times]), np.vstack([before, pieces, after])
        )


Shape = SmoothMotion | SineMotion | PolynomialMotion | SplineMotion


@routine
def evaluate_motion(motion, t):
    """Return (position, velocity, acceleration) at time t [s]."""
    piece = find_piece(motion.starts, len(motion.starts), t)
    value, rate, second, _, _ = polynomial_at(motion.coefficients, piece, t - motion.starts[piece])
    angle, w = motion.frequency * t + motion.phase, motion.frequency
    value = value + motion.amplitude * sin(angle)
    return (
        value,
        rate + motion.amplitude * w * cos(angle),
        second - motion.amplitude * w * w * sin(angle),
    )


@routine
def motion_acceleration(motion, t):
    """Return the acceleration of `evaluate_motion`, for equations.

    Without a sine it takes no library function.
    """
    piece = find_piece(motion.starts, len(motion.starts), t)
    _, _, second, _, _ = polynomial_at(motion.coefficients, piece, t - motion.starts[piece])
    if motion.amplitude == 0.0:
        return second
    w = motion.frequency
    return second - motion.amplitude * w * w * sin(motion.frequency * t + motion.phase)
