"""From one position to another in a given time, along a line or along a circle.

The path parameter s goes from 0 to 1 with one of two profiles of tau = t / T: `sine`, whose
acceleration is a sine, s = tau - sin(2 pi tau) / (2 pi), or `smooth`, the quintic 10 tau³ - 15 tau⁴
+ 6 tau⁵ of minimum jerk. Other functions are cut into short pieces, each a Taylor series, exact to
rounding.
"""

from collections.abc import Mapping
from math import ceil, cos, factorial, pi, sin, tau
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from crane_sim.files.types import Angle, Coordinate, Positive, Real
from crane_sim.numerics import libm
from crane_sim.trajectories.polynomials import (
    MIN_INTERVAL,
    Array,
    PiecewisePolynomial,
    shift_origin,
    with_rest_at_ends,
)

Coordinates = Annotated[tuple[Coordinate, ...], Field(min_length=1)]
Profile = Literal["sine", "smooth"]
Duration = Annotated[Positive, Field(ge=MIN_INTERVAL)]
DEGREE = 12
MAX_TURNED = 1e4  # rad, in an arc
SHORT = pi / 32.0  # rad, of a sine's argument in one piece: the series ends at rounding


class Line(NamedTuple):
    """A straight line."""

    begin: Coordinates  # coordinate's unit, position where the path begins
    end: Coordinates  # coordinate's unit, position where the path ends
    duration: Duration  # s, of the motion
    start: Real = 0.0  # s, time at which the motion begins
    profile: Profile = "sine"  # of the path parameter over time: a sine's acceleration, or the
    # quintic of minimum jerk

    def find_error(self) -> str:
        """Return one line on values that do not fit together, empty when all do."""
        return describe_size_mismatch({"from": self.begin, "to": self.end})

    def to_polynomials(self) -> PiecewisePolynomial:
        """Return the motion."""
        times, parameter = time_scaling(self.profile, self.start, self.duration, ceil(tau / SHORT))
        first, last = np.array(self.begin), np.array(self.end)
        coefficients = parameter[:, None, :] * (last - first)[None, :, None]
        coefficients[:, :, 0] += first
        return with_rest_at_ends(times, coefficients)


class Arc(NamedTuple):
    """An arc of a circle about `centre` in the plane of two coordinates, a third one held."""

    centre: Annotated[tuple[Real, ...], Field(min_length=2, max_length=3)]  # coordinate's unit,
    # position of the centre
    radius: Positive  # coordinate's unit, of the circle
    begin: Angle  # rad, from the first coordinate's axis towards the second's; more than a turn is
    # text, such as `720 deg`
    end: Angle  # rad, likewise
    duration: Duration  # s, of the motion
    start: Real = 0.0  # s, time at which the motion begins
    profile: Profile = "sine"  # as for a line

    def find_error(self) -> str:
        """Return one line on values that do not fit together, empty when all do."""
        turn = abs(self.end - self.begin)
        return (
            f"turns by {turn:g} rad, at most {MAX_TURNED:g} are possible"
            if turn > MAX_TURNED
            else ""
        )

    def to_polynomials(self) -> PiecewisePolynomial:
        """Return the motion."""
        turn = self.end - self.begin
        times, parameter = time_scaling(
            self.profile, self.start, self.duration, ceil(max(tau, 2.0 * abs(turn)) / SHORT)
        )
        angle = parameter * turn
        angle[:, 0] += self.begin
        cosine, sine = cos_sin_series(angle)
        derivatives = np.zeros((len(parameter), len(self.centre), DEGREE + 1))
        derivatives[:, :, 0] = self.centre
        derivatives[:, 0] += self.radius * cosine
        derivatives[:, 1] += self.radius * sine
        return with_rest_at_ends(times, derivatives)


def describe_size_mismatch(positions: Mapping[str, Any]) -> str:
    """Return one line if those positions that are tuples differ in their number of coordinates."""
    counts = {
        name: len(position) for name, position in positions.items() if isinstance(position, tuple)
    }
    first = next(iter(counts))
    for name, count in counts.items():
        if count != counts[first]:
            return (
                f"{name} needs as many coordinates as {first}, here are {count} and {counts[first]}"
            )
    return ""


def time_scaling(kind: Profile, start: float, duration: float, count: int) -> tuple[Array, Array]:
    """Return (times (count + 1,) [s], Taylor series (count, DEGREE + 1) of the path parameter).

    There is one series for each piece.
    """
    knots = np.linspace(0.0, 1.0, count + 1)
    parameter = np.zeros((count, DEGREE + 1))
    if kind == "smooth":
        parameter[:, 3:6] = [10.0, -15.0, 6.0]
        parameter = shift_origin(parameter[:, None, :], knots[:-1])[:, 0]
    else:
        for k in range(DEGREE + 1):  # the k-th derivative of a sine is the sine a quarter turn on
            parameter[:, k] = (
                -(tau ** (k - 1)) * libm.sin(tau * knots[:-1] + 0.5 * pi * k) / factorial(k)
            )
        parameter[:, 0] += knots[:-1]
        parameter[:, 1] += 1.0
    return start + duration * knots, parameter / libm.exponential(duration, np.arange(DEGREE + 1))


def cos_sin_series(angle: Array) -> tuple[Array, Array]:
    """Return the Taylor series (K, m) of cosine and sine of an angle, given by its own (K, m)."""
    cosine, sine = np.zeros_like(angle), np.zeros_like(angle)
    for i, first in enumerate(angle[:, 0]):
        cosine[i, 0], sine[i, 0] = cos(first), sin(first)
    for k in range(
        1, angle.shape[1]
    ):  # (sin a)' = a' cos a and (cos a)' = -a' sin a, coefficient by coefficient
        j = np.arange(1, k + 1)
        rates = j * angle[:, 1 : k + 1] / k
        cosine[:, k] = -np.sum(rates * sine[:, k - j], axis=1)
        sine[:, k] = np.sum(rates * cosine[:, k - j], axis=1)
    return cosine, sine
