"""The URDF of an overhead crane: a trolley below a rail along x, a bridge along y, and a cable.

`base_link` has its origin on the rail's line, at the height of the cable's upper end. Frames
`node_1` .. `node_<N-1>` and `payload_link` are the nodes of the cable. All masses are point masses,
those of the scene; only the cable's links have moments of inertia.
"""

from __future__ import annotations

from math import atan2, cbrt, hypot

from crane_sim.description.cables import SuspendedCable, add_cable
from crane_sim.description.robot import FORWARD, LEFT, Robot
from crane_sim.description.solids import (
    DARK,
    GREY,
    ORIGIN,
    RPY_ALONG_Y,
    STEEL,
    YELLOW,
    Body,
    Shape,
    payload_box,
    point_mass,
)
from crane_sim.description.workspace import BoundingBox, estimate_bounding_box, validated_scene_file
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.axes import AxisGroup


def add_overhead_crane(robot: Robot, scene: Scene) -> None:
    """Add links and joints: those of the scene, and the mimic joints of the cable."""
    box, config = estimate_bounding_box(scene), validated_scene_file(scene)
    robot.link("base_link", base(box))
    parent = "base_link"
    if box.spatial:
        robot.link("bridge_link", bridge(box), _axis_body(config.bridge))
        robot.slide("bridge", parent, "bridge_link", LEFT)
        parent = "bridge_link"
    robot.link("trolley_link", trolley(box), _axis_body(config.trolley))
    robot.slide("trolley", parent, "trolley_link", FORWARD)
    cable = SuspendedCable.from_scene(scene)
    add_cable(robot, scene.joint_names, cable, box)
    _add_nodes(robot, cable, box)
    if config.hoist is not None and config.hoist.inertia:
        drum = f"hoist.inertia = {config.hoist.inertia:g} kg, reflected mass of the drum"
        # as no link can have it
        robot.comment(f"{drum}: adds to this joint only, to no link", "hoist")


def _add_nodes(robot: Robot, cable: SuspendedCable, box: BoundingBox) -> None:
    """Add the nodes at the lower ends of the cable's links: balls, and the payload."""
    for name, mass, length in zip(cable.end_link_names, cable.masses, cable.lengths, strict=True):
        if name == "payload_link":
            robot.link(name, payload(mass, box), point_mass(mass))
        else:
            radius = node_radius(mass, length, box)
            robot.link(name, [node(radius)], point_mass(mass) if mass > 0.0 else None)


def _axis_body(group: AxisGroup | None) -> Body | None:
    """Return the body of trolley or bridge; None without a mass, which only force drives need."""
    mass = group.mass if group is not None else None
    return point_mass(mass) if mass else None


LOAD_DENSITY, NODE_DENSITY = 2400.0, 7800.0  # kg/m³, of concrete and of steel


def base(box: BoundingBox) -> list[Shape]:
    """Return the fixed structure: a beam on trestles or, below a bridge, runways on columns."""
    return _runways(box) if box.spatial else _portal(box)


def bridge(box: BoundingBox) -> list[Shape]:
    """Return the girder along x that carries the trolley, with its end carriages, at y = 0."""
    unit = box.unit
    left, right = box.rail(0)
    shapes = _girder(left - 0.3 * unit, right + 0.3 * unit, unit)
    for end in (left, right):
        shapes.append(Shape((0.3 * unit, 1.6 * unit, 0.3 * unit), (end, 0.0, 0.02 * unit), DARK))
    return shapes


def trolley(box: BoundingBox) -> list[Shape]:
    """Return the trolley: a sheave where the cable begins, side plates, wheels, a base plate.

    The four wheels are on the beam's lower flange.
    """
    unit = box.unit
    shapes = [Shape((0.13 * unit, 0.3 * unit), ORIGIN, STEEL, RPY_ALONG_Y)]
    for side in (1.0, -1.0):
        shapes.append(
            Shape(
                (0.9 * unit, 0.05 * unit, 0.5 * unit), (0.0, side * 0.23 * unit, 0.2 * unit), GREY
            )
        )
        for x in (0.28 * unit, -0.28 * unit):
            shapes.append(
                Shape(
                    (0.11 * unit, 0.09 * unit),
                    (x, side * 0.13 * unit, 0.365 * unit),
                    STEEL,
                    RPY_ALONG_Y,
                )
            )
    return [*shapes, Shape((0.7 * unit, 0.5 * unit, 0.08 * unit), (0.0, 0.0, 0.1 * unit), DARK)]


def payload_edge(mass: float, box: BoundingBox) -> float:
    """Return the payload's edge [m]: a concrete cube's, within 4.5 to 13 % of the depth."""
    return min(max(cbrt(mass / LOAD_DENSITY), 0.045 * box.depth), 0.13 * box.depth)


def payload(mass: float, box: BoundingBox) -> list[Shape]:
    """Return the payload."""
    return payload_box(payload_edge(mass, box))


def node_radius(mass: float, link: float, box: BoundingBox) -> float:
    """Return the radius [m] of a node's ball below a link [m]: a steel ball's, kept visible."""
    return min(
        max(cbrt(0.75 * mass / (3.1416 * NODE_DENSITY)), 0.008 * box.depth),
        0.02 * box.depth,
        0.3 * link,
    )


def node(radius: float) -> Shape:
    """Return the ball of a node."""
    return Shape((radius,), ORIGIN, STEEL)


def _girder(left: float, right: float, unit: float) -> list[Shape]:
    """Return an I-beam along x; its lower edge is where the trolley's wheels expect it."""
    middle, length = 0.5 * (left + right), right - left
    return [
        Shape((length, 0.36 * unit, 0.07 * unit), (middle, 0.0, 0.22 * unit), YELLOW),
        Shape((length, 0.1 * unit, 0.5 * unit), (middle, 0.0, 0.48 * unit), YELLOW),
        Shape((length, 0.36 * unit, 0.07 * unit), (middle, 0.0, 0.74 * unit), YELLOW),
    ]


def _portal(box: BoundingBox) -> list[Shape]:
    unit = box.unit
    left, right = box.rail(0)
    shapes = _girder(left, right, unit)
    for end in (left, right):
        shapes.append(Shape((0.24 * unit, 0.75 * unit, 0.7 * unit), (end, 0.0, 0.48 * unit), DARK))
        shapes += _trestle(end, 0.74 * unit, box.floor, max(unit, box.depth / 8.0))
    return shapes


def _trestle(x: float, top: float, floor: float, unit: float) -> list[Shape]:
    foot, head = 1.5 * unit, 0.25 * unit
    height, spread = top - floor, foot - head
    leg = (0.2 * unit, 0.2 * unit, hypot(height, spread))
    shapes = []
    for side in (1.0, -1.0):
        lean = (side * atan2(spread, height), 0.0, 0.0)
        shapes.append(Shape(leg, (x, side * 0.5 * (foot + head), 0.5 * (top + floor)), GREY, lean))
        shapes.append(
            Shape((0.5 * unit, 0.4 * unit, 0.1 * unit), (x, side * foot, floor + 0.05 * unit), DARK)
        )
    return shapes


def _runways(box: BoundingBox) -> list[Shape]:
    unit, (near, far) = box.unit, box.rail(1)
    top, length = -0.13 * unit, far - near + 1.6 * unit
    shapes = []
    for x in box.rail(0):
        shapes.append(
            Shape(
                (0.24 * unit, length, 0.4 * unit), (x, 0.5 * (near + far), top - 0.2 * unit), GREY
            )
        )
        for y in (near, far):
            height = top - 0.4 * unit - box.floor
            shapes.append(
                Shape((0.24 * unit, 0.24 * unit, height), (x, y, box.floor + 0.5 * height), GREY)
            )
            shapes.append(
                Shape((0.6 * unit, 0.6 * unit, 0.1 * unit), (x, y, box.floor + 0.05 * unit), DARK)
            )
    return shapes
