"""The solids that cranes are drawn with, and their colours."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, pi
from typing import NamedTuple

Vector = tuple[float, float, float]
ORIGIN: Vector = (0.0, 0.0, 0.0)
# roll, pitch, yaw of a cylinder, by default along z, along y
RPY_ALONG_Y: Vector = (pi / 2, 0.0, 0.0)

YELLOW = "0.95 0.66 0.08 1"
DARK = "0.20 0.23 0.27 1"
GREY = "0.46 0.50 0.55 1"
STEEL = "0.72 0.75 0.78 1"
RED = "0.80 0.22 0.14 1"
GLASS = "0.35 0.60 0.75 1"


class Shape(NamedTuple):
    """A solid of one colour, in the frame of its link.

    Its size gives its kind: three edge lengths of a box, radius and length of a cylinder along z,
    radius of a sphere.
    """

    size: Sequence[float]  # m
    at: Vector  # m, of its centre
    color: str
    rpy: Vector = ORIGIN  # rad, roll, pitch, yaw


class Body(NamedTuple):
    """Mass, centre of mass and inertia tensor about it of a link, in the axes of its frame."""

    mass: float  # kg
    centre: Vector  # m
    inertia: Vector  # kg m², entries xx, yy, zz of the tensor
    products: Vector = (0.0, 0.0, 0.0)  # kg m², entries xy, xz, yz of the tensor


def tube(start: Sequence[float], end: Sequence[float], radius: float, color: str) -> Shape:
    """Return a solid cylinder, drawn for a tube, between points (x, z) [m] of the luffing plane."""
    along = end[0] - start[0], end[1] - start[1]
    middle = (0.5 * (start[0] + end[0]), 0.0, 0.5 * (start[1] + end[1]))
    return Shape((radius, hypot(*along)), middle, color, (0.0, atan2(*along), 0.0))


def hydraulic_cylinder(
    foot: Sequence[float], rod_end: Sequence[float], radius: float
) -> list[Shape]:
    """Return barrel and rod from foot to rod end (x, z) [m], which are drawn, not simulated."""
    barrel_end = tuple(a + 0.6 * (b - a) for a, b in zip(foot, rod_end, strict=True))
    return [tube(foot, barrel_end, radius, DARK), tube(barrel_end, rod_end, 0.55 * radius, STEEL)]


def payload_box(edge: float) -> list[Shape]:
    """Return a payload: a box, centred in the origin, with two bands and an eye on its lid."""
    band = (1.02 * edge, 1.02 * edge, 0.12 * edge)
    return [
        Shape((edge, edge, edge), ORIGIN, RED),
        Shape(band, (0.0, 0.0, 0.36 * edge), DARK),
        Shape(band, (0.0, 0.0, -0.36 * edge), DARK),
        Shape((0.16 * edge, 0.3 * edge), (0.0, 0.0, 0.6 * edge), STEEL),
    ]


def point_mass(mass: float) -> Body:
    """Return a mass [kg] without inertia in its link's origin: payload, chain node or trolley."""
    return Body(mass, ORIGIN, ORIGIN)
