"""What the trolley of a gantry crane runs on: a portal, or the portal and the boom of a ship-to-shore crane.

A scene's `legs` say where it stands. Where the rail reaches further beyond them than they are apart, that part is a
boom held by forestays from a mast; otherwise the structure is a bare portal.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from crane_sim.description.solids import DARK, GREY, STEEL, YELLOW, Shape, tube
from crane_sim.description.suspended import box_edges, contact_height, hung_length
from crane_sim.description.workspace import axis_positions
from crane_sim.scenes.schema.supports import GantryGroups

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

MAST = 0.38  # of the boom's length: height of the mast above the girders
STAYED = (0.45, 0.93)  # of the boom's length: where its forestays are fixed


class Portal(NamedTuple):
    """Sizes [m] of the structure, x along the trolley's rail, z from it; the rail is between two girders."""

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
        """Where the boom begins and ends, x [m]; None where neither side is longer than the legs are apart."""
        (left, right), (near, far) = self.ends, self.legs
        if max(near - left, right - far) <= far - near:
            return None
        return (near, left) if near - left > right - far else (far, right)

    @property
    def top(self) -> float:
        """Height [m] of the highest part."""
        return self.leg_top + (0.0 if self.boom is None else MAST * abs(self.boom[1] - self.boom[0]))


def depth_of(scene: Scene) -> float:
    """Return the depth [m] of the drawn ground below the trolley's rail: a contact's surface, else below all."""
    surface = contact_height(scene)
    return -surface if surface is not None else 1.2 * hung_length(scene)


def portal_of(scene: Scene) -> Portal:
    """Return the structure of a scene's gantry: between its legs, and over all that the trolley reaches."""
    file = scene.file
    assert isinstance(file, GantryGroups)
    depth, limits = depth_of(scene), scene.model.support.structure.trolley.limits
    places = [*axis_positions(scene, "trolley"), *(limits or ()), *(file.legs or ())]
    beyond = 0.15 * depth if file.legs else 0.4 * depth
    left, right = min(places) - beyond, max(places) + beyond
    unit = depth / 30.0
    if file.legs is None:
        return Portal((left, right), (left + 2.0 * unit, right - 2.0 * unit), depth, 4.5 * unit, 4.5 * unit)
    half_span = max(4.5 * unit, 0.75 * box_edges(scene.model.load)[1])  # so that the load passes between them
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
    """Return the beams between the legs: along the quay low down and above the girders, across it in the middle."""
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
    """Return the mast above the legs where the boom begins, its stays, and the machinery house at the other end."""
    unit, (near, far) = portal.unit, portal.legs
    other, out = (far if root == near else near), 1.0 if tip > root else -1.0
    apex, beam = (root, portal.top), 1.0 + 0.8 * unit
    feet = [*((root + share * (tip - root), beam) for share in STAYED), (other, portal.leg_top)]
    shapes = [Shape((0.8 * unit, 2.0 * portal.half_gauge + unit, 0.8 * unit), (root, 0.0, portal.top), YELLOW)]
    for y in (portal.half_gauge, -portal.half_gauge):
        stays = [tube(apex, foot, 0.18 * unit, STEEL) for foot in feet]
        post = Shape(
            (unit, 0.8 * unit, portal.top - portal.leg_top), (root, 0.0, 0.5 * (portal.top + portal.leg_top)), YELLOW
        )
        shapes += [shape._replace(at=(shape.at[0], y, shape.at[2])) for shape in (*stays, post)]
    house = (0.35 * (far - near), 1.6 * portal.half_gauge, 4.0 * unit)
    return [*shapes, Shape(house, (other + 0.1 * out * (far - near), 0.0, portal.leg_top + 0.5 * house[2]), GREY)]
