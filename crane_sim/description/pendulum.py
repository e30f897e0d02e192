"""The URDF of a payload below a driven suspension point: three sliding joints, and the rope's direction.

`base_link` is the frame of the base. The suspension point is drawn as the head of a boom that the model does not have:
it has no mass, since its motion is given.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description.cables import ALONG, SuspendedCable, add_directed
from crane_sim.description.robot import add_joint, add_link
from crane_sim.description.solids import ACROSS, DARK, ORIGIN, STEEL, YELLOW, Shape, crate, point_mass

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene


def add_pendulum(robot: ElementTree.Element, scene: Scene) -> None:
    """Add links and joints; the followers of the rope's direction come on top of the scene's."""
    length, mass = float(scene.model.cable.length), float(scene.model.load.mass)
    ElementTree.SubElement(robot, "link", name="base_link")
    above = "base_link"
    for axis, way in ALONG.items():
        below = "tip_link" if axis == "z" else f"tip_{axis}_link"
        add_link(robot, below, _head(length) if axis == "z" else [])
        add_joint(robot, "prismatic", f"tip_{axis}", (above, below), ORIGIN, way)
        above = below
    add_directed(robot, SuspendedCable((length,), (mass,)), False, above)
    add_link(robot, "payload_link", crate(0.12 * length), point_mass(mass))


def _head(length: float) -> list[Shape]:
    """Return a sheave between two cheeks, its centre where the rope begins."""
    unit = 0.1 * length
    cheek = (0.9 * unit, 0.1 * unit, 1.3 * unit)
    return [
        Shape((0.4 * unit, 0.3 * unit), ORIGIN, STEEL, ACROSS),
        Shape(cheek, (0.0, 0.25 * unit, 0.25 * unit), YELLOW),
        Shape(cheek, (0.0, -0.25 * unit, 0.25 * unit), YELLOW),
        Shape((0.9 * unit, 0.6 * unit, 0.2 * unit), (0.0, 0.0, 0.8 * unit), DARK),
    ]
