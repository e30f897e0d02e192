"""Forward kinematics of a URDF document."""

from math import cos, sin
from xml.etree import ElementTree

import numpy as np


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the matrix (3, 3) that turns about a unit axis (3,)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + sin(angle) * cross + (1.0 - cos(angle)) * cross @ cross


def numbers(element: ElementTree.Element | None, key: str) -> np.ndarray:
    """Return an attribute's numbers (n,)."""
    assert element is not None
    return np.array(element.attrib[key].split(), dtype=float)


def link_position(document: str, joints: dict[str, float], link: str) -> np.ndarray:
    """Return a link's origin (3,) in the root frame from the URDF alone, mimic joints included."""
    robot = ElementTree.fromstring(document)
    parents = {joint.find("child").attrib["link"]: joint for joint in robot.findall("joint")}  # pyright: ignore
    position = np.zeros(3)
    while link in parents:
        joint = parents[link]
        assert not numbers(joint.find("origin"), "rpy").any()
        mimic = joint.find("mimic")
        if mimic is not None:
            value = float(mimic.attrib["multiplier"]) * joints[mimic.attrib["joint"]] + float(
                mimic.attrib["offset"]
            )
        else:
            value = joints.get(joint.attrib["name"], 0.0)
        kind = joint.attrib["type"]
        if kind == "prismatic":
            position = position + value * numbers(joint.find("axis"), "xyz")
        elif kind != "fixed":
            position = rotation(numbers(joint.find("axis"), "xyz"), value) @ position
        position = position + numbers(joint.find("origin"), "xyz")
        link = joint.find("parent").attrib["link"]  # pyright: ignore[reportOptionalMemberAccess]
    return position
