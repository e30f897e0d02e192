"""Elements of a URDF document: links with visuals and inertias, joints, and their limits."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description.solids import ORIGIN

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from crane_sim.description.solids import Body, Shape, Vector
    from crane_sim.scenes.scene import Scene

UP: Vector = (0.0, 0.0, 1.0)
DOWN: Vector = (0.0, 0.0, -1.0)
FORWARD: Vector = (1.0, 0.0, 0.0)
LEFT: Vector = (0.0, 1.0, 0.0)
RIGHT: Vector = (0.0, -1.0, 0.0)  # a positive turn about it lifts the x axis
MOMENTS, PRODUCTS = ("ixx", "iyy", "izz"), ("ixy", "ixz", "iyz")
UNBOUNDED = 1e12
"""Stands for no limit [m, rad, rad/s, N, ...]: the format takes no infinity, and no scene file a
larger number."""
NONNEGATIVE_JOINTS = ("rope", "hoist")  # joints that are never below zero


class Robot:
    """A URDF document that grows; a link that only joints name has no solids and no mass."""

    def __init__(self, name: str, comments: Iterable[str]) -> None:
        """Begin with comments."""
        self._root = ElementTree.Element("robot", name=name)
        for line in comments:
            self.comment(line)

    def comment(self, text: str, joint: str = "") -> None:
        """Add a comment, to a joint where one is named."""
        place = (
            self._root
            if not joint
            else next(j for j in self._root.iter("joint") if j.get("name") == joint)
        )
        place.append(ElementTree.Comment(f" {text} "))

    def link(self, name: str, shapes: Sequence[Shape] = (), body: Body | None = None) -> None:
        """Add a link with its visuals and, where it has a mass, its inertial properties."""
        link = ElementTree.SubElement(self._root, "link", name=name)
        if body is not None:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(
                inertial, "origin", xyz=_numbers(*body.centre), rpy=_numbers(*ORIGIN)
            )
            ElementTree.SubElement(inertial, "mass", value=_numbers(body.mass))
            moments = {
                name: _numbers(value) for name, value in zip(MOMENTS, body.inertia, strict=True)
            }
            products = {
                key: _numbers(value) if value else "0"
                for key, value in zip(PRODUCTS, body.products, strict=True)
            }
            ElementTree.SubElement(inertial, "inertia", moments | products)
        for number, shape in enumerate(shapes):
            visual = ElementTree.SubElement(link, "visual", name=f"{name}_{number}")
            ElementTree.SubElement(
                visual, "origin", xyz=_numbers(*shape.at), rpy=_numbers(*shape.rpy)
            )
            _add_solid(ElementTree.SubElement(visual, "geometry"), shape.size)
            material = ElementTree.SubElement(visual, "material", name=f"{name}_{number}")
            ElementTree.SubElement(material, "color", rgba=shape.color)

    def fix(self, name: str, parent: str, child: str, at: Vector = ORIGIN) -> None:
        """Add a fixed joint, placed `at` in the parent's frame [m]."""
        self._joint("fixed", name, parent, child, at)

    def turn(
        self,
        name: str,
        parent: str,
        child: str,
        axis: Vector,
        at: Vector = ORIGIN,
        mimic: str = "",
        multiplier: float = -1.0,
    ) -> None:
        """Add a revolute joint about an axis; it may mimic another's position by a multiplier."""
        self._mimic(self._joint("revolute", name, parent, child, at, axis), mimic, multiplier)

    def slide(
        self,
        name: str,
        parent: str,
        child: str,
        axis: Vector,
        at: Vector = ORIGIN,
        limits: tuple[float, float] | None = None,
        mimic: str = "",
        multiplier: float = -1.0,
    ) -> None:
        """Add a prismatic joint along an axis; `limits` [m] are those of the geometry."""
        joint = self._joint("prismatic", name, parent, child, at, axis)
        if limits is not None:
            _limit(joint, limits, inf, inf)
        self._mimic(joint, mimic, multiplier)

    def level(
        self, joint: str, parent: str, axis: Vector, name: str = "", at: Vector = ORIGIN
    ) -> str:
        """Add a frame that undoes the turn of a joint about its axis; return its link."""
        name = name or f"level_{joint}"
        self.turn(name, parent, f"{name}_link", axis, at, mimic=joint)
        return f"{name}_link"

    def finish(self, scene: Scene) -> str:
        """Return the document with all links, and the scene's limits for joints without any."""
        for joint in self._root.findall("joint"):
            if joint.get("type") != "fixed" and joint.find("limit") is None:
                _add_limit(joint, scene)
        links = {link.attrib["name"] for link in self._root.findall("link")}
        ends = [end.attrib["link"] for end in self._root.findall("joint/*[@link]")]
        for name in dict.fromkeys(name for name in ends if name not in links):
            self.link(name)
        ElementTree.indent(self._root)
        return ElementTree.tostring(self._root, encoding="unicode", xml_declaration=True)

    def _joint(
        self, kind: str, name: str, parent: str, child: str, at: Vector, axis: Vector | None = None
    ) -> ElementTree.Element:
        joint = ElementTree.SubElement(self._root, "joint", name=name, type=kind)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=child)
        ElementTree.SubElement(joint, "origin", xyz=_numbers(*at), rpy=_numbers(*ORIGIN))
        if axis is not None:
            ElementTree.SubElement(joint, "axis", xyz=_numbers(*axis))
        return joint

    def _mimic(self, joint: ElementTree.Element, mimic: str, multiplier: float) -> None:
        if mimic:
            ElementTree.SubElement(
                joint, "mimic", joint=mimic, multiplier=_numbers(multiplier), offset="0"
            )


def _add_solid(geometry: ElementTree.Element, size: Sequence[float]) -> None:
    if len(size) == 3:
        ElementTree.SubElement(geometry, "box", size=_numbers(*size))
    elif len(size) == 2:
        ElementTree.SubElement(
            geometry, "cylinder", radius=_numbers(size[0]), length=_numbers(size[1])
        )
    else:
        ElementTree.SubElement(geometry, "sphere", radius=_numbers(*size))


def _add_limit(joint: ElementTree.Element, scene: Scene) -> None:
    """Add a joint's limits: the `limits` of its group in the scene, and its actuator's.

    A revolute joint without ends is continuous.
    """
    name = joint.attrib["name"]
    low = 0.0 if name in NONNEGATIVE_JOINTS else -inf
    ends = next(((span.low, span.high) for span in scene.limits if span.joint == name), (low, inf))
    effort = speed = inf
    if scene.hardware is not None and name in scene.actuated:
        index = scene.actuated.index(name)
        if scene.effort_units[index] in (
            "N",
            "N m",
        ):  # the efforts of a URDF are forces and torques
            drive = scene.hardware.drives[index]
            effort = float(max(abs(drive.low), abs(drive.high)))
        if scene.hardware.servos is not None:
            speed = float(scene.hardware.servos[index].max_speed)
    if joint.get("type") != "revolute" or any(map(isfinite, ends)):
        _limit(joint, ends, effort, speed)
        return
    joint.set("type", "continuous")
    if isfinite(effort) or isfinite(speed):
        _limit(joint, None, effort, speed)


def _limit(
    joint: ElementTree.Element, ends: tuple[float, float] | None, effort: float, velocity: float
) -> None:
    """Add a joint's limit: ends [rad or m], if any, effort [N m or N], velocity [rad/s or m/s]."""
    limit = (
        {}
        if ends is None
        else {"lower": max(ends[0], -UNBOUNDED), "upper": min(ends[1], UNBOUNDED)}
    )
    limit |= {"effort": min(effort, UNBOUNDED), "velocity": min(velocity, UNBOUNDED)}
    ElementTree.SubElement(joint, "limit", {key: _numbers(value) for key, value in limit.items()})


def _numbers(*numbers: float) -> str:
    """Return numbers with all their digits, so that what is read back is what was simulated."""
    return " ".join(repr(float(number)) for number in numbers)
