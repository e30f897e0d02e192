"""The URDF of an overhead crane: a trolley below a rail along x, with a bridge on runways along y, and a cable.

`world` has its origin on the rail's line, at the height of the cable's upper end. Frames `node_1` .. `node_<N-1>` and
`payload_link` are the nodes of the cable. Masses are the scene's, as points: nothing but the links turns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

from crane_sim.description import gantry
from crane_sim.description.cables import Hang, add_cable
from crane_sim.description.robot import FORWARD, LEFT, add_comment, add_joint, add_link
from crane_sim.description.solids import Body, point_mass
from crane_sim.description.workspace import estimate_room, form_of

if TYPE_CHECKING:
    from crane_sim.description.workspace import Room
    from crane_sim.scenes.scene import Scene
    from crane_sim.scenes.schema.overhead_groups import AxisGroup


def add_overhead_crane(robot: ElementTree.Element, scene: Scene) -> None:
    """Add links and joints; the fixed `rail` and the mimic joints of the cable come on top of the scene's joints."""
    room, form = estimate_room(scene), form_of(scene)
    add_link(robot, "base_link", gantry.base(room))
    add_joint(robot, "fixed", "rail", ("world", "base_link"))
    above = "base_link"
    if room.spatial:
        add_link(robot, "bridge_link", gantry.bridge(room), _body(form.bridge))
        add_joint(robot, "prismatic", "bridge", (above, "bridge_link"), axis=LEFT)
        above = "bridge_link"
    add_link(robot, "trolley_link", gantry.trolley(room), _body(form.trolley))
    add_joint(robot, "prismatic", "trolley", (above, "trolley_link"), axis=FORWARD)
    hang = Hang.of(scene)
    add_cable(robot, scene.joint_names, hang, room)
    _add_nodes(robot, hang, room)
    if form.hoist is not None and form.hoist.inertia:
        _comment_drum(robot, form.hoist.inertia)


def _add_nodes(robot: ElementTree.Element, hang: Hang, room: Room) -> None:
    """Add the links that end the pieces of the cable: balls, and the payload."""
    for name, mass, length in zip(hang.ends, hang.masses, hang.lengths, strict=True):
        if name == "payload_link":
            add_link(robot, name, gantry.payload(mass, room), point_mass(mass))
        else:
            radius = gantry.node_radius(mass, length, room)
            add_link(robot, name, [gantry.node(radius)], point_mass(mass) if mass > 0.0 else None)


def _comment_drum(robot: ElementTree.Element, inertia: float) -> None:
    """Say at the hoist's joint which inertia [kg] no link of a URDF can have."""
    joint = next(joint for joint in robot.iter("joint") if joint.get("name") == "hoist")
    add_comment(joint, f"hoist.inertia = {inertia:g} kg, of the drum: adds to this joint's own term, and to no link")


def _body(group: AxisGroup | None) -> Body | None:
    """Return the body of trolley or bridge; what is not driven by a force needs no mass."""
    mass = group.mass if group is not None else None
    return point_mass(mass) if mass else None
