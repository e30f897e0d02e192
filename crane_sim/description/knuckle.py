"""The URDF of a knuckle-boom crane.

`world` has its origin at the boom pivot. Boom and jib angles are absolute elevations in the model, while a URDF joint
is relative to its parent. The level frames bridge the two: each follows an elevation with the multiplier -1, so that
what hangs on it starts horizontal again.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description.robot import DOWN, FORWARD, RAISE, UP, add_joint, add_link
from crane_sim.description.solids import ACROSS, DARK, GLASS, GREY, ORIGIN, STEEL, YELLOW, Body, Shape, crate, cube

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.model import Crane
    from crane_sim.supports.knuckle import Rod


def describe(robot: ElementTree.Element, crane: Crane, joints: Sequence[str]) -> None:
    """Add links and joints; the fixed `base` and the mimics `boom_level` and `jib_level` come on top of `joints`."""
    _links(robot, crane)
    _joints(robot, crane, joints)


def pedestal_height(crane: Crane) -> float:
    """Height of the boom pivot above the ground that is drawn [m]; the model itself knows no ground."""
    return 0.6 * crane.support.boom.length


def _links(robot: ElementTree.Element, crane: Crane) -> None:
    support, load = crane.support, crane.load
    unit = support.boom.length / 5.0  # the proportions below are those of a 5 m boom
    for name in ("boom_level_link", "jib_level_link", "swing_link", "rope_link"):
        ElementTree.SubElement(robot, "link", name=name)
    add_link(robot, "base_link", _pedestal(pedestal_height(crane), unit))
    radius = 0.6 * unit
    turning = support.tower.inertia
    tower = Body(2.0 * turning / radius**2, ORIGIN, (turning, turning, turning))  # a disc's mass for this inertia
    add_link(robot, "tower_link", _tower(unit), tower)
    add_link(robot, "boom_link", _beam(support.boom.length, 0.34 * unit), _rod(support.boom, 0.34 * unit))
    add_link(robot, "jib_link", _beam(support.jib.length, 0.24 * unit), _rod(support.jib, 0.24 * unit))
    edge = 0.55 * unit
    add_link(robot, "payload_link", crate(edge), cube(load.mass, edge))


def _joints(robot: ElementTree.Element, crane: Crane, joints: Sequence[str]) -> None:
    boom, jib = crane.support.boom.length, crane.support.jib.length
    slew, luff, fold, rope, tangential, radial = joints
    turn, swing = (-pi, pi), (-0.5 * pi, 0.5 * pi)
    add_joint(robot, "fixed", "base", ("world", "base_link"))
    add_joint(robot, "continuous", slew, ("base_link", "tower_link"), axis=UP)
    add_joint(robot, "revolute", luff, ("tower_link", "boom_link"), axis=RAISE, span=turn)
    add_joint(robot, "revolute", "boom_level", ("boom_link", "boom_level_link"), (boom, 0.0, 0.0), RAISE, turn, luff)
    add_joint(robot, "revolute", fold, ("boom_level_link", "jib_link"), axis=RAISE, span=turn)
    add_joint(robot, "revolute", "jib_level", ("jib_link", "jib_level_link"), (jib, 0.0, 0.0), RAISE, turn, fold)
    add_joint(robot, "revolute", tangential, ("jib_level_link", "swing_link"), axis=FORWARD, span=swing)
    add_joint(robot, "revolute", radial, ("swing_link", "rope_link"), axis=RAISE, span=swing)
    reach = 2.0 * (boom + jib)
    add_joint(robot, "prismatic", rope, ("rope_link", "payload_link"), axis=DOWN, span=(0.0, reach))


def _rod(rod: Rod, width: float) -> Body:
    axial = rod.mass * width**2 / 6.0 if rod.axial_inertia is None else rod.axial_inertia
    return Body(rod.mass, (0.5 * rod.length, 0.0, 0.0), (axial, rod.inertia, rod.inertia))


def _pedestal(height: float, unit: float) -> list[Shape]:
    top = 0.55 * unit
    column = height - top
    return [
        Shape((0.42 * unit, column), (0.0, 0.0, -top - 0.5 * column), GREY),
        Shape((0.62 * unit, 0.16 * unit), (0.0, 0.0, -top - 0.08 * unit), DARK),
        Shape((0.95 * unit, 0.2 * unit), (0.0, 0.0, 0.1 * unit - height), DARK),
    ]


def _tower(unit: float) -> list[Shape]:
    cheek = (0.55 * unit, 0.08 * unit, 0.8 * unit)
    return [
        Shape((0.6 * unit, 0.14 * unit), (0.0, 0.0, -0.47 * unit), YELLOW),
        Shape(cheek, (0.0, 0.27 * unit, -0.12 * unit), YELLOW),
        Shape(cheek, (0.0, -0.27 * unit, -0.12 * unit), YELLOW),
        Shape((0.11 * unit, 0.74 * unit), ORIGIN, STEEL, ACROSS),
        Shape((0.75 * unit, 1.0 * unit, 0.55 * unit), (-0.68 * unit, 0.0, -0.13 * unit), DARK),
        Shape((0.5 * unit, 0.4 * unit, 0.62 * unit), (0.12 * unit, 0.56 * unit, -0.09 * unit), GLASS),
    ]


def _beam(length: float, width: float) -> list[Shape]:
    root = 0.45 * length
    return [
        Shape((root, width, 1.25 * width), (0.5 * root, 0.0, 0.0), YELLOW),
        Shape((length - root, 0.75 * width, 0.9 * width), (0.5 * (length + root), 0.0, 0.0), YELLOW),
        Shape((0.1 * width, 1.05 * width, 1.3 * width), (root, 0.0, 0.0), DARK),
        Shape((0.55 * width, 1.15 * width), (length, 0.0, 0.0), STEEL, ACROSS),
    ]
