"""Drawings of a crane from its URDF: the polygons of all visuals at given joint positions."""

from collections.abc import Sequence
from math import pi
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from crane_sim.description import urdf
from crane_sim.description.frame_motion import frame_motions_in_base
from crane_sim.description.transforms import TransformTree
from crane_sim.scenes.scene import Scene

_SIDES = 14  # of a drawn cylinder
_BOX = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_BOX_FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


class Polygon(NamedTuple):
    """A face of a visual."""

    corners: np.ndarray  # (n, 3) m, in the axes of the base
    colour: tuple[float, ...]  # red, green, blue, opacity


def polygons(scene: Scene, q: Sequence[float]) -> list[Polygon]:
    """Return the faces of all visuals of a scene's crane at joint positions q (nq,) [m or rad]."""
    document, joints = urdf(scene), scene.joint_names
    frames = frame_motions_in_base(TransformTree(document, joints), q, [0.0] * len(joints))
    found = list[Polygon]()
    for link in ElementTree.fromstring(document).findall("link"):
        frame = frames.get(link.attrib["name"])
        at, turn = (np.zeros(3), np.eye(3)) if frame is None else (frame.position, frame.rotation)
        for visual in link.findall("visual"):
            offset, own_turn = _origin(visual)
            shape: Any = visual.find("geometry/*")
            for face in _faces(shape):
                corners = (face @ own_turn.T + offset) @ turn.T + at
                found.append(Polygon(corners, _colour(visual)))
    return found


def _origin(visual: ElementTree.Element) -> tuple[np.ndarray, np.ndarray]:
    """Return place (3,) [m] and rotation (3, 3) of a visual: turns about fixed x, y, z in turn."""
    origin = visual.find("origin")
    if origin is None:
        return np.zeros(3), np.eye(3)
    return _numbers(origin, "xyz"), Rotation.from_euler("xyz", _numbers(origin, "rpy")).as_matrix()


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
    # a sphere is drawn as a drum of the same size
    length = float(shape.attrib.get("length", 2.0 * radius))
    angles = np.arange(_SIDES) * 2.0 * pi / _SIDES
    ring = np.column_stack((radius * np.cos(angles), radius * np.sin(angles)))
    low, high = (np.column_stack((ring, np.full(_SIDES, z))) for z in (-0.5 * length, 0.5 * length))
    sides = [np.array([low[i - 1], low[i], high[i], high[i - 1]]) for i in range(_SIDES)]
    return [low, high, *sides]
