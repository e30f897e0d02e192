"""A crane for drawing: the links, solids and joints of its URDF as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from crane_sim.description.suspended import ATTITUDE_JOINT
from crane_sim.scenes.schema.rigging import ATTITUDE

if TYPE_CHECKING:
    from collections.abc import Sequence


def parse_robot(urdf: str, coordinates: Sequence[str]) -> dict[str, Any]:
    """Return the links of a URDF with their solids, and its joints with their coordinates.

    A joint that moves has `source`, the index of its coordinate, and `multiplier` and `offset` of its position. A fixed
    joint has none of these, except for the one of a body's attitude, which URDF has no type for: its `source` is the
    indices of the components w, x, y, z of a quaternion.

    Args:
        urdf: the document's text.
        coordinates: names of the joint coordinates (nq,).
    """
    robot = ElementTree.fromstring(urdf)
    links = {link.attrib["name"]: [_solid(visual) for visual in link.iter("visual")] for link in robot.iter("link")}
    return {"links": links, "joints": [_joint_record(joint, list(coordinates)) for joint in robot.findall("joint")]}


def used_coordinates(robot: dict[str, Any]) -> list[int]:
    """Return the indices of the coordinates that move a joint, in ascending order."""
    used = [joint["source"] for joint in robot["joints"] if "source" in joint]
    return sorted({i for source in used for i in (source if isinstance(source, list) else [source])})


def _joint_record(joint: ElementTree.Element, coordinates: list[str]) -> dict[str, Any]:
    name, mimic = joint.attrib["name"], joint.find("mimic")
    description: dict[str, Any] = {
        "name": name,
        "parent": _child(joint, "parent").attrib["link"],
        "child": _child(joint, "child").attrib["link"],
        "at": _floats_of(_child(joint, "origin"), "xyz"),
        "rpy": _floats_of(_child(joint, "origin"), "rpy"),
    }
    if joint.attrib["type"] == "fixed":
        quaternion = [coordinates.index(part) for part in ATTITUDE if part in coordinates]
        return description | ({"source": quaternion} if name == ATTITUDE_JOINT and quaternion else {})
    return description | {
        "source": coordinates.index(name if mimic is None else mimic.attrib["joint"]),
        "multiplier": 1.0 if mimic is None else float(mimic.attrib.get("multiplier", "1")),
        "offset": 0.0 if mimic is None else float(mimic.attrib.get("offset", "0")),
        "prismatic": joint.attrib["type"] == "prismatic",
        "axis": _floats_of(_child(joint, "axis"), "xyz"),
    }


def _solid(visual: ElementTree.Element) -> dict[str, Any]:
    shape = _child(visual, "geometry")[0]
    names = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}[shape.tag]
    return {
        "size": [number for name in names for number in _floats_of(shape, name)],
        "at": _floats_of(_child(visual, "origin"), "xyz"),
        "rpy": _floats_of(_child(visual, "origin"), "rpy"),
        "color": _floats_of(_child(_child(visual, "material"), "color"), "rgba"),
    }


def _child(element: ElementTree.Element, name: str) -> ElementTree.Element:
    child = element.find(name)
    assert child is not None, f"{element.tag} without {name}"
    return child


def _floats_of(element: ElementTree.Element, name: str) -> list[float]:
    return [float(number) for number in element.attrib[name].split()]
