"""Minimum-jerk trajectory through waypoints at given times.

Of all motions through the waypoints, at rest at both ends, the one with the least integral of the
squared jerk is the quintic spline with four continuous derivatives (the Euler-Lagrange equation
x⁽⁶⁾ = 0 between waypoints; for two of them the profile of Flash and Hogan, J. Neuroscience 5, 1985,
equation 3). Where no times are given, waypoints follow each other at times in proportion to their
distances, and the total duration follows from the limits.
"""

from math import factorial
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from crane_sim.files.types import Real
from crane_sim.trajectories.line_arc import Coordinates, describe_size_mismatch
from crane_sim.trajectories.point_to_point import Limits
from crane_sim.trajectories.polynomials import (
    MIN_INTERVAL,
    Array,
    PiecewisePolynomial,
    check_durations,
    max_derivatives,
    with_rest_at_ends,
)

LIMITED = ("velocity", "acceleration", "jerk")
_AT_REST = [(1, 0.0), (2, 0.0)]


class MinimumJerk(NamedTuple):
    """Waypoints, with their times, or with limits that give the times."""

    points: Annotated[tuple[Coordinates, ...], Field(min_length=2)]  # coordinate's unit, of each
    # point
    times: Annotated[tuple[Real, ...], Field(min_length=2)] | None = None  # s, increasing, of the
    # points; left out: the limits give them
    velocity: Limits | None = None  # coordinate's unit/s, limit of all, or of each; left out: none
    acceleration: Limits | None = None  # coordinate's unit/s², likewise
    jerk: Limits | None = None  # coordinate's unit/s³, likewise
    start: Real = 0.0  # s, of the first point where no times are given

    def find_error(self) -> str:
        """Return one line on values that do not fit together, empty when all do."""
        limits = {name: getattr(self, name) for name in LIMITED if getattr(self, name) is not None}
        if self.times is None and not limits:
            return "needs times, or limits: velocity, acceleration, jerk"
        if self.times is not None and (limits or self.start):
            return "times leave nothing to start and limits: give one of both"
        if self.times is not None and len(self.times) != len(self.points):
            return (
                f"needs as many times as points, here are {len(self.times)} and {len(self.points)}"
            )
        if self.times is not None and np.min(np.diff(self.times)) < MIN_INTERVAL:
            return (
                f"times must increase, by {MIN_INTERVAL:g} s at least, here are {list(self.times)}"
            )
        uneven = describe_size_mismatch(
            {f"points[{i}]": point for i, point in enumerate(self.points)} | limits
        )
        if (
            not uneven
            and self.times is None
            and not np.all(np.any(np.diff(self.points, axis=0), axis=1))
        ):
            return "two points that follow each other are the same: give times"
        return uneven

    def to_polynomials(self) -> PiecewisePolynomial:
        """Return the motion.

        Raises:
            ValueError: its limits leave it no time.
        """
        points = np.array(self.points)
        if self.times is not None:
            return minimum_jerk_spline(points, np.array(self.times))
        distances = np.linalg.norm(np.diff(points, axis=0), axis=1)
        fractions = np.concatenate([[0.0], np.cumsum(distances) / np.sum(distances)])
        total = shortest_duration(
            minimum_jerk_spline(points, fractions), (self.velocity, self.acceleration, self.jerk)
        )
        return minimum_jerk_spline(points, check_durations(self.start + total * fractions))


def minimum_jerk_spline(points: Array, times: Array) -> PiecewisePolynomial:
    """Return the motion of minimum jerk through points (K, n) at times (K,) [s].

    It is at rest before and after.
    """
    # here: few scenes have one, and it takes long to import
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(times - times[0], points, k=5, bc_type=(_AT_REST, _AT_REST))
    starts = times[:-1] - times[0]
    return with_rest_at_ends(
        times, np.stack([spline(starts, nu=k) / factorial(k) for k in range(6)], axis=2)
    )


def shortest_duration(
    polynomials: PiecewisePolynomial, limits: tuple[float | tuple[float, ...] | None, ...]
) -> float:
    """Return the shortest duration [s] within limits of the derivatives of order 1, 2, ...

    `polynomials` last 1 s.
    """
    factors = [0.0]
    for order, limit in enumerate(limits, start=1):
        if limit is not None:
            factors.append(
                float(np.max(max_derivatives(polynomials, order) / np.array(limit)))
                ** (1.0 / order)
            )
    return max(factors)
