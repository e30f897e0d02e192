"""Elements of a URDF document: links with visuals and inertias, and the joints between them."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description.solids import ORIGIN

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.description.solids import Body, Shape, Vector

UP: Vector = (0.0, 0.0, 1.0)
DOWN: Vector = (0.0, 0.0, -1.0)
FORWARD: Vector = (1.0, 0.0, 0.0)
LEFT: Vector = (0.0, 1.0, 0.0)
RIGHT: Vector = (0.0, -1.0, 0.0)  # a positive turn about it lifts the x axis
MOMENTS, PRODUCTS = ("ixx", "iyy", "izz"), ("ixy", "ixz", "iyz")
UNBOUNDED = 1e12
"""Stands for no limit [m, rad, rad/s, N, ...]: the format takes no infinity, and no scene file a larger number."""


def add_joint(
    robot: ElementTree.Element,
    kind: str,
    name: str,
    links: tuple[str, str],
    at: Vector = ORIGIN,
    axis: Vector | None = None,
    limits: tuple[float, float] | None = None,
    mimic: str | None = None,
    multiplier: float = -1.0,
) -> None:
    """Add a joint between links (parent, child), placed `at` in the parent's frame [m].

    Args:
        robot: the document.
        kind: joint type of the URDF.
        name: of the joint.
        links: names of parent and child.
        at: origin of the joint.
        axis: unit vector in the child's frame.
        limits: lower and upper limit [rad or m] that follow from the geometry; module `limits` adds those of the scene.
        mimic: the joint that this one mimics.
        multiplier: of the mimicked position.
    """
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=links[0])
    ElementTree.SubElement(joint, "child", link=links[1])
    ElementTree.SubElement(joint, "origin", xyz=_format_numbers(at), rpy=_format_numbers(ORIGIN))
    if axis is not None:
        ElementTree.SubElement(joint, "axis", xyz=_format_numbers(axis))
    if limits is not None:
        add_limit(joint, limits, UNBOUNDED, UNBOUNDED)
    if mimic is not None:
        ElementTree.SubElement(joint, "mimic", joint=mimic, multiplier=_format_numbers((multiplier,)), offset="0")


def add_limit(joint: ElementTree.Element, limits: tuple[float, float] | None, effort: float, velocity: float) -> None:
    """Add a joint's limit: lower and upper end [rad or m], if any, effort [N m or N], velocity [rad/s or m/s]."""
    limit = {} if limits is None else {"lower": limits[0], "upper": limits[1]}
    limit |= {"effort": effort, "velocity": velocity}
    ElementTree.SubElement(joint, "limit", {key: _format_numbers((value,)) for key, value in limit.items()})


def add_comment(element: ElementTree.Element, text: str) -> None:
    """Add a comment inside an element."""
    element.append(ElementTree.Comment(f" {text} "))


def add_link(robot: ElementTree.Element, name: str, shapes: Sequence[Shape], body: Body | None = None) -> None:
    """Add a link with its visuals and, where it has a mass, its inertial properties."""
    link = ElementTree.SubElement(robot, "link", name=name)
    if body is not None:
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "origin", xyz=_format_numbers(body.centre), rpy=_format_numbers(ORIGIN))
        ElementTree.SubElement(inertial, "mass", value=_format_numbers((body.mass,)))
        moments = {name: _format_numbers((value,)) for name, value in zip(MOMENTS, body.inertia, strict=True)}
        products = {name: _format_product(value) for name, value in zip(PRODUCTS, body.products, strict=True)}
        ElementTree.SubElement(inertial, "inertia", moments | products)
    for number, shape in enumerate(shapes):
        visual = ElementTree.SubElement(link, "visual", name=f"{name}_{number}")
        ElementTree.SubElement(visual, "origin", xyz=_format_numbers(shape.at), rpy=_format_numbers(shape.rpy))
        geometry = ElementTree.SubElement(visual, "geometry")
        _add_solid(geometry, shape.size)
        material = ElementTree.SubElement(visual, "material", name=f"{name}_{number}")
        ElementTree.SubElement(material, "color", rgba=shape.color)


def _add_solid(geometry: ElementTree.Element, size: Sequence[float]) -> None:
    if len(size) == 3:
        ElementTree.SubElement(geometry, "box", size=_format_numbers(size))
    elif len(size) == 2:
        ElementTree.SubElement(geometry, "cylinder", radius=_format_numbers(size[:1]), length=_format_numbers(size[1:]))
    else:
        ElementTree.SubElement(geometry, "sphere", radius=_format_numbers(size))


def _format_product(value: float) -> str:
    return _format_numbers((value,)) if value else "0"


def _format_numbers(numbers: Sequence[float]) -> str:
    """Return numbers with all their digits, so that what is read back is what was simulated."""
    return " ".join(repr(float(number)) for number in numbers)
