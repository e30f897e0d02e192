"""The URDF of cranes whose load hangs on falls: the support, and the load, which moves freely in the base.

Of a gantry, a portal that travels with a trolley on it, the origin of `base_link` is the trolley's rail, where
`trolley` and `bridge` are zero. Other supports are those of cranes with a rope. The falls are no joints: their
ends follow from trolley and load. The load's attitude is a quaternion, which no joints of a URDF can be: its link keeps
the axes of the base here, while a recording turns it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from crane_sim.description.portal import portal_of, portal_visual
from crane_sim.description.robot import DOWN, FORWARD, LEFT, UP, add_joint, add_link
from crane_sim.description.solids import DARK, GREY, ORIGIN, RED, STEEL, YELLOW, Body, Shape, point_mass
from crane_sim.description.suspended import (
    ATTITUDE_JOINT,
    add_drives,
    add_support,
    box_edges,
    products_of,
)
from crane_sim.models.supports.bridge import Bridge

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.models.falls.crane import Falls, FallsCrane
    from crane_sim.models.loads import RigidLoad
    from crane_sim.scenes.scene import Scene

    Array = NDArray[np.float64]

CONCRETE = 2400.0  # kg/m³
FLAT = 0.15  # of a slab's shorter edge: its largest thickness
BOAT = 2.0  # widths: a longer load on falls in a line is drawn as a boat
LINE = 1e-6  # m: ends of falls are in a line within it
WIDTH, HEIGHT, LENGTHS = 2.438, 2.591, (6.058, 12.192)  # m, of containers of 20 and 40 ft (ISO 668)


def add_crane_on_falls(robot: ElementTree.Element, scene: Scene) -> None:
    """Add links and joints of a scene's crane."""
    if isinstance(scene.model.support.structure, Bridge):
        tip = add_gantry(robot, scene)
    else:
        tip = add_support(robot, scene)
        add_head(robot, scene.model.falls, tip)
    ElementTree.SubElement(robot, "link", name="hoist_link")
    add_joint(robot, "prismatic", "hoist", (tip, "hoist_link"), axis=DOWN)
    add_load(robot, scene.model)
    add_drives(robot, scene)


def add_gantry(robot: ElementTree.Element, scene: Scene) -> str:
    """Add portal and trolley; return the link of the trolley."""
    crane: FallsCrane = scene.model
    add_link(robot, "base_link", [])
    add_link(robot, "bridge_link", portal_visual(portal_of(scene)), point_mass(crane.support.structure.bridge.mass))
    add_link(robot, "trolley_link", _gantry_trolley(crane.falls), point_mass(crane.support.structure.trolley.mass))
    add_joint(robot, "prismatic", "bridge", ("base_link", "bridge_link"), axis=LEFT)
    add_joint(robot, "prismatic", "trolley", ("bridge_link", "trolley_link"), axis=FORWARD)
    return "trolley_link"


def add_head(robot: ElementTree.Element, falls: Falls, tip: str) -> None:
    """Add what holds the falls' upper ends at the tip, a plate that stays level."""
    low, high = falls.top.min(axis=0), falls.top.max(axis=0)
    (x, y, z), (a, b, _) = (0.5 * (low + high)).tolist(), (high - low + 0.02 * falls.length).tolist()
    plate = Shape((a, b, 0.01 * falls.length), (x, y, z), STEEL)
    add_link(robot, "head_link", [plate])
    add_joint(robot, "fixed", "head", (tip, "head_link"))


def add_load(robot: ElementTree.Element, crane: FallsCrane) -> None:
    """Add the load with the joints of its position and attitude."""
    parent = "base_link"
    for axis, way in (("x", FORWARD), ("y", LEFT), ("z", UP)):
        child = f"payload_{axis}_link"
        ElementTree.SubElement(robot, "link", name=child)
        add_joint(robot, "prismatic", f"payload_{axis}", (parent, child), axis=way)
        parent = child
    add_joint(robot, "fixed", ATTITUDE_JOINT, (parent, "payload_link"))
    moments = np.diag(np.array(crane.load.inertia))
    body = Body(
        crane.load.mass, ORIGIN, (float(moments[0]), float(moments[1]), float(moments[2])), products_of(crane.load)
    )
    slab = slab_below(crane)
    shapes = spreader_visual(crane.load, crane.falls) if slab is None else slung_visual(slab, crane.falls)
    add_link(robot, "payload_link", shapes, body)


def slab_below(crane: FallsCrane) -> Shape | None:
    """Return the flat load of concrete over the points that touch a surface, None where that would be no flat one.

    The moments of a slab with its hook block high above it are those of a box much higher than it is.
    """
    if crane.contact is None or crane.exchange is not None:
        return None
    points = np.asarray(crane.contact.points)
    low, high = points.min(axis=0), points.max(axis=0)
    a, b = (float(edge) for edge in (high - low)[:2])
    if a * b < 1e-6 or (thick := crane.load.mass / (CONCRETE * a * b)) > FLAT * min(a, b):
        return None
    x, y = (0.5 * (low + high)).tolist()[:2]
    return Shape((a, b, thick), (x, y, float(low[2]) + 0.5 * thick), RED)


def slung_visual(slab: Shape, falls: Falls) -> list[Shape]:
    """Return a slab, four slings from its corners, and the hook block at which they meet."""
    (a, b, thick), (x, y, z) = slab.size, slab.at
    top, spread = falls.bottom.mean(axis=0), np.ptp(falls.bottom[:, :2], axis=0) + 0.2
    hook = Shape(
        (float(spread[0]), float(spread[1]), 0.5), (float(top[0]), float(top[1]), float(top[2]) - 0.25), YELLOW
    )
    corners = [(x + i * 0.45 * a, y + j * 0.45 * b, z + 0.5 * thick) for i in (1, -1) for j in (1, -1)]
    return [slab, hook, *(_sling(np.array(corner), top - (0.0, 0.0, 0.5)) for corner in corners)]


def _sling(start: Array, end: Array) -> Shape:
    """Return a rope between two points (3,)."""
    along = end - start
    length = float(np.linalg.norm(along))
    pitch, yaw = float(np.arccos(along[2] / length)), float(np.arctan2(along[1], along[0]))
    x, y, z = (0.5 * (start + end)).tolist()
    return Shape((0.02, length), (x, y, z), STEEL, (0.0, pitch, yaw))


def container_edges(edges: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the edges [m] of the ISO container that a box lies within a sixth of, otherwise the box's."""
    for length in LENGTHS:
        sizes = (WIDTH, length, HEIGHT)
        if all(abs(edge - size) < size / 6.0 for edge, size in zip(edges, sizes, strict=True)):
            return sizes
    return edges


def spreader_visual(load: RigidLoad, falls: Falls) -> list[Shape]:
    """Return a box of even density with the load's moments, or the container it is, and what the falls hold it by.

    That is a spreader, or where the falls' ends are in a line a lug below each; what is long hangs so as a boat does.
    """
    x, y, z = edges = container_edges(box_edges(load))
    top, (a, b) = float(falls.bottom[:, 2].mean()), np.ptp(falls.bottom[:, :2], axis=0) + 0.3
    shapes = [Shape((x, y, z), ORIGIN, RED)]
    if in_line(falls.bottom[:, :2]):
        return _boat(edges, falls) if x > BOAT * y else shapes + _lugs(falls, 0.5 * z)
    for share in (-0.45, -0.15, 0.15, 0.45):
        shapes.append(Shape((1.02 * x, 0.02 * y, 1.02 * z), (0.0, share * y, 0.0), DARK))
    beam = max(0.5 * (top + 0.5 * z), 0.3)
    shapes.append(Shape((0.5 * x, 0.98 * y, 0.3), (0.0, 0.0, 0.5 * z + 0.2), YELLOW))
    return [*shapes, Shape((float(a), float(b), 0.3 * beam), (0.0, 0.0, top - 0.1), STEEL)]


def in_line(points: Array) -> bool:
    """Return whether points (n, 2) [m] are in a line."""
    return bool(np.linalg.matrix_rank(points - points[0], tol=LINE) < 2)


def _boat(edges: tuple[float, float, float], falls: Falls) -> list[Shape]:
    """Return a hull, narrower at both ends and below, and a canopy, which fill a box with these edges [m]; and lugs."""
    x, y, z = edges
    parts = [(0.7, 1.0, 0.4, -0.05), (1.0, 0.55, 0.35, -0.025), (0.8, 0.6, 0.3, -0.35)]
    hull = [Shape((a * x, b * y, c * z), (0.0, 0.0, at * z), RED) for a, b, c, at in parts]
    canopy = Shape((0.6 * x, 0.8 * y, 0.35 * z), (0.0, 0.0, 0.325 * z), YELLOW)
    return [*hull, canopy, *_lugs(falls, 0.15 * z)]


def _lugs(falls: Falls, top: float) -> list[Shape]:
    """Return a lug between the top of a load [m] and the lower end of each fall."""
    ends = [tuple(map(float, end)) for end in falls.bottom]
    return [Shape((0.3, 0.3, max(abs(z - top), 0.2)), (x, y, 0.5 * (top + z)), YELLOW) for x, y, z in ends]


def _gantry_trolley(falls: Falls) -> list[Shape]:
    a, b = (float(part) for part in np.ptp(falls.top[:, :2], axis=0) + 1.0)
    return [Shape((a, b, 0.5), (0.0, 0.0, 0.4), DARK), Shape((0.6 * a, 0.5 * b, 0.8), (0.0, 0.0, 1.0), GREY)]
