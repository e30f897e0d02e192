"""The URDF of cranes with a load on falls: the support, and the load, which moves freely.

Of a gantry, a portal that travels with a trolley on it, the origin of `base_link` is the trolley's
rail, where `trolley` and `bridge` are zero. Other supports are those of cranes with a rope. The
falls are no joints: their ends follow from trolley and load. The load's attitude is a quaternion,
which no joints of a URDF can be: its link keeps the axes of the base here, while a recording turns
it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crane_sim.description.cables import AXES
from crane_sim.description.robot import DOWN, Robot
from crane_sim.description.solids import (
    DARK,
    GREY,
    ORIGIN,
    RED,
    STEEL,
    YELLOW,
    Shape,
    point_mass,
    tube,
)
from crane_sim.description.suspended import (
    ATTITUDE_JOINT,
    add_axes,
    add_drives,
    add_support,
    body_of,
    box_edges,
    contact_height,
    hung_length,
)
from crane_sim.description.workspace import axis_positions
from crane_sim.models.falls.crane import Falls, FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.supports.bridge import Bridge
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.supports import GantryGroups

Array = NDArray[np.float64]


CONCRETE = 2400.0  # kg/m³
FLAT = 0.15  # of a slab's shorter edge: its largest thickness
BOAT = 2.0  # widths: a longer load on falls in a line is drawn as a boat
LINE = 1e-6  # m: ends of falls are in a line within it
WIDTH, HEIGHT, LENGTHS = 2.438, 2.591, (6.058, 12.192)  # m, of containers of 20 and 40 ft (ISO 668)


def add_crane_on_falls(robot: Robot, scene: Scene) -> None:
    """Add links and joints of a scene's crane."""
    if isinstance(scene.model.support.structure, Bridge):
        tip = _add_gantry(robot, scene)
    else:
        tip = add_support(robot, scene)
        add_head(robot, scene.model.falls, tip)
    robot.slide("hoist", tip, "hoist_link", DOWN)
    add_load(robot, scene.model)
    add_drives(robot, scene)


def _add_gantry(robot: Robot, scene: Scene) -> str:
    """Add portal and trolley; return the link of the trolley."""
    crane: FallsCrane = scene.model
    robot.link(
        "bridge_link",
        portal_visual(portal_of(scene)),
        point_mass(crane.support.structure.bridge.mass),
    )
    robot.link(
        "trolley_link",
        _gantry_trolley(crane.falls),
        point_mass(crane.support.structure.trolley.mass),
    )
    return add_axes(robot)


def add_head(robot: Robot, falls: Falls, tip: str) -> None:
    """Add what holds the falls' upper ends at the tip, a plate that stays level."""
    low, high = falls.top.min(axis=0), falls.top.max(axis=0)
    (x, y, z), (a, b, _) = (
        (0.5 * (low + high)).tolist(),
        (high - low + 0.02 * falls.length).tolist(),
    )
    robot.link("head_link", [Shape((a, b, 0.01 * falls.length), (x, y, z), STEEL)])
    robot.fix("head", tip, "head_link")


def add_load(robot: Robot, crane: FallsCrane) -> None:
    """Add the load with the joints of its position and attitude."""
    parent = "base_link"
    for axis, way in AXES.items():
        robot.slide(f"payload_{axis}", parent, f"payload_{axis}_link", way)
        parent = f"payload_{axis}_link"
    robot.fix(ATTITUDE_JOINT, parent, "payload_link")
    slab = slab_below(crane)
    shapes = (
        spreader_visual(crane.load, crane.falls)
        if slab is None
        else slung_visual(slab, crane.falls)
    )
    robot.link("payload_link", shapes, body_of(crane.load, ORIGIN))


def slab_below(crane: FallsCrane) -> Shape | None:
    """Return the flat concrete load over the points that touch a surface, None if not flat.

    The moments of a slab with its hook block high above it are those of a box much higher than it
    is.
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
        (*spread.tolist(), 0.5), (float(top[0]), float(top[1]), float(top[2]) - 0.25), YELLOW
    )
    corners = [
        (x + i * 0.45 * a, y + j * 0.45 * b, z + 0.5 * thick) for i in (1, -1) for j in (1, -1)
    ]
    return [slab, hook, *(_sling(np.array(corner), top - (0.0, 0.0, 0.5)) for corner in corners)]


def _sling(start: Array, end: Array) -> Shape:
    """Return a rope between two points (3,)."""
    along = end - start
    length = float(np.linalg.norm(along))
    pitch, yaw = float(np.arccos(along[2] / length)), float(np.arctan2(along[1], along[0]))
    x, y, z = (0.5 * (start + end)).tolist()
    return Shape((0.02, length), (x, y, z), STEEL, (0.0, pitch, yaw))


def container_edges(edges: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return an ISO container's edges [m] if a box is within a sixth of them, else the box's."""
    for length in LENGTHS:
        sizes = (WIDTH, length, HEIGHT)
        if all(abs(edge - size) < size / 6.0 for edge, size in zip(edges, sizes, strict=True)):
            return sizes
    return edges


def spreader_visual(load: RigidLoad, falls: Falls) -> list[Shape]:
    """Return a box of even density with the load's moments, or a container, and what holds it.

    That is a spreader, or where the falls' ends are in a line a lug below each; what is long hangs
    so as a boat does.
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
    """Return hull, canopy and lugs that fill a box with these edges [m].

    The hull is narrower at both ends and below.
    """
    x, y, z = edges
    parts = [(0.7, 1.0, 0.4, -0.05), (1.0, 0.55, 0.35, -0.025), (0.8, 0.6, 0.3, -0.35)]
    hull = [Shape((a * x, b * y, c * z), (0.0, 0.0, at * z), RED) for a, b, c, at in parts]
    canopy = Shape((0.6 * x, 0.8 * y, 0.35 * z), (0.0, 0.0, 0.325 * z), YELLOW)
    return [*hull, canopy, *_lugs(falls, 0.15 * z)]


def _lugs(falls: Falls, top: float) -> list[Shape]:
    """Return a lug between the top of a load [m] and the lower end of each fall."""
    ends = [tuple(map(float, end)) for end in falls.bottom]
    return [
        Shape((0.3, 0.3, max(abs(z - top), 0.2)), (x, y, 0.5 * (top + z)), YELLOW)
        for x, y, z in ends
    ]


def _gantry_trolley(falls: Falls) -> list[Shape]:
    a, b = (float(part) for part in np.ptp(falls.top[:, :2], axis=0) + 1.0)
    return [
        Shape((a, b, 0.5), (0.0, 0.0, 0.4), DARK),
        Shape((0.6 * a, 0.5 * b, 0.8), (0.0, 0.0, 1.0), GREY),
    ]


MAST = 0.38  # of the boom's length: height of the mast above the girders
STAYED = (0.45, 0.93)  # of the boom's length: where its forestays are fixed


class Portal(NamedTuple):
    """Sizes [m] of the structure; x along the rail, which is between two girders, z from it."""

    ends: tuple[float, float]  # x, of the girders
    legs: tuple[float, float]  # x, of the pairs of legs
    depth: float  # of the ground below the rail
    half_gauge: float  # y of the girders, which carry the rails, from the middle
    half_span: float  # y of the legs from the middle

    @property
    def unit(self) -> float:
        """A typical thickness [m]."""
        return self.depth / 30.0

    @property
    def leg_top(self) -> float:
        """Height [m] of the legs' upper ends, above the girders."""
        return 1.0 + 1.8 * self.unit

    @property
    def boom(self) -> tuple[float, float] | None:
        """Where the boom begins and ends, x [m]; None if no side is longer than the legs' span."""
        (left, right), (near, far) = self.ends, self.legs
        if max(near - left, right - far) <= far - near:
            return None
        return (near, left) if near - left > right - far else (far, right)

    @property
    def top(self) -> float:
        """Height [m] of the highest part."""
        return self.leg_top + (
            0.0 if self.boom is None else MAST * abs(self.boom[1] - self.boom[0])
        )


def depth_of(scene: Scene) -> float:
    """Return the drawn ground's depth [m] below the rail: a contact's surface, else below all."""
    surface = contact_height(scene)
    return -surface if surface is not None else 1.2 * hung_length(scene)


def portal_of(scene: Scene) -> Portal:
    """Return a gantry's structure: between its legs, and over all that the trolley reaches."""
    file = scene.file
    assert isinstance(file, GantryGroups)
    depth, limits = depth_of(scene), scene.model.support.structure.trolley.limits
    places = [*axis_positions(scene, "trolley"), *(limits or ()), *(file.legs or ())]
    beyond = 0.15 * depth if file.legs else 0.4 * depth
    left, right = min(places) - beyond, max(places) + beyond
    unit = depth / 30.0
    if file.legs is None:
        return Portal(
            (left, right), (left + 2.0 * unit, right - 2.0 * unit), depth, 4.5 * unit, 4.5 * unit
        )
    # so that the load passes between them
    half_span = max(4.5 * unit, 0.75 * box_edges(scene.model.load)[1])
    return Portal((left, right), file.legs, depth, 4.5 * unit, half_span)


def portal_visual(portal: Portal) -> list[Shape]:
    """Return two girders along x on four legs, and what holds a boom."""
    (left, right), unit = portal.ends, portal.unit
    shapes: list[Shape] = []
    for side in (1.0, -1.0):
        at = (0.5 * (left + right), side * portal.half_gauge, 1.0)
        shapes.append(Shape((right - left, unit, 1.6 * unit), at, YELLOW))
        for x in portal.legs:
            shapes += _leg(x, side * portal.half_span, portal)
    return shapes if portal.boom is None else shapes + _frame(portal) + _mast(portal, *portal.boom)


def _leg(x: float, y: float, portal: Portal) -> list[Shape]:
    unit, top = portal.unit, 0.0 if portal.boom is None else portal.leg_top
    return [
        Shape((unit, unit, top + portal.depth), (x, y, 0.5 * (top - portal.depth)), GREY),
        Shape((2.5 * unit, 1.4 * unit, unit), (x, y, 0.5 * unit - portal.depth), DARK),
    ]


def _frame(portal: Portal) -> list[Shape]:
    """Return the beams between the legs.

    They run along the quay low down and above the girders, and across it in the middle.
    """
    unit, (near, far), width = portal.unit, portal.legs, 2.0 * portal.half_span
    shapes = [
        Shape((unit, width, unit), (x, 0.0, z), GREY)
        for x in portal.legs
        for z in (2.5 * unit - portal.depth, portal.leg_top - 0.5 * unit)
    ]
    for side in (1.0, -1.0):
        at = (0.5 * (near + far), side * portal.half_span, -0.55 * portal.depth)
        shapes.append(Shape((far - near, unit, 1.4 * unit), at, GREY))
    return shapes


def _mast(portal: Portal, root: float, tip: float) -> list[Shape]:
    """Return the mast above the legs at the boom's start, its stays, and the machinery house.

    The house is at the other end.
    """
    unit, (near, far) = portal.unit, portal.legs
    other = far if root == near else near
    out = 1.0 if tip > root else -1.0
    apex, beam = (root, portal.top), 1.0 + 0.8 * unit
    feet = [*((root + share * (tip - root), beam) for share in STAYED), (other, portal.leg_top)]
    girder = (0.8 * unit, 2.0 * portal.half_gauge + unit, 0.8 * unit)
    shapes = [Shape(girder, (root, 0.0, portal.top), YELLOW)]
    for y in (portal.half_gauge, -portal.half_gauge):
        stays = [tube(apex, foot, 0.18 * unit, STEEL) for foot in feet]
        post = Shape(
            (unit, 0.8 * unit, portal.top - portal.leg_top),
            (root, 0.0, 0.5 * (portal.top + portal.leg_top)),
            YELLOW,
        )
        shapes += [shape._replace(at=(shape.at[0], y, shape.at[2])) for shape in (*stays, post)]
    house = (0.35 * (far - near), 1.6 * portal.half_gauge, 4.0 * unit)
    return [
        *shapes,
        Shape(
            house, (other + 0.1 * out * (far - near), 0.0, portal.leg_top + 0.5 * house[2]), GREY
        ),
    ]
