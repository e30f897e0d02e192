"""The URDF of cranes with a suspended cable: support, rope, swing, further links, payload.

The support's part is that of cranes with falls as well.

The origin of `base_link` is the model's: at the height of the jib's underside on the tower's axis,
on the slewing axis of a mobile crane, or on the trolley's rail. Further links are unit vectors in
the axes of the base, so joints `level_*` undo the turns of rope and slew. A payload's attitude is
four components of a quaternion, which no joints of a URDF can be: its link keeps the axes of the
base here, while a recording turns it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crane_sim.description.cables import SuspendedCable, add_vector_links
from crane_sim.description.knuckle import add_knuckle_boom, add_swing, pedestal_height
from crane_sim.description.robot import DOWN, FORWARD, LEFT, RIGHT, UP, Robot
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
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene

MAST_HEIGHT, COUNTER_JIB = 1.3, 0.3  # of a tower crane's size: drawn, not modelled
ATTITUDE_JOINT = "attitude"
"""The fixed joint above a payload with an attitude, which a recording turns."""
MASSLESS = "slew_link has no mass: on the slew axis it has no effect, and none is simulated"
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
    """Return the length [m] of what hangs: rope and further links, or falls and their load."""
    falls = getattr(scene.model, "falls", None)
    if falls is None:
        return float(np.sum(scene.model.cable.lengths))
    return float(falls.length + 2.0 * abs(falls.bottom[:, 2].mean()))


def contact_height(scene: Scene) -> float | None:
    """Return the height [m] of the surface that can bear a load, None for cranes without one."""
    contact = getattr(scene.model, "contact", None)
    if contact is None:
        return None
    return float(
        contact.surface.height if contact.changes is None else contact.changes.heights.min()
    )


def ground_height(scene: Scene) -> float:
    """Return the height [m] of the drawn ground, below all: a contact's surface, if any."""
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


def add_suspended_crane(robot: Robot, scene: Scene) -> None:
    """Add links and joints of a scene's crane."""
    add_swing(robot, add_support(robot, scene))
    _add_rigging(robot, scene.model, scene.joint_names, crane_size(scene))
    add_drives(robot, scene)


def add_support(robot: Robot, scene: Scene) -> str:
    """Add a support's links and joints; return the link at its tip, whose axes are level."""
    support, size = scene.model.support.structure, crane_size(scene)
    bends, rigid = support if isinstance(support, FlexibleSupport) else None, rigid_support(support)
    if isinstance(support, SwayingTower):
        return _add_swaying_tower(robot, support, size, ground_height(scene))
    if isinstance(rigid, Bridge):
        return _add_bridge(robot, rigid, scene, size)
    if isinstance(rigid, TowerCrane):
        return _add_tower(robot, rigid, bends, size, ground_height(scene))
    if isinstance(rigid, Knuckle):
        return add_knuckle_boom(robot, rigid, scene.joint_names[:3])
    return _add_boom(robot, rigid, bends, size, scene.initial_q[2])


def _add_rigging(robot: Robot, crane: SuspendedCrane, joints: Sequence[str], size: float) -> None:
    """Add the rope's length, further links and the payload."""
    end = "rope_end_link"
    robot.slide("rope", "rope_link", end, DOWN)
    turns = {
        "swing_radial": RIGHT,
        "swing_tangential": FORWARD,
        "lateral_deflection": UP,
        "slew": UP,
    }
    for joint in (name for name in turns if name in joints):
        end = robot.level(joint, end, turns[joint])
    masses, last = add_nodes(robot, crane, 0.012 * size)
    robot.fix("hook", end, "node_1" if masses[1:] else last)
    if masses[1:]:
        cable = SuspendedCable(tuple(crane.cable.lengths[1:].tolist()), masses[1:])
        add_vector_links(robot, cable, False, "node_1", 2, last)
    add_payload(robot, crane, last, size)


def add_nodes(robot: Robot, crane: SuspendedCrane, unit: float) -> tuple[tuple[float, ...], str]:
    """Add the nodes between the links; return all masses, and the link where the payload hangs.

    The nodes are hook blocks of the size `unit` [m].
    """
    masses = (*crane.cable.masses[:-1].tolist(), crane.load.mass)
    for k, mass in enumerate(masses[:-1], start=1):
        robot.link(f"node_{k}", hook_block(unit), point_mass(mass))
    return masses, "attachment_link" if isinstance(crane.load, RigidLoad) else "payload_link"


def add_payload(robot: Robot, crane: SuspendedCrane, last: str, size: float) -> None:
    """Add the payload, below the link `last` where a body hangs."""
    load = crane.load
    if not isinstance(load, RigidLoad):
        edge = min(max((load.mass / 2400.0) ** (1.0 / 3.0), 0.02 * size), 0.1 * size)
        robot.link("payload_link", payload_box(edge), point_mass(load.mass))
        return
    robot.fix(ATTITUDE_JOINT, last, "payload_link")
    a, b, c = (-float(x) for x in load.attachment)
    x, y, z = box_edges(load)
    band = (1.01 * x, 0.06 * y, 1.01 * z)
    bands = [Shape(band, (a, b + share * y, c), DARK) for share in (0.35, -0.35)]
    robot.link("payload_link", [Shape((x, y, z), (a, b, c), RED), *bands], body_of(load, (a, b, c)))


def add_drives(robot: Robot, scene: Scene) -> None:
    """Add positions of drives with play, reflected to their joints, as links without children."""
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    for name in (name for name in scene.joint_names if "_drive_" in name):
        add = robot.slide if units[name] == "m" else robot.turn
        add(
            name,
            "base_link",
            f"{name}_link",
            {"bridge": LEFT, "slew": UP}.get(name.partition("_")[0], FORWARD),
        )


def add_axes(robot: Robot) -> str:
    """Add the joints of a bridge, or a portal, and its trolley; return the link of the trolley."""
    robot.slide("bridge", "base_link", "bridge_link", LEFT)
    robot.slide("trolley", "bridge_link", "trolley_link", FORWARD)
    return "trolley_link"


def body_of(load: RigidLoad, centre: tuple[float, float, float]) -> Body:
    """Return the body of a load with its centre of mass at a point of its link."""
    tensor = np.array(load.inertia)
    moments, products = np.diag(tensor).tolist(), tensor[(0, 0, 1), (1, 2, 2)].tolist()
    return Body(load.mass, centre, tuple(moments), tuple(products))


def box_edges(load: RigidLoad) -> tuple[float, float, float]:
    """Return the edges [m] of the box of even density that has a load's moments of inertia."""
    moments = np.diag(np.array(load.inertia))
    x, y, z = (
        float(edge)
        for edge in np.sqrt(np.maximum(12.0 * (0.5 * moments.sum() - moments) / load.mass, 1e-6))
    )
    return x, y, z


def hook_block(unit: float) -> list[Shape]:
    """Return the solids of a hook block whose size is some `unit` [m]."""
    return [
        Shape((0.9 * unit, 0.5 * unit), ORIGIN, STEEL, RPY_ALONG_Y),
        Shape((0.9 * unit, 0.5 * unit, 1.6 * unit), (0.0, 0.0, -0.3 * unit), YELLOW),
    ]


def _foot(unit: float, ground: float) -> Shape:
    return Shape((5.0 * unit, 5.0 * unit, unit), (0.0, 0.0, ground + 0.5 * unit), GREY)


def _add_tower(
    robot: Robot, support: TowerCrane, bends: FlexibleSupport | None, size: float, ground: float
) -> str:
    """Add mast, jib and trolley; return the link where the rope begins.

    `bends`: what bends, None of a rigid crane.
    """
    unit, inertia = 0.02 * size, getattr(support.slew, "inertia", 0.0)
    mast = Shape((1.6 * unit, 1.6 * unit, -ground), (0.0, 0.0, 0.5 * ground), YELLOW)
    robot.link("base_link", [mast, _foot(unit, ground)])
    robot.turn("slew", "base_link", "slew_link", UP)
    if bends is not None:
        return _add_bent_jib(robot, bends, size, unit)
    robot.comment(MASSLESS)
    jib = [_truss(-COUNTER_JIB * size, size, unit), *_tower_head(size, unit)]
    robot.link("slew_link", jib, Body(0.0, ORIGIN, (0.5 * inertia, 0.5 * inertia, inertia)))
    return _add_jib_trolley(robot, "slew_link", support.trolley.mass, unit)


def _add_jib_trolley(robot: Robot, jib: str, mass: float, unit: float) -> str:
    robot.link("trolley_link", _jib_trolley(unit), point_mass(mass))
    robot.slide("trolley", jib, "trolley_link", FORWARD)
    return "trolley_link"


def _add_swaying_tower(robot: Robot, tower: SwayingTower, size: float, ground: float) -> str:
    """Add mast, on a universal joint, jib and trolley; return the link where the rope begins.

    Its axes are level.
    """
    unit, h = 0.02 * size, tower.height
    masses, places = np.array(tower.masses), np.array(tower.places)
    depth = max(-ground - h, unit)
    below = Shape((1.6 * unit, 1.6 * unit, depth), (0.0, 0.0, 0.5 * (ground - h)), YELLOW)
    robot.link("base_link", [_foot(unit, ground), below])
    robot.link("mast_link", [Shape((1.6 * unit, 1.6 * unit, h), (0.0, 0.0, 0.5 * h), YELLOW)])
    centre = float(masses @ places / masses.sum())
    turning = float(masses @ (places - centre) ** 2)
    jib = [_truss(-COUNTER_JIB * size, size, unit), *_tower_head(size, unit)]
    body = Body(float(masses.sum()), (centre, 0.0, 0.0), (0.0, turning, turning))
    robot.link("slew_link", jib, body)
    robot.turn("mast_x_deflection", "base_link", "mast_joint_link", FORWARD, (0.0, 0.0, -h))
    robot.turn("mast_y_deflection", "mast_joint_link", "mast_link", LEFT)
    robot.turn("slew", "mast_link", "slew_link", UP, (0.0, 0.0, h))
    last = _add_jib_trolley(robot, "slew_link", tower.support.trolley.mass, unit)
    undone = [
        ("slew", UP, -1.0),
        ("mast_y_deflection", LEFT, -1.0),
        ("mast_x_deflection", FORWARD, -1.0),
    ]
    for k, (joint, axis, sign) in enumerate([*undone, ("slew", UP, 1.0)]):
        robot.turn(f"level_mast_{k}", last, f"level_{k}_link", axis, mimic=joint, multiplier=sign)
        last = f"level_{k}_link"
    return last


def _add_bent_jib(robot: Robot, bends: FlexibleSupport, size: float, unit: float) -> str:
    """Add counter-jib, jib and trolley; return the link where the rope begins, in level axes."""
    section, rod = bends.inner.base_section, bends.outer.base_section
    counter = [_truss(-COUNTER_JIB * size, 0.0, unit), *_tower_head(size, unit)]
    robot.link("slew_link", counter, Body(section.mass, (section.centre, 0.0, 0.0), ORIGIN))
    robot.link("jib_link", [_truss(0.0, size, unit)], _thin(rod.mass, rod.centre, rod.inertia))
    _add_bending(robot, bends, "slew_link", "jib_link")
    return _level_bending(
        robot, bends, _add_jib_trolley(robot, "jib_link", bends.outer.telescope.mass, unit)
    )


def _thin(mass: float, centre: float, inertia: float) -> Body:
    """Return the body of a thin rod along x."""
    return Body(mass, (centre, 0.0, 0.0), (0.0, inertia, inertia))


def _add_bending(robot: Robot, bends: FlexibleSupport, parent: str, child: str) -> None:
    """Add the joints of the modes of bending between two links that have the same origin."""
    if bends.lateral is not None:
        last = child if bends.vertical is None else "bent_link"
        robot.turn("lateral_deflection", parent, last, UP)
        parent = last
    if bends.vertical is not None:
        robot.turn("vertical_deflection", parent, child, RIGHT)


def _level_bending(robot: Robot, bends: FlexibleSupport, parent: str) -> str:
    """Return the link of the parent's origin that bending in the structure's plane leaves level."""
    if bends.vertical is None:
        return parent
    robot.turn("level_deflection", parent, "level_link", RIGHT, mimic="vertical_deflection")
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


def _add_bridge(robot: Robot, support: Bridge, scene: Scene, size: float) -> str:
    """Add bridge and trolley; return the link of the trolley."""
    unit = 0.03 * size
    left, right = bridge_reach(scene, size)
    girder = Shape(
        (right - left, unit, 1.6 * unit), (0.5 * (left + right), 0.0, 1.6 * unit), YELLOW
    )
    carriages = [
        Shape((unit, 6.0 * unit, unit), (end, 0.0, 1.2 * unit), DARK) for end in (left, right)
    ]
    robot.link("base_link", _runway(scene, (left, right), unit, ground_height(scene)))
    robot.link("bridge_link", [girder, *carriages], point_mass(support.axes[1].mass))
    robot.link("trolley_link", _jib_trolley(unit), point_mass(support.trolley.mass))
    return add_axes(robot)


def _runway(scene: Scene, ends: tuple[float, float], unit: float, ground: float) -> list[Shape]:
    """Return two beams for a bridge, below the `ends` [m] of its girder, each on two columns."""
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


def _add_boom(
    robot: Robot, support: TelescopicBoom, bends: FlexibleSupport | None, size: float, length: float
) -> str:
    """Add carrier, superstructure and boom; return the boom's tip link, with level axes."""
    unit, parts, (ahead, above) = 0.02 * size, support.superstructure, support.superstructure.foot
    first, second, foot = support.base_section, support.telescope, (ahead, 0.0, above)
    robot.link("base_link", _carrier(size, unit))
    robot.comment(MASSLESS)
    moments = (0.5 * parts.inertia, 0.5 * parts.inertia, parts.inertia)
    robot.link("slew_link", _superstructure(unit), Body(0.0, ORIGIN, moments))
    root = 2.0 * first.centre if first.centre else 0.5 * length
    shapes = _boom_section(root, 0.0, 1.3 * unit) + _luffing_cylinder(root, (ahead, above), unit)
    robot.link("boom_link", shapes, _thin(first.mass, first.centre, first.inertia))
    drawn = min(2.0 * second.centre, length)
    telescope = _thin(second.mass, -second.centre, second.inertia)
    robot.link("telescope_link", _boom_section(drawn, -drawn, unit), telescope)
    robot.turn("slew", "base_link", "slew_link", UP)
    robot.turn("boom", "slew_link", "boom_link", RIGHT, foot)
    section = "boom_link" if bends is None else _add_bent_boom(robot, bends, foot)
    robot.slide("telescope", section, "telescope_link", FORWARD)
    robot.turn("boom_level", "telescope_link", "tip_link", RIGHT, mimic="boom")
    return "tip_link" if bends is None else _level_bending(robot, bends, "tip_link")


def _add_bent_boom(robot: Robot, bends: FlexibleSupport, foot: tuple[float, float, float]) -> str:
    """Add the joints about which the telescoped section bends; return the link that it is on."""
    parent = "boom_link"
    if bends.lateral is not None:
        robot.turn("lateral_deflection", "slew_link", "bent_slew_link", UP)
        robot.turn(
            "bent_boom",
            "bent_slew_link",
            "bent_boom_link",
            RIGHT,
            foot,
            mimic="boom",
            multiplier=1.0,
        )
        parent = "bent_boom_link"
    if bends.vertical is None:
        return parent
    robot.turn("vertical_deflection", parent, "bent_link", RIGHT)
    return "bent_link"


def _luffing_cylinder(length: float, foot: tuple[float, float], unit: float) -> list[Shape]:
    """Return the cylinder below a boom, fixed as at 60 degrees of elevation.

    `foot` is the boom's, (x, z).
    """
    ahead, below = 1.4 * unit - foot[0], -0.4 * unit - foot[1]
    x, z = 0.5 * ahead + 0.866 * below, -0.866 * ahead + 0.5 * below
    return hydraulic_cylinder((x, z), (min(0.5 * length, 9.0 * unit), -0.7 * unit), 0.4 * unit)


def _boom_section(length: float, start: float, width: float) -> list[Shape]:
    return [Shape((length, width, 1.2 * width), (start + 0.5 * length, 0.0, 0.0), YELLOW)]


def _carrier(size: float, unit: float) -> list[Shape]:
    height, ground = 3.0 * unit, -FOOT_HEIGHT * size
    axles = [
        Shape(
            (0.9 * unit, 0.7 * unit),
            (x * unit, side * 1.6 * unit, ground + 0.9 * unit),
            DARK,
            RPY_ALONG_Y,
        )
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
