"""Drawings of a crane from its URDF: the polygons of all visuals at given joint positions."""

from collections.abc import Mapping
from math import cos, pi, sin
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

_SIDES = 14  # of a drawn cylinder
_BOX = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_BOX_FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


class Polygon(NamedTuple):
    """A face of a visual."""

    corners: np.ndarray  # (n, 3) m, in the axes of the root
    colour: tuple[float, ...]  # red, green, blue, opacity


class Robot:
    """A URDF document whose visuals can be placed."""

    def __init__(self, document: str) -> None:
        """Parse it."""
        robot = ElementTree.fromstring(document)
        self._links = {link.attrib["name"]: link for link in robot.findall("link")}
        self._parents = {_child(joint, "child").attrib["link"]: joint for joint in robot.findall("joint")}

    def polygons(self, joints: Mapping[str, float]) -> list[Polygon]:
        """Return the faces of all visuals at joint positions by name [m or rad]."""
        return [
            Polygon(face @ pose[:3, :3].T + pose[:3, 3], _colour(visual))
            for name, link in self._links.items()
            for visual in link.findall("visual")
            for pose in [self.link_pose(name, joints) @ _origin(visual)]
            for face in _faces(_child(visual, "geometry")[0])
        ]

    def link_pose(self, link: str, joints: Mapping[str, float]) -> np.ndarray:
        """Return the pose (4, 4) of a link in the axes of the root, at joint positions by name [m or rad]."""
        if link not in self._parents:
            return np.eye(4)
        joint = self._parents[link]
        above = self.link_pose(_child(joint, "parent").attrib["link"], joints) @ _origin(joint)
        return above @ _motion(joint, _position(joint, joints))


def _child(element: ElementTree.Element, name: str) -> ElementTree.Element:
    child = element.find(name)
    assert child is not None
    return child


def _position(joint: ElementTree.Element, joints: Mapping[str, float]) -> float:
    mimic = joint.find("mimic")
    if mimic is None:
        return joints.get(joint.attrib["name"], 0.0)
    return float(mimic.attrib["multiplier"]) * joints[mimic.attrib["joint"]] + float(mimic.attrib.get("offset", 0.0))


def _motion(joint: ElementTree.Element, position: float) -> np.ndarray:
    """Return the pose (4, 4) of a joint's child at a position."""
    pose, kind = np.eye(4), joint.attrib["type"]
    if kind == "fixed":
        return pose
    axis = _numbers(_child(joint, "axis"), "xyz")
    if kind == "prismatic":
        pose[:3, 3] = position * axis
    else:
        pose[:3, :3] = _rotation(axis, position)
    return pose


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the matrix (3, 3) of a turn about a unit axis (3,), by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + sin(angle) * cross + (1.0 - cos(angle)) * cross @ cross


def _origin(element: ElementTree.Element) -> np.ndarray:
    """Return the pose (4, 4) of an element's origin: turns about the fixed axes x, y, z, in this order."""
    pose, origin = np.eye(4), element.find("origin")
    if origin is not None:
        for axis, angle in zip(np.eye(3), _numbers(origin, "rpy"), strict=True):
            pose[:3, :3] = _rotation(axis, angle) @ pose[:3, :3]
        pose[:3, 3] = _numbers(origin, "xyz")
    return pose


def _numbers(element: ElementTree.Element, key: str) -> np.ndarray:
    return np.array(element.attrib[key].split(), dtype=float)


def _colour(visual: ElementTree.Element) -> tuple[float, ...]:
    colour = visual.find("material/color")
    return (0.5, 0.5, 0.5, 1.0) if colour is None else tuple(_numbers(colour, "rgba").tolist())


def _faces(shape: Any) -> list[np.ndarray]:
    """Return the faces of a box, cylinder or sphere, each (n, 3) m about its centre."""
    if shape.tag == "box":
        corners = _BOX * _numbers(shape, "size")
        return [corners[list(face)] for face in _BOX_FACES]
    radius = float(shape.attrib["radius"])
    length = float(shape.attrib.get("length", 2.0 * radius))  # a sphere is drawn as a drum of the same size
    angles = np.arange(_SIDES) * 2.0 * pi / _SIDES
    ring = np.column_stack((radius * np.cos(angles), radius * np.sin(angles)))
    low, high = (np.column_stack((ring, np.full(_SIDES, z))) for z in (-0.5 * length, 0.5 * length))
    sides = [np.array([low[i - 1], low[i], high[i], high[i - 1]]) for i in range(_SIDES)]
    return [low, high, *sides]
