"""The URDF of a payload below a driven suspension point: three sliding joints, and the rope's direction.

`base_link` is the frame of the base. The suspension point is drawn as the head of a boom that the model does not have:
it has no mass, since its motion is given.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description.cables import AXES, SuspendedCable, add_vector_links
from crane_sim.description.falls import add_head, add_load
from crane_sim.description.robot import add_joint, add_link
from crane_sim.description.solids import DARK, ORIGIN, RPY_ALONG_Y, STEEL, YELLOW, Shape, payload_box, point_mass
from crane_sim.description.suspended import add_payload, hook_block, hung_length
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.suspended.crane import SuspendedCrane

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene


def add_pendulum(robot: ElementTree.Element, scene: Scene) -> None:
    """Add links and joints; the followers of the directions come on top of the scene's."""
    crane, length = scene.model, cable_length(scene)
    ElementTree.SubElement(robot, "link", name="base_link")
    above = "base_link"
    for axis, way in AXES.items():
        below = "tip_link" if axis == "z" else f"tip_{axis}_link"
        add_link(robot, below, _head(length) if axis == "z" else [])
        add_joint(robot, "prismatic", f"tip_{axis}", (above, below), ORIGIN, way)
        above = below
    if isinstance(crane, FallsCrane):
        add_head(robot, crane.falls, above)
        add_load(robot, crane)
    elif isinstance(crane, SuspendedCrane):
        _add_links(robot, crane, above, length)
    else:
        mass = float(crane.load.mass)
        add_vector_links(robot, SuspendedCable((length,), (mass,)), False, above)
        add_link(robot, "payload_link", payload_box(0.12 * length), point_mass(mass))


def cable_length(scene: Scene) -> float:
    """Return the length of rope and further links [m], or of falls and the load below them."""
    return (
        hung_length(scene) if isinstance(scene.model, SuspendedCrane | FallsCrane) else float(scene.model.cable.length)
    )


def _add_links(robot: ElementTree.Element, crane: SuspendedCrane, above: str, size: float) -> None:
    """Add rope, further links and the payload."""
    lengths, masses = crane.cable.lengths.tolist(), [*crane.cable.masses[:-1].tolist(), crane.load.mass]
    last = "attachment_link" if isinstance(crane.load, RigidLoad) else "payload_link"
    for k in range(1, len(masses)):
        add_link(robot, f"node_{k}", hook_block(0.03 * size), point_mass(masses[k - 1]))
    add_vector_links(robot, SuspendedCable(tuple(lengths), tuple(masses)), False, above, 1, last)
    add_payload(robot, crane, last, size)


def _head(length: float) -> list[Shape]:
    """Return a sheave between two cheeks, its centre where the rope begins."""
    unit = 0.1 * length
    cheek = (0.9 * unit, 0.1 * unit, 1.3 * unit)
    return [
        Shape((0.4 * unit, 0.3 * unit), ORIGIN, STEEL, RPY_ALONG_Y),
        Shape(cheek, (0.0, 0.25 * unit, 0.25 * unit), YELLOW),
        Shape(cheek, (0.0, -0.25 * unit, 0.25 * unit), YELLOW),
        Shape((0.9 * unit, 0.6 * unit, 0.2 * unit), (0.0, 0.0, 0.8 * unit), DARK),
    ]
