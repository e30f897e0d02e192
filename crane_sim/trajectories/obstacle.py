"""Around a round obstacle: the shortest way that keeps its distance, smoothed to minimum jerk.

The way goes straight to the circle of the obstacle and its clearance, along it, and straight on. The spline through
its corners cuts them a little, so the circle is widened until the whole motion keeps the clearance.
"""

from math import acos, atan2, ceil, hypot, inf, pi, tau
from typing import Literal, NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.trajectories.line_arc import Duration, unequal
from crane_sim.trajectories.minimum_jerk import LIMITED, shortest, through
from crane_sim.trajectories.point_to_point import Limits
from crane_sim.trajectories.polynomials import Array, Pieces, lasting, values

Place = tuple[Real, Real]
Side = Literal["left", "right", "shorter"]
STEP = pi / 6.0  # rad, of the arc between two waypoints
TRIES = 40
PIECE_SAMPLES = 50  # instants in every piece at which the distance is measured


class Obstacle(NamedTuple):
    """From one place to another in the plane, around a circle."""

    begin: Place  # m, x and y
    end: Place  # m, x and y
    centre: Place  # m, of the obstacle
    radius: Positive  # m, of the obstacle
    clearance: NonNegative  # m, left between the obstacle and the path
    duration: Duration | None = None  # s, or limits, one of both
    velocity: Limits | None = None  # m/s, limit of both, or of each
    acceleration: Limits | None = None  # m/s², likewise
    jerk: Limits | None = None  # m/s³, likewise
    start: Real = 0.0  # s, when it begins
    side: Side = "shorter"  # of the obstacle on which the path passes it

    def complaint(self) -> str:
        """Return what is wrong as a whole, in one line; empty when nothing is."""
        limits = {name: getattr(self, name) for name in LIMITED if getattr(self, name) is not None}
        if bool(limits) == (self.duration is not None):
            return "needs one of both: duration, or limits velocity, acceleration, jerk"
        room = self.radius + self.clearance
        for name, place in (("from", self.begin), ("to", self.end)):
            distance = hypot(place[0] - self.centre[0], place[1] - self.centre[1])
            if distance < room:
                return f"{name} is {distance:.4g} m from the centre, within radius + clearance = {room:.4g} m"
        if self.begin == self.end:
            return "from and to are the same place"
        return unequal({"from": self.begin} | limits)

    def pieces(self) -> Pieces:
        """Return the motion.

        Raises:
            ValueError: no circle about the obstacle was found around which the motion keeps the clearance, or its
                limits leave it no time.
        """
        points, pace = self.waypoints()
        limits = (self.velocity, self.acceleration, self.jerk)
        whole = self.duration if self.duration is not None else shortest(through(points, pace), limits)
        return through(points, lasting(self.start + whole * pace))

    def waypoints(self) -> tuple[Array, Array]:
        """Return (waypoints (K, 2) [m], the parts (K,) of the way at which they stand, from 0 to 1)."""
        room = self.radius + self.clearance
        places = (np.array(place) for place in (self.begin, self.end, self.centre))
        begin, end, centre = places
        wide = room
        for _ in range(TRIES):
            points = around(begin, end, centre, wide, self.side)
            ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
            pace = np.concatenate([[0.0], np.cumsum(ways) / np.sum(ways)])
            nearest = distance(through(points, pace), centre)
            if nearest >= room:
                return points, pace
            wide = min(wide + 1.05 * (room - nearest), *(float(np.linalg.norm(p - centre)) for p in (begin, end)))
        raise ValueError(f"no way around keeps {self.clearance:g} m of clearance: the places are too near")


def distance(pieces: Pieces, centre: Array) -> float:
    """Return the smallest distance [m] of a motion in the plane from a place."""
    steps = np.arange(PIECE_SAMPLES) / PIECE_SAMPLES
    spans = np.diff(pieces.starts)[:, None]
    t = (pieces.starts[:-1, None] + spans * steps).ravel()
    return float(np.min(np.linalg.norm(values(pieces, t) - centre, axis=1)))


def around(begin: Array, end: Array, centre: Array, radius: float, side: Side) -> Array:
    """Return the waypoints (K, 2) [m] of the shortest way about a circle, which passes it on its left or right.

    `left` leaves the obstacle on the right, so the way turns about it clockwise.
    """
    waypoints, shortest_way = np.array([begin, end]), inf
    way = end - begin
    nearest = np.clip(np.dot(centre - begin, way) / np.dot(way, way), 0.0, 1.0)
    if np.linalg.norm(begin + nearest * way - centre) >= radius:
        return waypoints
    for turn in (-1.0, 1.0) if side == "shorter" else (-1.0,) if side == "left" else (1.0,):
        points = np.array([begin, *on_circle(begin - centre, end - centre, radius, turn) + centre, end])
        points = points[np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9 * radius])]
        length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        if length < shortest_way:
            waypoints, shortest_way = points, length
    return waypoints


def on_circle(begin: Array, end: Array, radius: float, turn: float) -> Array:
    """Return waypoints (K, 2) on the circle about the origin, from where the way meets it to where it leaves it.

    Args:
        begin, end: m, outside the circle or on it.
        radius: m.
        turn: 1 for a way that goes about the origin counterclockwise, -1 for the other.
    """
    first, last = (turn * atan2(place[1], place[0]) for place in (begin, end))
    reach = [acos(min(1.0, radius / hypot(*place))) for place in (begin, end)]
    first, last = first + reach[0], last - reach[1]
    swept = (last - first) % tau
    count = max(1, ceil(swept / STEP))
    angles = turn * (first + swept * np.arange(count + 1) / count)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
