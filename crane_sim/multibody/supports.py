"""Supports of cranes as trees of joints and bodies: what carries the upper end of the rope.

Each is declared by its masses and lengths, numbers or symbols; a literal 0 costs nothing. Positions are relative to
the link below; the origin is the base's, x ahead, y to the left, z up.
"""

from typing import Any, NamedTuple

from crane_sim.multibody.tree import Body, Joint, Point, Tree, X, Y, Z
from crane_sim.multibody.vectors import ZERO, Matrix


class Bar(NamedTuple):
    """A straight boom, jib or section, along its link's x axis."""

    mass: Any  # kg
    inertia: Any  # kg m², about a transverse axis through the centre of mass
    centre: Any  # m, of mass, from the link's origin
    axial_inertia: Any = None  # kg m², about the bar; None: it has inertia about its luffing axis alone


def diagonal(x: Any, y: Any, z: Any) -> Matrix:
    """Return the tensor of inertia [kg m²] of a body whose principal axes are the link's."""
    return (x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)


def bar_body(bar: Bar) -> Body:
    """Return a bar as a body of its link."""
    thin = bar.axial_inertia is None
    axial, vertical = (0.0, 0.0) if thin else (bar.axial_inertia, bar.inertia)
    return Body(bar.mass, (bar.centre, 0.0, 0.0), diagonal(axial, bar.inertia, vertical))


def slewing_body(inertia: Any) -> Body:
    """Return what turns about the vertical and moves nowhere: an inertia [kg m²] about it."""
    return Body(0.0, ZERO, diagonal(0.0, 0.0, inertia))


def knuckle_boom(tower: Any, boom: Bar, jib: Bar, lengths: tuple[Any, Any], motors: Any = (0.0, 0.0, 0.0)) -> Tree:
    """Return the knuckle boom: slew, elevation of the boom, elevation of the jib from the boom's line.

    Args:
        tower: inertia [kg m²] about the vertical.
        boom: between tower and jib.
        jib: whose end is the tip.
        lengths: of boom and jib [m].
        motors: inertias [kg m²] of the drives, at the joints' speeds.
    """
    return Tree(
        (
            Joint(Z, bodies=(slewing_body(tower),), rotor=motors[0]),
            Joint(Y, reverse=True, parent=0, bodies=(bar_body(boom),), rotor=motors[1]),
            Joint(Y, reverse=True, parent=1, offset=(lengths[0], 0.0, 0.0), bodies=(bar_body(jib),), rotor=motors[2]),
        ),
        Point(2, (lengths[1], 0.0, 0.0)),
    )


def telescopic_boom(superstructure: Any, foot: tuple[Any, Any], base: Bar, telescope: Bar) -> Tree:
    """Return the mobile crane's boom: slew, elevation, length.

    Args:
        superstructure: inertia [kg m²] about the vertical.
        foot: the boom's pin, ahead of the slewing axis and above the origin [m].
        base: the section that stays; its centre is measured from the pin.
        telescope: the section that moves out; its centre is measured from the tip, so it is negative.
    """
    return Tree(
        (
            Joint(Z, bodies=(slewing_body(superstructure),)),
            Joint(Y, reverse=True, parent=0, offset=(foot[0], 0.0, foot[1]), bodies=(bar_body(base),)),
            Joint(X, slides=True, parent=1, bodies=(bar_body(telescope),)),
        ),
        Point(2),
    )


def tower_crane(slew: Any, trolley: Any) -> Tree:
    """Return the hammerhead: slew of an inertia [kg m²], and a trolley of a mass [kg] on the jib."""
    return Tree(
        (
            Joint(Z, bodies=(slewing_body(slew),)),
            Joint(X, slides=True, parent=0, bodies=(Body(trolley),)),
        ),
        Point(1),
    )


def swaying_tower(masses: Any, places: Any, height: Any, trolley: Any) -> Tree:
    """Return the hammerhead on a mast that bends: angles of the mast about x and y, slew, trolley.

    Args:
        masses: of what slews [kg].
        places: of these masses along the jib, from the tower's axis [m].
        height: of the jib above the joint that the mast bends at [m].
        trolley: mass [kg].
    """
    slewing = tuple(Body(mass, (place, 0.0, 0.0)) for mass, place in zip(masses, places, strict=True))
    return Tree(
        (
            Joint(X, offset=(0.0, 0.0, -height)),
            Joint(Y, parent=0),
            Joint(Z, parent=1, offset=(0.0, 0.0, height), bodies=slewing),
            Joint(X, slides=True, parent=2, bodies=(Body(trolley),)),
        ),
        Point(3),
    )


def bridge(trolley: Any, girder: Any) -> Tree:
    """Return the bridge crane: the bridge along y, a mass [kg], and on it the trolley along x."""
    return Tree(
        (
            Joint(Y, slides=True, bodies=(Body(girder),)),
            Joint(X, slides=True, parent=0, bodies=(Body(trolley),)),
        ),
        Point(1),
    )
