"""Straight motion between two positions, as fast as limits allow, all coordinates synchronised.

One profile, from 0 to 1, moves all coordinates, so each keeps its own limits and the tightest one
is met. It is a trapezium of the velocity, or with a limit of the jerk the double S of seven phases
(Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008, section
3.4).
"""

from math import sqrt
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from crane_sim.files.types import Positive, Real
from crane_sim.trajectories.line_arc import Coordinates, describe_size_mismatch
from crane_sim.trajectories.polynomials import (
    MIN_INTERVAL,
    Array,
    PiecewisePolynomial,
    with_rest_at_ends,
)

ARRIVED = 1e-9  # relative to the distance, which phases below the resolution of doubles may leave
# relative to the position or to 1: a displacement below it is what sums of decimal numbers round to
ROUNDING = 1e-12
Limits = Positive | Annotated[tuple[Positive, ...], Field(min_length=1)]
"""A limit of every coordinate, or of each one."""


class PointToPoint(NamedTuple):
    """A straight line within limits of velocity, acceleration and, if given, jerk."""

    begin: Coordinates  # coordinate's unit, position where the path begins
    end: Coordinates  # coordinate's unit, position where the path ends
    velocity: Limits  # coordinate's unit/s, limit of all, or of each
    acceleration: Limits  # coordinate's unit/s², likewise
    jerk: Limits | None = None  # coordinate's unit/s³, likewise; left out: none
    start: Real = 0.0  # s, time at which the motion begins

    def find_error(self) -> str:
        """Return one line on values that do not fit together, empty when all do."""
        limits = {name: getattr(self, name) for name in ("velocity", "acceleration", "jerk")}
        return describe_size_mismatch({"from": self.begin, "to": self.end} | limits)

    def to_polynomials(self) -> PiecewisePolynomial:
        """Return the motion; rest where both positions are the same up to rounding.

        Raises:
            ValueError: its limits leave it no time.
        """
        first = np.array(self.begin)
        displacement = np.array(self.end) - first
        if np.all(np.abs(displacement) <= ROUNDING * np.maximum(1.0, np.abs(first))):
            return with_rest_at_ends(
                self.start + np.array([0.0, MIN_INTERVAL]), first[None, :, None]
            )
        velocity, acceleration = (
            tightest(self.velocity, displacement),
            tightest(self.acceleration, displacement),
        )
        durations, jerks, accelerations = phases(
            velocity, acceleration, None if self.jerk is None else tightest(self.jerk, displacement)
        )
        times, profile = integrate_phases(durations, jerks, accelerations)
        coefficients = profile[:, None, :] * displacement[None, :, None]
        coefficients[:, :, 0] += first
        return with_rest_at_ends(self.start + times, coefficients)


def tightest(limits: float | tuple[float, ...], displacement: Array) -> float:
    """Return the limit of a profile from 0 to 1 for this displacement (n,) and all limits.

    Within it each coordinate keeps its own limit.
    """
    moves = displacement != 0.0
    return float(
        np.min(
            (
                np.broadcast_to(np.array(limits), displacement.shape)
                / np.where(moves, np.abs(displacement), 1.0)
            )[moves]
        )
    )


def phases(velocity: float, acceleration: float, jerk: float | None) -> tuple[Array, Array, Array]:
    """Return (durations [s], jerks, initial accelerations) of the seven phases from 0 to 1."""
    bend = 0.0 if jerk is None else acceleration / jerk  # time in which the acceleration rises
    rise = bend + velocity / acceleration  # time in which the velocity does
    if jerk is not None and velocity * jerk < acceleration**2:  # the velocity is reached first
        bend = sqrt(velocity / jerk)
        rise = 2.0 * bend
    cruise = 1.0 / velocity - rise
    if cruise < 0.0:
        cruise = 0.0
        bend = 0.0 if jerk is None else acceleration / jerk
        rise = 0.5 * bend + sqrt(0.25 * bend**2 + 1.0 / acceleration)
        if jerk is not None and rise < 2.0 * bend:  # nor is the acceleration reached
            bend = (0.5 / jerk) ** (1.0 / 3.0)
            rise = 2.0 * bend
    steepest = acceleration if jerk is None else jerk * bend
    durations = np.array([bend, rise - 2.0 * bend, bend, cruise, bend, rise - 2.0 * bend, bend])
    jerks = (0.0 if jerk is None else jerk) * np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])
    return durations, jerks, steepest * np.array([0.0, 1.0, 1.0, 0.0, 0.0, -1.0, -1.0])


def integrate_phases(durations: Array, jerks: Array, accelerations: Array) -> tuple[Array, Array]:
    """Return (times (K + 1,) [s], cubics (K, 4)) of the phases that last.

    The profile begins at 0, at rest.

    Raises:
        ValueError: no phase lasts, or one that matters does not.
    """
    times, rows, x, v = [0.0], [], 0.0, 0.0
    for span, j, a in zip(durations, jerks, accelerations, strict=True):
        if span < MIN_INTERVAL * 1e-3:
            continue
        rows.append([x, v, 0.5 * a, j / 6.0])
        x += span * (v + span * (0.5 * a + span * j / 6.0))
        v += span * (a + 0.5 * span * j)
        times.append(times[-1] + span)
    if not rows or times[-1] < MIN_INTERVAL or abs(x - 1.0) > ARRIVED:
        raise ValueError("limits so large that the motion, or a part of it, takes no time")
    return np.array(times), np.array(rows)
