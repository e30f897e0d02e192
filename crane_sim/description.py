"""The URDF of a crane: what robot_state_publisher, RViz and the recording draw.

Frames follow REP-103: x forward, y left, z up, SI units and radians. `world` has its origin at the boom pivot. Boom
and jib angles are absolute elevations in the model, while a URDF joint is relative to its parent. The level frames
bridge the two: each follows an elevation with the multiplier -1, so that what hangs on it starts horizontal again.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.scene import Scene
    from crane_sim.supports.knuckle import Rod

Vector = tuple[float, float, float]
ORIGIN: Vector = (0.0, 0.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)
RAISE: Vector = (0.0, -1.0, 0.0)  # a positive turn about it lifts the x axis
ACROSS: Vector = (pi / 2, 0.0, 0.0)  # roll, pitch, yaw that lay a cylinder along y

YELLOW = "0.95 0.66 0.08 1"
DARK = "0.20 0.23 0.27 1"
GREY = "0.46 0.50 0.55 1"
STEEL = "0.72 0.75 0.78 1"
RED = "0.80 0.22 0.14 1"
GLASS = "0.35 0.60 0.75 1"


class Shape(NamedTuple):
    """A solid of one colour: a box of three edge lengths, or a cylinder of radius and length along its z [m]."""

    size: Sequence[float]
    at: Vector
    color: str
    rpy: Vector = ORIGIN


class Body(NamedTuple):
    """Mass [kg], centre of mass [m] and principal inertias about it [kg m²], all in the link's frame."""

    mass: float
    center: Vector
    inertia: Vector


def urdf(scene: Scene) -> str:
    """Describe a knuckle-boom crane as a URDF document.

    The joints are `scene.joint_names`; the fixed `base` and the mimics `boom_level` and `jib_level` come on top.

    Raises:
        ValueError: the scene's crane is of another kind.
    """
    if scene.crane != "knuckle":
        raise ValueError(f"crane {scene.crane!r} has no URDF; possible: 'knuckle'")
    robot = ElementTree.Element("robot", name=f"{scene.crane}_crane")
    _links(robot, scene)
    _joints(robot, scene)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True)


def pedestal_height(scene: Scene) -> float:
    """Height of the boom pivot above the ground that is drawn [m]; the model itself knows no ground."""
    return 0.6 * scene.model.support.boom.length


def _links(robot: ElementTree.Element, scene: Scene) -> None:
    support, load = scene.model.support, scene.model.load
    unit = support.boom.length / 5.0  # the proportions below are those of a 5 m boom
    for name in ("world", "boom_level_link", "jib_level_link", "swing_link", "rope_link"):
        ElementTree.SubElement(robot, "link", name=name)
    _link(robot, "base_link", _pedestal(pedestal_height(scene), unit))
    radius = 0.6 * unit
    turning = support.tower.inertia
    tower = Body(2.0 * turning / radius**2, ORIGIN, (turning, turning, turning))  # a disc's mass for this inertia
    _link(robot, "tower_link", _tower(unit), tower)
    _link(robot, "boom_link", _beam(support.boom.length, 0.34 * unit), _rod(support.boom, 0.34 * unit))
    _link(robot, "jib_link", _beam(support.jib.length, 0.24 * unit), _rod(support.jib, 0.24 * unit))
    edge = 0.55 * unit
    cube = load.mass * edge**2 / 6.0
    _link(robot, "payload_link", _crate(edge), Body(load.mass, ORIGIN, (cube, cube, cube)))


def _joints(robot: ElementTree.Element, scene: Scene) -> None:
    boom, jib = scene.model.support.boom.length, scene.model.support.jib.length
    slew, luff, fold, rope, tangential, radial = scene.joint_names
    turn, swing = (-pi, pi), (-0.5 * pi, 0.5 * pi)
    _joint(robot, "fixed", "base", ("world", "base_link"))
    _joint(robot, "continuous", slew, ("base_link", "tower_link"), axis=UP)
    _joint(robot, "revolute", luff, ("tower_link", "boom_link"), axis=RAISE, span=turn)
    _joint(robot, "revolute", "boom_level", ("boom_link", "boom_level_link"), (boom, 0.0, 0.0), RAISE, turn, luff)
    _joint(robot, "revolute", fold, ("boom_level_link", "jib_link"), axis=RAISE, span=turn)
    _joint(robot, "revolute", "jib_level", ("jib_link", "jib_level_link"), (jib, 0.0, 0.0), RAISE, turn, fold)
    _joint(robot, "revolute", tangential, ("jib_level_link", "swing_link"), axis=(1.0, 0.0, 0.0), span=swing)
    _joint(robot, "revolute", radial, ("swing_link", "rope_link"), axis=RAISE, span=swing)
    reach = 2.0 * (boom + jib)
    _joint(robot, "prismatic", rope, ("rope_link", "payload_link"), axis=(0.0, 0.0, -1.0), span=(0.0, reach))


def _joint(
    robot: ElementTree.Element,
    kind: str,
    name: str,
    links: tuple[str, str],
    at: Vector = ORIGIN,
    axis: Vector | None = None,
    span: tuple[float, float] | None = None,
    follows: str | None = None,
) -> None:
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=links[0])
    ElementTree.SubElement(joint, "child", link=links[1])
    ElementTree.SubElement(joint, "origin", xyz=_text(at), rpy=_text(ORIGIN))
    if axis is not None:
        ElementTree.SubElement(joint, "axis", xyz=_text(axis))
    if span is not None:  # the format wants an effort and a rate too; these only keep a GUI slider tame
        limit = {"lower": span[0], "upper": span[1], "effort": 1.0e4, "velocity": 10.0}
        ElementTree.SubElement(joint, "limit", {key: _text((value,)) for key, value in limit.items()})
    if follows is not None:
        ElementTree.SubElement(joint, "mimic", joint=follows, multiplier="-1", offset="0")


def _link(robot: ElementTree.Element, name: str, shapes: Sequence[Shape], body: Body | None = None) -> None:
    link = ElementTree.SubElement(robot, "link", name=name)
    if body is not None:
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "origin", xyz=_text(body.center), rpy=_text(ORIGIN))
        ElementTree.SubElement(inertial, "mass", value=_text((body.mass,)))
        moments = dict(zip(("ixx", "iyy", "izz"), (_text((value,)) for value in body.inertia), strict=True))
        ElementTree.SubElement(inertial, "inertia", moments | {"ixy": "0", "ixz": "0", "iyz": "0"})
    for number, shape in enumerate(shapes):
        visual = ElementTree.SubElement(link, "visual", name=f"{name}_{number}")
        ElementTree.SubElement(visual, "origin", xyz=_text(shape.at), rpy=_text(shape.rpy))
        geometry = ElementTree.SubElement(visual, "geometry")
        if len(shape.size) == 3:
            ElementTree.SubElement(geometry, "box", size=_text(shape.size))
        else:
            radius, length = shape.size
            ElementTree.SubElement(geometry, "cylinder", radius=_text((radius,)), length=_text((length,)))
        material = ElementTree.SubElement(visual, "material", name=f"{name}_{number}")
        ElementTree.SubElement(material, "color", rgba=shape.color)


def _text(numbers: Sequence[float]) -> str:
    return " ".join(f"{number:.9g}" for number in numbers)


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


def _crate(edge: float) -> list[Shape]:
    band = (1.02 * edge, 1.02 * edge, 0.12 * edge)
    return [
        Shape((edge, edge, edge), ORIGIN, RED),
        Shape(band, (0.0, 0.0, 0.36 * edge), DARK),
        Shape(band, (0.0, 0.0, -0.36 * edge), DARK),
        Shape((0.16 * edge, 0.3 * edge), (0.0, 0.0, 0.6 * edge), STEEL),
    ]
