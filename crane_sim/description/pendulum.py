"""The URDF of a payload below a driven suspension point: sliding joints, the rope's direction.

`base_link` is the frame of the base. The suspension point is drawn as the head of a boom that the
model does not have: it has no mass, since its motion is given.
"""

from __future__ import annotations

from crane_sim.description.cables import AXES, SuspendedCable, add_vector_links
from crane_sim.description.falls import add_head, add_load
from crane_sim.description.robot import Robot
from crane_sim.description.solids import (
    DARK,
    ORIGIN,
    RPY_ALONG_Y,
    STEEL,
    YELLOW,
    Shape,
    payload_box,
    point_mass,
)
from crane_sim.description.suspended import add_nodes, add_payload, hung_length
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene


def add_pendulum(robot: Robot, scene: Scene) -> None:
    """Add links and joints; the followers of the directions come on top of the scene's."""
    crane, length, above = scene.model, cable_length(scene), "base_link"
    for axis, way in AXES.items():
        below = "tip_link" if axis == "z" else f"tip_{axis}_link"
        robot.slide(f"tip_{axis}", above, below, way)
        above = below
    robot.link(above, _head(length))
    if isinstance(crane, FallsCrane):
        add_head(robot, crane.falls, above)
        add_load(robot, crane)
    elif isinstance(crane, SuspendedCrane):
        masses, last = add_nodes(robot, crane, 0.03 * length)
        add_vector_links(
            robot,
            SuspendedCable(tuple(crane.cable.lengths.tolist()), masses),
            False,
            above,
            1,
            last,
        )
        add_payload(robot, crane, last, length)
    else:
        mass = float(crane.load.mass)
        add_vector_links(robot, SuspendedCable((length,), (mass,)), False, above)
        robot.link("payload_link", payload_box(0.12 * length), point_mass(mass))


def cable_length(scene: Scene) -> float:
    """Return the length of rope and further links [m], or of falls and the load below them."""
    hangs = isinstance(scene.model, SuspendedCrane | FallsCrane)
    return hung_length(scene) if hangs else float(scene.model.cable.length)


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
