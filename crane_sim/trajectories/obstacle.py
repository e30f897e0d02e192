"""The shortest path around a circular obstacle at a clearance, smoothed to minimum jerk.

The path goes straight to the circle of radius + clearance, along it, and straight on to the end. The spline through the
waypoints cuts the corners a little, so the circle is enlarged until the whole motion keeps the clearance.
"""

from math import acos, atan2, ceil, hypot, inf, pi, tau
from typing import Literal, NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.numerics import libm
from crane_sim.trajectories.line_arc import Duration, describe_size_mismatch
from crane_sim.trajectories.minimum_jerk import LIMITED, minimum_jerk_spline, shortest_duration
from crane_sim.trajectories.point_to_point import Limits
from crane_sim.trajectories.polynomials import Array, PiecewisePolynomial, check_durations, evaluate

Position = tuple[Real, Real]
Side = Literal["left", "right", "shorter"]
STEP = pi / 6.0  # rad, of the arc between two waypoints
TRIES = 40
PIECE_SAMPLES = 50  # instants in every piece at which the distance is measured


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
                return f"{name} is {distance:.4g} m from the centre, within radius + clearance = {min_radius:.4g} m"
        if self.begin == self.end:
            return "from and to are the same place"
        return describe_size_mismatch({"from": self.begin} | limits)

    def to_polynomials(self) -> PiecewisePolynomial:
        """Return the motion.

        Raises:
            ValueError: no path was found that keeps the clearance, or the limits give too short a duration.
        """
        points, fractions = self.waypoints()
        limits = (self.velocity, self.acceleration, self.jerk)
        total = (
            self.duration
            if self.duration is not None
            else shortest_duration(minimum_jerk_spline(points, fractions), limits)
        )
        return minimum_jerk_spline(points, check_durations(self.start + total * fractions))

    def waypoints(self) -> tuple[Array, Array]:
        """Return (waypoints (K, 2) [m], fractions (K,) of the path length, from 0 to 1)."""
        min_radius = self.radius + self.clearance
        begin, end, centre = (np.array(position) for position in (self.begin, self.end, self.centre))
        radius = min_radius
        for _ in range(TRIES):
            points = detour_waypoints(begin, end, centre, radius, self.side)
            distances = np.linalg.norm(np.diff(points, axis=0), axis=1)
            fractions = np.concatenate([[0.0], np.cumsum(distances) / np.sum(distances)])
            nearest = min_distance(minimum_jerk_spline(points, fractions), centre)
            if nearest >= min_radius:
                return points, fractions
            radius = min(
                radius + 1.05 * (min_radius - nearest), *(float(np.linalg.norm(p - centre)) for p in (begin, end))
            )
        raise ValueError(f"no path keeps {self.clearance:g} m of clearance: from or to is too near")


def min_distance(polynomials: PiecewisePolynomial, centre: Array) -> float:
    """Return the smallest distance [m] of a motion in the plane from a position."""
    steps = np.arange(PIECE_SAMPLES) / PIECE_SAMPLES
    durations = np.diff(polynomials.starts)[:, None]
    t = (polynomials.starts[:-1, None] + durations * steps).ravel()
    return float(np.min(np.linalg.norm(evaluate(polynomials, t) - centre, axis=1)))


def detour_waypoints(begin: Array, end: Array, centre: Array, radius: float, side: Side) -> Array:
    """Return the waypoints (K, 2) [m] of the shortest path that passes a circle on the given side.

    A path that passes on the `left` has the obstacle on its right, so it goes around it clockwise.
    """
    waypoints, shortest = np.array([begin, end]), inf
    chord = end - begin
    along = np.dot(centre - begin, chord) / np.dot(chord, chord)
    is_free = np.linalg.norm(begin + np.clip(along, 0.0, 1.0) * chord - centre) >= radius
    if is_free and (side == "shorter" or not 0.0 < along < 1.0 or _passes_on(side, chord, centre - begin)):
        return waypoints
    for direction in (-1.0, 1.0) if side == "shorter" else (-1.0,) if side == "left" else (1.0,):
        points = np.array([begin, *arc_waypoints(begin - centre, end - centre, radius, direction) + centre, end])
        points = points[np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9 * radius])]
        length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        if length < shortest:
            waypoints, shortest = points, length
    return waypoints


def _passes_on(side: Side, chord: Array, centre: Array) -> bool:
    """Return whether a chord from the origin has a centre on its right, where it passes on the left, or vice versa."""
    is_left_of_chord = chord[0] * centre[1] - chord[1] * centre[0] > 0.0
    return is_left_of_chord == (side == "right")


def arc_waypoints(begin: Array, end: Array, radius: float, direction: float) -> Array:
    """Return waypoints (K, 2) on the circle about the origin, from where the path meets it to where it leaves it.

    Args:
        begin, end: m, outside the circle or on it.
        radius: m.
        direction: 1 for a path that goes around the origin counterclockwise, -1 for clockwise.
    """
    first, last = (direction * atan2(position[1], position[0]) for position in (begin, end))
    tangents = [acos(min(1.0, radius / hypot(*position))) for position in (begin, end)]
    first, last = first + tangents[0], last - tangents[1]
    swept = (last - first) % tau
    count = max(1, ceil(swept / STEP))
    angles = direction * (first + swept * np.arange(count + 1) / count)
    return radius * np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
