"""The URDF of an overhead crane: a trolley below a rail along x, with a bridge on runways along y, and a cable.

`base_link` has its origin on the rail's line, at the height of the cable's upper end. Frames `node_1` .. `node_<N-1>`
and `payload_link` are the nodes of the cable. All masses are point masses, those of the scene; only the cable's links
have moments of inertia.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description import overhead_visuals
from crane_sim.description.cables import SuspendedCable, add_cable
from crane_sim.description.robot import FORWARD, LEFT, add_comment, add_joint, add_link
from crane_sim.description.solids import Body, point_mass
from crane_sim.description.workspace import estimate_bounding_box, validated_scene_file

if TYPE_CHECKING:
    from crane_sim.description.workspace import BoundingBox
    from crane_sim.scenes.scene import Scene
    from crane_sim.scenes.schema.axes import AxisGroup


def add_overhead_crane(robot: ElementTree.Element, scene: Scene) -> None:
    """Add links and joints: those of the scene, and the mimic joints of the cable."""
    box, config = estimate_bounding_box(scene), validated_scene_file(scene)
    add_link(robot, "base_link", overhead_visuals.base(box))
    parent = "base_link"
    if box.spatial:
        add_link(robot, "bridge_link", overhead_visuals.bridge(box), _axis_body(config.bridge))
        add_joint(robot, "prismatic", "bridge", (parent, "bridge_link"), axis=LEFT)
        parent = "bridge_link"
    add_link(robot, "trolley_link", overhead_visuals.trolley(box), _axis_body(config.trolley))
    add_joint(robot, "prismatic", "trolley", (parent, "trolley_link"), axis=FORWARD)
    cable = SuspendedCable.from_scene(scene)
    add_cable(robot, scene.joint_names, cable, box)
    _add_nodes(robot, cable, box)
    if config.hoist is not None and config.hoist.inertia:
        _comment_drum(robot, config.hoist.inertia)


def _add_nodes(robot: ElementTree.Element, cable: SuspendedCable, box: BoundingBox) -> None:
    """Add the nodes at the lower ends of the cable's links: balls, and the payload."""
    for name, mass, length in zip(cable.end_link_names, cable.masses, cable.lengths, strict=True):
        if name == "payload_link":
            add_link(robot, name, overhead_visuals.payload(mass, box), point_mass(mass))
        else:
            radius = overhead_visuals.node_radius(mass, length, box)
            add_link(robot, name, [overhead_visuals.node(radius)], point_mass(mass) if mass > 0.0 else None)


def _comment_drum(robot: ElementTree.Element, reflected_mass: float) -> None:
    """Add a comment to the hoist's joint: the drum's inertia reflected to the rope [kg], which no link can have."""
    joint = next(joint for joint in robot.iter("joint") if joint.get("name") == "hoist")
    add_comment(
        joint, f"hoist.inertia = {reflected_mass:g} kg, reflected mass of the drum: adds to this joint only, to no link"
    )


def _axis_body(group: AxisGroup | None) -> Body | None:
    """Return the body of trolley or bridge; None without a mass, which only an axis driven by force needs."""
    mass = group.mass if group is not None else None
    return point_mass(mass) if mass else None
