"""The URDF of an overhead crane: a trolley below a rail along x, and a chain of links.

`world` has its origin on the rail's line, at the height of the cable's upper end. Link angles are absolute in the
model, while a URDF joint is relative to its parent: every link ends in a level frame, the node's, that turns back by
the link's angle.
"""

from __future__ import annotations

from math import atan2, hypot, pi
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description.envelope import Envelope, envelope
from crane_sim.description.robot import DOWN, FORWARD, RAISE, add_joint, add_link
from crane_sim.description.solids import (
    ACROSS,
    DARK,
    GREY,
    ORIGIN,
    STEEL,
    YELLOW,
    Shape,
    ball,
    crate,
    cube,
)
from crane_sim.supports.trolley import trolley_mass

if TYPE_CHECKING:
    from crane_sim.overhead import OverheadCrane
    from crane_sim.scene import Scene

MOST_LINKS = 20
SWING = (-pi, pi)


def describe(robot: ElementTree.Element, scene: Scene, crane: OverheadCrane) -> None:
    """Add links and joints; the fixed `rail` and the mimics `level_1`, `level_2` … come on top of the scene's joints.

    Beyond MOST_LINKS links the chain is left out: a hundred frames help nobody. The payload then floats in `world`
    (joint `cable`), drawn at rest below the trolley until somebody who knows its place, as the recording does, says so.
    """
    room = envelope(scene, crane)
    unit = room.reach / 6.0  # the proportions below are those of a 6 m cable
    add_link(robot, "base_link", _gantry(room, unit))
    add_joint(robot, "fixed", "rail", ("world", "base_link"))
    mass = trolley_mass(crane.trolley)
    add_link(robot, "trolley_link", _trolley(unit), cube(mass, 0.5 * unit) if mass > 0.0 else None)
    add_joint(robot, "prismatic", "trolley", ("base_link", "trolley_link"), axis=FORWARD, span=(room.left, room.right))
    if len(crane.cable.masses) <= MOST_LINKS:
        _chain(robot, scene, crane, unit)
    else:
        below = (scene.initial_q[0], 0.0, -room.reach)
        add_joint(robot, "floating", "cable", ("world", "payload_link"), below)
    edge = 0.55 * unit
    add_link(robot, "payload_link", crate(edge), cube(float(crane.cable.masses[-1]), edge))


def _chain(robot: ElementTree.Element, scene: Scene, crane: OverheadCrane, unit: float) -> None:
    lengths = [float(length) for length in crane.cable.lengths]
    radius = min(0.1 * unit, 0.3 * min(lengths))
    above = "trolley_link"
    for k, (length, mass) in enumerate(zip(lengths, crane.cable.masses, strict=True), start=1):
        link, end = f"link_{k}", "payload_link" if k == len(lengths) else f"node_{k}"
        ElementTree.SubElement(robot, "link", name=link)
        add_joint(robot, "revolute", f"swing_{k}", (above, link), axis=RAISE, span=SWING)
        if k == 1 and crane.hoist is not None:
            longest = 2.0 * envelope(scene, crane).reach
            add_joint(robot, "prismatic", "hoist", (link, end), axis=DOWN, span=(0.0, longest))
        else:
            add_joint(robot, "fixed", f"end_{k}", (link, end), (0.0, 0.0, -length))
        if k < len(lengths):
            add_link(robot, end, [Shape((radius,), ORIGIN, STEEL)], ball(float(mass), radius))
            above = f"level_{k}"
            ElementTree.SubElement(robot, "link", name=above)
            add_joint(robot, "revolute", f"level_{k}", (end, above), ORIGIN, RAISE, SWING, f"swing_{k}")


def _gantry(room: Envelope, unit: float) -> list[Shape]:
    """Return an I-beam on two trestles that the cable swings through."""
    middle, top = room.middle, 0.74 * unit
    shapes = [
        Shape((room.span, 0.36 * unit, 0.07 * unit), (middle, 0.0, 0.22 * unit), YELLOW),
        Shape((room.span, 0.1 * unit, 0.5 * unit), (middle, 0.0, 0.48 * unit), YELLOW),
        Shape((room.span, 0.36 * unit, 0.07 * unit), (middle, 0.0, top), YELLOW),
    ]
    for end in (room.left, room.right):
        shapes += _trestle(end, top, room.ground, unit)
    return shapes


def _trestle(x: float, top: float, ground: float, unit: float) -> list[Shape]:
    foot, head = 1.5 * unit, 0.25 * unit
    height, spread = top - ground, foot - head
    leg = (0.2 * unit, 0.2 * unit, hypot(height, spread))
    shapes = [Shape((0.24 * unit, 0.75 * unit, 0.7 * unit), (x, 0.0, 0.48 * unit), DARK)]
    for side in (1.0, -1.0):
        lean = (side * atan2(spread, height), 0.0, 0.0)
        shapes.append(Shape(leg, (x, side * 0.5 * (foot + head), 0.5 * (top + ground)), GREY, lean))
        shapes.append(Shape((0.5 * unit, 0.4 * unit, 0.1 * unit), (x, side * foot, ground + 0.05 * unit), DARK))
    return shapes


def _trolley(unit: float) -> list[Shape]:
    """Return two cheeks that embrace the beam's lower flange, four wheels on it, a sheave where the cable begins."""
    shapes = [Shape((0.13 * unit, 0.3 * unit), ORIGIN, STEEL, ACROSS)]
    for side in (1.0, -1.0):
        shapes.append(Shape((0.9 * unit, 0.05 * unit, 0.5 * unit), (0.0, side * 0.23 * unit, 0.2 * unit), DARK))
        for x in (0.28 * unit, -0.28 * unit):
            shapes.append(Shape((0.11 * unit, 0.09 * unit), (x, side * 0.13 * unit, 0.365 * unit), STEEL, ACROSS))
    return [*shapes, Shape((0.7 * unit, 0.5 * unit, 0.08 * unit), (0.0, 0.0, 0.1 * unit), DARK)]
