"""The URDF of a crane: what robot_state_publisher and RViz draw, and the recording of a knuckle crane.

Frames follow REP-103: x forward, y left, z up, SI units and radians; the root is `world`, the model's own frame.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description import knuckle, overhead, pendulum

if TYPE_CHECKING:
    from crane_sim.scene import Scene


def urdf(scene: Scene) -> str:
    """Describe a scene's crane as a URDF document; its free joints are `scene.joint_names`."""
    robot = ElementTree.Element("robot", name=f"{scene.crane}_crane")
    ElementTree.SubElement(robot, "link", name="world")
    if scene.crane == "overhead":
        overhead.describe(robot, scene)
    elif scene.crane == "pendulum":
        pendulum.describe(robot, scene)
    else:
        knuckle.describe(robot, scene.model, scene.joint_names)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True)
