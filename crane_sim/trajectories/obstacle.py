"""The shortest path around a circular obstacle at a clearance, smoothed to minimum jerk.

The path goes straight to the circle of radius + clearance, along it, and straight on to the end.
The spline through the waypoints cuts the corners a little, so the circle is enlarged until the
whole motion keeps the clearance. Where that does not succeed, as beside a short arc (the spline
overshoots there, the more the larger the circle) or near an end (which no circle may enclose), the
waypoints are taken closer together.
"""

from math import acos, atan2, ceil, hypot, inf, log2, pi, tau
from typing import Literal, NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.numerics import libm
from crane_sim.trajectories.line_arc import Duration, describe_size_mismatch
from crane_sim.trajectories.minimum_jerk import LIMITED, minimum_jerk_spline, shortest_duration
from crane_sim.trajectories.point_to_point import Limits
from crane_sim.trajectories.polynomials import (
    Array,
    PiecewisePolynomial,
    check_durations,
    differentiate,
)

Position = tuple[Real, Real]
Side = Literal["left", "right", "shorter"]
STEP = pi / 6.0  # rad, of the arc between two waypoints, unless they are taken closer together
TRIES = 40  # of circles
REFINEMENTS = 4  # of waypoints, each twice as close together as the one before
# radii, between waypoints: the spline through closer ones has pieces that hardly take time
MIN_GAP = 1e-3
ROUNDING = 1e-12  # of a distance, relative: an end may be on the circle


class ObstacleDetour(NamedTuple):
    """A path in the plane from one position to another, around a circular obstacle."""

    begin: Position  # m, x and y where the path begins
    end: Position  # m, x and y where the path ends
    centre: Position  # m, of the obstacle
    radius: Positive  # m, of the obstacle
    clearance: NonNegative  # m, least distance between the obstacle and the path
    duration: Duration | None = None  # s, or limits, one of both
    velocity: Limits | None = None  # m/s, limit of both, or of each
    acceleration: Limits | None = None  # m/s², likewise
    jerk: Limits | None = None  # m/s³, likewise
    start: Real = 0.0  # s, time at which the motion begins
    side: Side = "shorter"  # on which side the path passes the obstacle

    def find_error(self) -> str:
        """Return one line on values that do not fit together, empty when all do."""
        limits = {name: getattr(self, name) for name in LIMITED if getattr(self, name) is not None}
        if bool(limits) == (self.duration is not None):
            return "needs one of both: duration, or limits velocity, acceleration, jerk"
        min_radius = self.radius + self.clearance
        for name, position in (("from", self.begin), ("to", self.end)):
            distance = hypot(position[0] - self.centre[0], position[1] - self.centre[1])
            if distance < min_radius:
                return (
                    f"{name} is {distance:.4g} m from the centre, within radius + clearance = "
                    f"{min_radius:.4g} m"
                )
        if self.begin == self.end:
            return "from and to are the same place"
        return describe_size_mismatch({"from": self.begin} | limits)

    def to_polynomials(self) -> PiecewisePolynomial:
        """Return the motion.

        Raises:
            ValueError: no path was found that keeps the clearance, or the limits give too short a
                duration.
        """
        points, fractions = self.waypoints()
        limits = (self.velocity, self.acceleration, self.jerk)
        total = (
            self.duration
            if self.duration is not None
            else shortest_duration(minimum_jerk_spline(points, fractions), limits)
        )
        given = f"duration = {total:g} at start = {self.start:g}: so short"
        cause = "limits so large" if self.duration is None else given
        return minimum_jerk_spline(points, check_durations(self.start + total * fractions, cause))

    def waypoints(self) -> tuple[Array, Array]:
        """Return (waypoints (K, 2) [m], fractions (K,) of the path length, from 0 to 1).

        Raises:
            ValueError: no path was found that keeps the clearance.
        """
        for refinement in range(REFINEMENTS):
            found = self._enlarge_circle(refinement)
            if found is not None:
                return found
        remedy = "take less of it, or from and to farther from the obstacle"
        raise ValueError(f"no path was found that keeps clearance = {self.clearance:g} m: {remedy}")

    def _enlarge_circle(self, refinement: int) -> tuple[Array, Array] | None:
        """Return `waypoints` at one spacing, or None where no circle keeps the clearance."""
        radius = min_radius = self.radius + self.clearance
        begin, end, centre = (
            np.array(position) for position in (self.begin, self.end, self.centre)
        )
        largest = min(float(np.linalg.norm(position - centre)) for position in (begin, end))
        for _ in range(TRIES):
            points = detour_waypoints(begin, end, centre, radius, self.side, refinement)
            distances = np.linalg.norm(np.diff(points, axis=0), axis=1)
            fractions = np.concatenate([[0.0], np.cumsum(distances) / np.sum(distances)])
            nearest = min_distance(minimum_jerk_spline(points, fractions), centre)
            if nearest >= min_radius * (1.0 - ROUNDING):
                return points, fractions
            if radius >= largest:
                return None
            radius = min(radius + 1.05 * (min_radius - nearest), largest)
        return None


def min_distance(polynomials: PiecewisePolynomial, centre: Array) -> float:
    """Return the smallest distance [m] of a plane motion from a position, exactly.

    It is at the ends or extrema of pieces.

    The first and the last piece are rest.
    """
    nearest = inf
    for coefficients, span in zip(
        polynomials.coefficients[1:-1], np.diff(polynomials.starts)[1:], strict=True
    ):
        x, y = coefficients - np.eye(1, coefficients.shape[1]) * centre[:, None]
        square = np.convolve(x, x) + np.convolve(y, y)
        turning = np.roots(differentiate(square)[::-1]).real  # those that are not real do no harm
        at = np.clip([0.0, span, *turning], 0.0, span)
        nearest = min(
            nearest, float(np.min(np.hypot(np.polyval(x[::-1], at), np.polyval(y[::-1], at))))
        )
    return nearest


def detour_waypoints(
    begin: Array, end: Array, centre: Array, radius: float, side: Side, refinement: int
) -> Array:
    """Return the waypoints (K, 2) [m] of the shortest path that passes a circle on the given side.

    A path that passes on the `left` has the obstacle on its right, so it goes around it clockwise.
    Refinement 0 has waypoints on the circle and at the ends alone, n those of `straight_waypoints`
    as well, from STEP / 2^n on.
    """
    waypoints, shortest = np.array([begin, end]), inf
    chord = end - begin
    along = np.dot(centre - begin, chord) / np.dot(chord, chord)
    is_free = np.linalg.norm(begin + np.clip(along, 0.0, 1.0) * chord - centre) >= radius
    if is_free and (
        side == "shorter" or not 0.0 < along < 1.0 or _passes_on(side, chord, centre - begin)
    ):
        return waypoints
    step = STEP / 2**refinement
    for direction in (-1.0, 1.0) if side == "shorter" else (-1.0,) if side == "left" else (1.0,):
        arc = arc_waypoints(begin - centre, end - centre, radius, direction, step) + centre
        first = step * radius if refinement else inf
        before, after = (
            straight_waypoints(*line, first) for line in ((arc[0], begin), (arc[-1], end))
        )
        points = drop_close([begin, *before[::-1], *arc, *after, end], MIN_GAP * radius)
        length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        if length < shortest:
            waypoints, shortest = points, length
    return waypoints


def straight_waypoints(begin: Array, end: Array, first: float) -> Array:
    """Return waypoints (K, 2) [m] between two positions, at steps that double.

    The first step is about `first` [m] long.
    """
    steps = max(1, round(log2(1.0 + float(np.linalg.norm(end - begin)) / first)))
    fractions = (2.0 ** np.arange(1, steps) - 1.0) / (2.0**steps - 1.0)
    return begin + fractions[:, None] * (end - begin)


def drop_close(points: list[Array], gap: float) -> Array:
    """Return the positions (K, 2) [m] without inner ones within `gap` [m] of their neighbours."""
    kept, end = points[:1], points[-1]
    for point in points[1:-1]:
        if min(np.linalg.norm(point - kept[-1]), np.linalg.norm(end - point)) > gap:
            kept.append(point)
    return np.array([*kept, end])


def _passes_on(side: Side, chord: Array, centre: Array) -> bool:
    """Return whether a chord from the origin passes the centre on the given side.

    A chord that passes on the left has the centre on its right, and vice versa.
    """
    is_left_of_chord = chord[0] * centre[1] - chord[1] * centre[0] > 0.0
    return is_left_of_chord == (side == "right")


def arc_waypoints(begin: Array, end: Array, radius: float, direction: float, step: float) -> Array:
    """Return waypoints (K, 2) on the circle about the origin, where the path follows it.

    The path meets the circle at the first one and leaves it at the last one.

    Args:
        begin, end: m, outside the circle or on it.
        radius: m.
        direction: 1 for a path that goes around the origin counterclockwise, -1 for clockwise.
        step: rad, between two waypoints at most.
    """
    first, last = (direction * atan2(position[1], position[0]) for position in (begin, end))
    tangents = [acos(min(1.0, radius / hypot(*position))) for position in (begin, end)]
    first, last = first + tangents[0], last - tangents[1]
    swept = (last - first) % tau
    count = max(1, ceil(swept / step))
    angles = direction * (first + swept * np.arange(count + 1) / count)
    return radius * np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
