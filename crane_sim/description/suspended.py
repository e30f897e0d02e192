"""The URDF of cranes with a suspended cable: the support, rope and swing, further links, the payload.

The support's part is that of cranes with falls as well.

The origin of `base_link` is the model's: at the height of the jib's underside on the tower's axis, on the slewing axis
of a mobile crane, or on the trolley's rail. Further links are unit vectors in the axes of the base, so joints `level_*`
undo the turns of rope and slew. A payload's attitude is four components of a quaternion, which no joints of a URDF can
be: its link keeps the axes of the base here, while a recording turns it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from crane_sim.description.cables import SuspendedCable, add_vector_links
from crane_sim.description.knuckle import add_knuckle_boom, pedestal_height
from crane_sim.description.robot import DOWN, FORWARD, LEFT, RIGHT, UP, add_comment, add_joint, add_link
from crane_sim.description.solids import (
    DARK,
    GLASS,
    GREY,
    ORIGIN,
    RED,
    RPY_ALONG_Y,
    STEEL,
    YELLOW,
    Body,
    Shape,
    hydraulic_cylinder,
    payload_box,
    point_mass,
    tube,
)
from crane_sim.description.workspace import axis_positions
from crane_sim.models.loads import RigidLoad
from crane_sim.models.supports.bridge import Bridge
from crane_sim.models.supports.flexible import FlexibleSupport, rigid_support
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.models.supports.telescopic_boom import TelescopicBoom
from crane_sim.models.supports.tower_crane import TowerCrane

if TYPE_CHECKING:
    from crane_sim.models.suspended.crane import SuspendedCrane
    from crane_sim.scenes.scene import Scene

MAST_HEIGHT, COUNTER_JIB = 1.3, 0.3  # of a tower crane's size: drawn, not modelled
ATTITUDE_JOINT = "attitude"
"""The fixed joint above a payload with an attitude, which a recording turns."""
FOOT_HEIGHT = 0.12  # of a mobile crane's size: of the model's origin above the ground


def crane_size(scene: Scene) -> float:
    """Return a typical length [m]: the jib to the trolley's furthest point, or the boom's."""
    support, start = rigid_support(scene.model.support.structure), scene.initial_q
    if isinstance(support, Bridge):
        return 1.5 * float(np.sum(scene.model.cable.lengths))
    if isinstance(support, TowerCrane):
        limits = support.trolley.limits
        radii = [start[1], *(scene.reference or ())[1:2], *(limits or ())]
        return 1.1 * max(map(abs, radii)) or hung_length(scene)
    if isinstance(support, Knuckle):
        return support.boom.length + support.jib.length
    limits = support.telescope.limits
    return max([start[2], *(scene.reference or ())[2:3], *(limits or ())])


def hung_length(scene: Scene) -> float:
    """Return the length [m] of what hangs: of rope and further links, or of falls and the load below them."""
    falls = getattr(scene.model, "falls", None)
    if falls is None:
        return float(np.sum(scene.model.cable.lengths))
    return float(falls.length + 2.0 * abs(falls.bottom[:, 2].mean()))


def contact_height(scene: Scene) -> float | None:
    """Return the height [m] of the surface that a load can be set down on, None where a crane has none."""
    contact = getattr(scene.model, "contact", None)
    if contact is None:
        return None
    return float(contact.surface.height if contact.changes is None else contact.changes.heights.min())


def ground_height(scene: Scene) -> float:
    """Return the height [m] of the drawn ground, below all that hangs: a contact's surface, if there is one."""
    if (surface := contact_height(scene)) is not None:
        return surface
    length = hung_length(scene)
    support = rigid_support(scene.model.support.structure)
    if isinstance(support, Bridge):
        return -1.3 * length
    if isinstance(support, TowerCrane):
        return -max(MAST_HEIGHT * crane_size(scene), 1.15 * length)
    if isinstance(support, Knuckle):
        return -pedestal_height(support)
    return -FOOT_HEIGHT * crane_size(scene)


def add_suspended_crane(robot: ElementTree.Element, scene: Scene) -> None:
    """Add links and joints of a scene's crane."""
    crane: SuspendedCrane = scene.model
    tip = add_support(robot, scene)
    for name in ("swing_link", "rope_link"):
        ElementTree.SubElement(robot, "link", name=name)
    add_joint(robot, "revolute", "swing_tangential", (tip, "swing_link"), axis=FORWARD)
    add_joint(robot, "revolute", "swing_radial", ("swing_link", "rope_link"), axis=RIGHT)
    _add_rigging(robot, crane, scene, crane_size(scene))
    add_drives(robot, scene)


def add_support(robot: ElementTree.Element, scene: Scene) -> str:
    """Add links and joints of a scene's support; return the link at its tip, whose axes are level."""
    support = scene.model.support.structure
    bends, size, rigid = (
        support if isinstance(support, FlexibleSupport | SwayingTower) else None,
        crane_size(scene),
        rigid_support(support),
    )
    if isinstance(rigid, Bridge):
        return _add_bridge(robot, rigid, scene, size)
    if isinstance(rigid, TowerCrane):
        return _add_tower(robot, rigid, bends, size, ground_height(scene))
    if isinstance(rigid, Knuckle):
        return add_knuckle_boom(robot, rigid, scene.joint_names[:3])
    return _add_boom(robot, rigid, bends, size, scene.initial_q[2])


def _add_rigging(robot: ElementTree.Element, crane: SuspendedCrane, scene: Scene, size: float) -> None:
    """Add the rope's length, further links and the payload."""
    lengths, masses = crane.cable.lengths.tolist(), [*crane.cable.masses[:-1].tolist(), crane.load.mass]
    end = "rope_end_link"
    ElementTree.SubElement(robot, "link", name=end)
    add_joint(robot, "prismatic", "rope", ("rope_link", end), axis=DOWN)
    turns = ("swing_radial", RIGHT), ("swing_tangential", FORWARD), ("lateral_deflection", UP), ("slew", UP)
    for joint, axis in (turn for turn in turns if turn[0] in scene.joint_names):
        level = f"level_{joint}_link"
        ElementTree.SubElement(robot, "link", name=level)
        add_joint(robot, "revolute", f"level_{joint}", (end, level), ORIGIN, axis, mimic=joint)
        end = level
    for k in range(1, len(masses)):
        add_link(robot, f"node_{k}", hook_block(0.012 * size), point_mass(masses[k - 1]))
    last = "attachment_link" if isinstance(crane.load, RigidLoad) else "payload_link"
    if len(masses) == 1:
        add_joint(robot, "fixed", "hook", (end, last))
    else:
        add_joint(robot, "fixed", "hook", (end, "node_1"))
        add_vector_links(robot, SuspendedCable(tuple(lengths[1:]), tuple(masses[1:])), False, "node_1", 2, last)
    add_payload(robot, crane, last, size)


def add_payload(robot: ElementTree.Element, crane: SuspendedCrane, last: str, size: float) -> None:
    """Add the payload, and the link `last` where a body hangs."""
    if isinstance(crane.load, RigidLoad):
        ElementTree.SubElement(robot, "link", name=last)
        add_joint(robot, "fixed", ATTITUDE_JOINT, (last, "payload_link"))
    shapes, body = payload_visual(crane.load, size)
    add_link(robot, "payload_link", shapes, body)


def add_drives(robot: ElementTree.Element, scene: Scene) -> None:
    """Add the positions of drives with play, reflected to their joints, as links that nothing hangs on."""
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    for name in (name for name in scene.joint_names if "_drive_" in name):
        ElementTree.SubElement(robot, "link", name=f"{name}_link")
        kind = "prismatic" if units[name] == "m" else "revolute"
        axis = LEFT if name.startswith("bridge") else UP if name.startswith("slew") else FORWARD
        add_joint(robot, kind, name, ("base_link", f"{name}_link"), axis=axis)


def payload_visual(load: Any, size: float) -> tuple[list[Shape], Body]:
    """Return (solids, body) of a payload in the frame of its attachment."""
    edge = min(max((load.mass / 2400.0) ** (1.0 / 3.0), 0.02 * size), 0.1 * size)
    if not isinstance(load, RigidLoad):
        return payload_box(edge), point_mass(load.mass)
    moments = np.diag(np.array(load.inertia))
    centre = tuple(-float(x) for x in load.attachment)
    x, y, z = box_edges(load)
    band = (1.01 * x, 0.06 * y, 1.01 * z)
    shapes = [Shape((x, y, z), (centre[0], centre[1], centre[2]), RED)]
    shapes += [Shape(band, (centre[0], centre[1] + share * y, centre[2]), DARK) for share in (0.35, -0.35)]
    inertia = tuple(float(moment) for moment in moments)
    moments_of = (inertia[0], inertia[1], inertia[2])
    return shapes, Body(load.mass, (centre[0], centre[1], centre[2]), moments_of, products_of(load))


def box_edges(load: RigidLoad) -> tuple[float, float, float]:
    """Return the edges [m] of the box of even density that has a load's moments of inertia."""
    moments = np.diag(np.array(load.inertia))
    x, y, z = (float(edge) for edge in np.sqrt(np.maximum(12.0 * (0.5 * moments.sum() - moments) / load.mass, 1e-6)))
    return x, y, z


def products_of(load: RigidLoad) -> tuple[float, float, float]:
    """Return the entries xy, xz, yz of a load's inertia tensor [kg m²]."""
    return load.inertia[0][1], load.inertia[0][2], load.inertia[1][2]


def hook_block(unit: float) -> list[Shape]:
    """Return the solids of a hook block whose size is some `unit` [m]."""
    return [
        Shape((0.9 * unit, 0.5 * unit), ORIGIN, STEEL, RPY_ALONG_Y),
        Shape((0.9 * unit, 0.5 * unit, 1.6 * unit), (0.0, 0.0, -0.3 * unit), YELLOW),
    ]


def _add_tower(robot: ElementTree.Element, support: TowerCrane, bends: Any, size: float, ground: float) -> str:
    """Add mast, jib and trolley; return the link where the rope begins. `bends`: what bends, None of a rigid crane."""
    unit, inertia = 0.02 * size, getattr(support.slew, "inertia", 0.0)
    if isinstance(bends, SwayingTower):
        return _add_swaying_tower(robot, bends, size, ground)
    mast = Shape((1.6 * unit, 1.6 * unit, -ground), (0.0, 0.0, 0.5 * ground), YELLOW)
    foot = Shape((5.0 * unit, 5.0 * unit, unit), (0.0, 0.0, ground + 0.5 * unit), GREY)
    add_link(robot, "base_link", [mast, foot])
    if bends is not None:
        return _add_bent_jib(robot, bends, size, unit)
    shapes = [_truss(-COUNTER_JIB * size, size, unit), *_tower_head(size, unit)]
    add_comment(robot, "slew_link has no mass: on the slew axis it has no effect, and none is simulated")
    add_link(robot, "slew_link", shapes, Body(0.0, ORIGIN, (0.5 * inertia, 0.5 * inertia, inertia)))
    add_link(robot, "trolley_link", _jib_trolley(unit), point_mass(support.trolley.mass))
    add_joint(robot, "revolute", "slew", ("base_link", "slew_link"), axis=UP)
    add_joint(robot, "prismatic", "trolley", ("slew_link", "trolley_link"), axis=FORWARD)
    return "trolley_link"


def _add_swaying_tower(robot: ElementTree.Element, tower: SwayingTower, size: float, ground: float) -> str:
    """Add the mast on its universal joint, jib and trolley; return the link where the rope begins, in level axes."""
    unit, h, masses, places = 0.02 * size, tower.height, np.array(tower.masses), np.array(tower.places)
    foot = Shape((5.0 * unit, 5.0 * unit, unit), (0.0, 0.0, ground + 0.5 * unit), GREY)
    below = Shape((1.6 * unit, 1.6 * unit, max(-ground - h, unit)), (0.0, 0.0, 0.5 * (ground - h)), YELLOW)
    add_link(robot, "base_link", [foot, below])
    ElementTree.SubElement(robot, "link", name="mast_joint_link")
    add_link(robot, "mast_link", [Shape((1.6 * unit, 1.6 * unit, h), (0.0, 0.0, 0.5 * h), YELLOW)])
    centre = float(masses @ places / masses.sum())
    turning = float(masses @ (places - centre) ** 2)
    shapes = [_truss(-COUNTER_JIB * size, size, unit), *_tower_head(size, unit)]
    add_link(robot, "slew_link", shapes, Body(float(masses.sum()), (centre, 0.0, 0.0), (0.0, turning, turning)))
    add_link(robot, "trolley_link", _jib_trolley(unit), point_mass(tower.support.trolley.mass))
    add_joint(robot, "revolute", "mast_x_deflection", ("base_link", "mast_joint_link"), (0.0, 0.0, -h), FORWARD)
    add_joint(robot, "revolute", "mast_y_deflection", ("mast_joint_link", "mast_link"), axis=LEFT)
    add_joint(robot, "revolute", "slew", ("mast_link", "slew_link"), (0.0, 0.0, h), UP)
    add_joint(robot, "prismatic", "trolley", ("slew_link", "trolley_link"), axis=FORWARD)
    last, turns = "trolley_link", (("slew", UP, -1.0), ("mast_y_deflection", LEFT, -1.0))
    for k, (joint, axis, sign) in enumerate((*turns, ("mast_x_deflection", FORWARD, -1.0), ("slew", UP, 1.0))):
        link = f"level_{k}_link"
        ElementTree.SubElement(robot, "link", name=link)
        add_joint(robot, "revolute", f"level_mast_{k}", (last, link), axis=axis, mimic=joint, multiplier=sign)
        last = link
    return last


def _add_bent_jib(robot: ElementTree.Element, bends: FlexibleSupport, size: float, unit: float) -> str:
    """Add counter-jib, jib and trolley; return the link where the rope begins, whose axes are level."""
    section, rod, trolley = bends.inner.base_section, bends.outer.base_section, bends.outer.telescope.mass
    shapes = [_truss(-COUNTER_JIB * size, 0.0, unit), *_tower_head(size, unit)]
    add_link(robot, "slew_link", shapes, Body(section.mass, (section.centre, 0.0, 0.0), (0.0, 0.0, 0.0)))
    thin = (0.0, rod.inertia, rod.inertia)
    add_link(robot, "jib_link", [_truss(0.0, size, unit)], Body(rod.mass, (rod.centre, 0.0, 0.0), thin))
    add_link(robot, "trolley_link", _jib_trolley(unit), point_mass(trolley))
    add_joint(robot, "revolute", "slew", ("base_link", "slew_link"), axis=UP)
    _add_bending(robot, bends, "slew_link", "jib_link")
    add_joint(robot, "prismatic", "trolley", ("jib_link", "trolley_link"), axis=FORWARD)
    return _level_bending(robot, bends, "trolley_link")


def _add_bending(robot: ElementTree.Element, bends: FlexibleSupport, parent: str, child: str) -> None:
    """Add the joints of the modes of bending between two links that have the same origin."""
    if bends.lateral is not None:
        last = child if bends.vertical is None else "bent_link"
        add_joint(robot, "revolute", "lateral_deflection", (parent, last), axis=UP)
        if bends.vertical is not None:
            ElementTree.SubElement(robot, "link", name=last)
        parent = last
    if bends.vertical is not None:
        add_joint(robot, "revolute", "vertical_deflection", (parent, child), axis=RIGHT)


def _level_bending(robot: ElementTree.Element, bends: FlexibleSupport, parent: str) -> str:
    """Return the link of the parent's origin that bending in the structure's plane does not turn."""
    if bends.vertical is None:
        return parent
    ElementTree.SubElement(robot, "link", name="level_link")
    pair = (parent, "level_link")
    add_joint(robot, "revolute", "level_deflection", pair, ORIGIN, RIGHT, mimic="vertical_deflection")
    return "level_link"


def _truss(start: float, end: float, unit: float) -> Shape:
    return Shape((end - start, unit, 1.2 * unit), (0.5 * (start + end), 0.0, 1.2 * unit), YELLOW)


def _tower_head(size: float, unit: float) -> list[Shape]:
    back, top = COUNTER_JIB * size, 0.14 * size
    apex, beam = (0.0, top + unit), 1.8 * unit
    return [
        tube(apex, (0.6 * size, beam), 0.15 * unit, STEEL),
        tube(apex, (0.5 * unit - back, beam), 0.15 * unit, STEEL),
        Shape((1.2 * unit, 1.2 * unit, top), (0.0, 0.0, 0.5 * top + unit), YELLOW),
        Shape((3.0 * unit, 2.0 * unit, 3.5 * unit), (1.5 * unit - back, 0.0, -0.2 * unit), DARK),
        Shape((1.6 * unit, 1.5 * unit, 2.0 * unit), (1.8 * unit, 1.6 * unit, 0.0), GLASS),
    ]


def _jib_trolley(unit: float) -> list[Shape]:
    return [
        Shape((2.2 * unit, 1.4 * unit, 0.5 * unit), (0.0, 0.0, 0.3 * unit), DARK),
        Shape((0.5 * unit, 1.0 * unit), ORIGIN, STEEL, RPY_ALONG_Y),
    ]


def bridge_reach(scene: Scene, size: float) -> tuple[float, float]:
    """Return the ends [m] of the drawn girder of a bridge crane."""
    limits = rigid_support(scene.model.support.structure).trolley.limits
    places = [*axis_positions(scene, "trolley"), *(limits or ())]
    return min(places) - 0.3 * size, max(places) + 0.3 * size


def _add_bridge(robot: ElementTree.Element, support: Bridge, scene: Scene, size: float) -> str:
    """Add bridge and trolley; return the link of the trolley."""
    unit = 0.03 * size
    left, right = bridge_reach(scene, size)
    girder = Shape((right - left, unit, 1.6 * unit), (0.5 * (left + right), 0.0, 1.6 * unit), YELLOW)
    carriages = [Shape((unit, 6.0 * unit, unit), (end, 0.0, 1.2 * unit), DARK) for end in (left, right)]
    add_link(robot, "base_link", _runway(scene, (left, right), unit, ground_height(scene)))
    own = support.axes[1].mass
    add_link(robot, "bridge_link", [girder, *carriages], point_mass(own))
    add_link(robot, "trolley_link", _jib_trolley(unit), point_mass(support.trolley.mass))
    add_joint(robot, "prismatic", "bridge", ("base_link", "bridge_link"), axis=LEFT)
    add_joint(robot, "prismatic", "trolley", ("bridge_link", "trolley_link"), axis=FORWARD)
    return "trolley_link"


def _runway(scene: Scene, ends: tuple[float, float], unit: float, ground: float) -> list[Shape]:
    """Return the two beams that a bridge runs on, below the `ends` [m] of its girder, each on two columns."""
    places = axis_positions(scene, "bridge")
    low, high = min(places) - 8.0 * unit, max(places) + 8.0 * unit
    top = -0.3 * unit
    beams = [Shape((unit, high - low, unit), (x, 0.5 * (low + high), top), GREY) for x in ends]
    columns = [
        Shape((unit, unit, top - ground), (x, y, 0.5 * (top + ground)), GREY)
        for x in ends
        for y in (low + unit, high - unit)
    ]
    return beams + columns


def _add_boom(robot: ElementTree.Element, support: TelescopicBoom, bends: Any, size: float, length: float) -> str:
    """Add carrier, superstructure and boom; return the link at the boom's tip, whose axes are level."""
    unit, parts, (ahead, above) = 0.02 * size, support.superstructure, support.superstructure.foot
    first, second = support.base_section, support.telescope
    add_link(robot, "base_link", _carrier(size, unit))
    add_comment(robot, "slew_link has no mass: on the slew axis it has no effect, and none is simulated")
    inertia = (0.5 * parts.inertia, 0.5 * parts.inertia, parts.inertia)
    add_link(robot, "slew_link", _superstructure(unit), Body(0.0, ORIGIN, inertia))
    root = 2.0 * first.centre if first.centre else 0.5 * length
    thin = (0.0, first.inertia, first.inertia)
    shapes = _boom_section(root, 0.0, 1.3 * unit) + _luffing_cylinder(root, (ahead, above), unit)
    add_link(robot, "boom_link", shapes, Body(first.mass, (first.centre, 0.0, 0.0), thin))
    drawn, thin = min(2.0 * second.centre, length), (0.0, second.inertia, second.inertia)
    body = Body(second.mass, (-second.centre, 0.0, 0.0), thin)
    add_link(robot, "telescope_link", _boom_section(drawn, -drawn, unit), body)
    ElementTree.SubElement(robot, "link", name="tip_link")
    add_joint(robot, "revolute", "slew", ("base_link", "slew_link"), axis=UP)
    add_joint(robot, "revolute", "boom", ("slew_link", "boom_link"), (ahead, 0.0, above), RIGHT)
    root = "boom_link" if bends is None else _add_bent_boom(robot, bends, (ahead, 0.0, above))
    add_joint(robot, "prismatic", "telescope", (root, "telescope_link"), axis=FORWARD)
    add_joint(robot, "revolute", "boom_level", ("telescope_link", "tip_link"), ORIGIN, RIGHT, mimic="boom")
    return "tip_link" if bends is None else _level_bending(robot, bends, "tip_link")


def _add_bent_boom(robot: ElementTree.Element, bends: FlexibleSupport, foot: tuple[float, float, float]) -> str:
    """Add the joints about which the telescoped section bends; return the link that it is on."""
    parent = "boom_link"
    if bends.lateral is not None:
        for name in ("bent_slew_link", "bent_boom_link"):
            ElementTree.SubElement(robot, "link", name=name)
        add_joint(robot, "revolute", "lateral_deflection", ("slew_link", "bent_slew_link"), axis=UP)
        pair, parent = ("bent_slew_link", "bent_boom_link"), "bent_boom_link"
        add_joint(robot, "revolute", "bent_boom", pair, foot, RIGHT, mimic="boom", multiplier=1.0)
    if bends.vertical is None:
        return parent
    ElementTree.SubElement(robot, "link", name="bent_link")
    add_joint(robot, "revolute", "vertical_deflection", (parent, "bent_link"), axis=RIGHT)
    return "bent_link"


def _luffing_cylinder(length: float, foot: tuple[float, float], unit: float) -> list[Shape]:
    """Return the cylinder below a boom, fixed to it as it is at 60 degrees of elevation; `foot` (x, z) of the boom."""
    ahead, below = 1.4 * unit - foot[0], -0.4 * unit - foot[1]
    x, z = 0.5 * ahead + 0.866 * below, -0.866 * ahead + 0.5 * below
    return hydraulic_cylinder((x, z), (min(0.5 * length, 9.0 * unit), -0.7 * unit), 0.4 * unit)


def _boom_section(length: float, start: float, width: float) -> list[Shape]:
    return [Shape((length, width, 1.2 * width), (start + 0.5 * length, 0.0, 0.0), YELLOW)]


def _carrier(size: float, unit: float) -> list[Shape]:
    height, ground = 3.0 * unit, -FOOT_HEIGHT * size
    axles = [
        Shape((0.9 * unit, 0.7 * unit), (x * unit, side * 1.6 * unit, ground + 0.9 * unit), DARK, RPY_ALONG_Y)
        for x in (-4.5, -2.2, 2.2, 4.5)
        for side in (1.0, -1.0)
    ]
    deck = Shape((12.0 * unit, 3.2 * unit, 1.4 * unit), (0.0, 0.0, ground + 0.5 * height), YELLOW)
    column = Shape((1.3 * unit, -ground - height), (0.0, 0.0, 0.5 * (ground + height)), GREY)
    return [deck, column, *axles]


def _superstructure(unit: float) -> list[Shape]:
    return [
        Shape((3.2 * unit, 2.6 * unit, unit), ORIGIN, YELLOW),
        Shape((1.4 * unit, 2.8 * unit, 1.4 * unit), (-2.6 * unit, 0.0, 0.2 * unit), DARK),
        Shape((1.6 * unit, unit, 1.4 * unit), (1.2 * unit, 1.8 * unit, 0.3 * unit), GLASS),
    ]
