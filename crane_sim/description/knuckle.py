"""The URDF of a knuckle-boom crane.

`base_link` has its origin at the boom pivot. Boom and jib angles are elevations from the horizontal
in the model, while a URDF joint is relative to its parent. The frames `boom_level_link` and
`jib_level_link` cancel the rotation of boom and jib: each mimics the elevation with the multiplier
-1, so that the zero of the next joint is horizontal.

Masses and inertias are the simulated ones, but for those of motors, which a URDF has no place for.
Without `axial_inertia` the model has no slew inertia of a rod's own about its centre. No rigid body
in a URDF is like that: the rod gets half of its luffing inertia about its two other axes and the
tower that much less, so that the mass matrix is unchanged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from crane_sim.description.robot import DOWN, FORWARD, RIGHT, UP
from crane_sim.description.solids import (
    DARK,
    GLASS,
    GREY,
    ORIGIN,
    RPY_ALONG_Y,
    STEEL,
    YELLOW,
    Body,
    Shape,
    hydraulic_cylinder,
    payload_box,
    point_mass,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.description.robot import Robot
    from crane_sim.models.single_rope.crane import Crane
    from crane_sim.models.supports.knuckle_boom import Knuckle, Rod


def add_knuckle_crane(robot: Robot, crane: Crane, joints: Sequence[str]) -> None:
    """Add links and joints: `joints`, and the mimic joints `boom_level` and `jib_level`."""
    tip = add_knuckle_boom(robot, crane.support, joints[:3])
    robot.link(
        "payload_link",
        payload_box(0.55 * _visual_scale(crane.support)),
        point_mass(crane.load.mass),
    )
    add_swing(robot, tip)
    robot.slide("rope", "rope_link", "payload_link", DOWN)


def add_swing(robot: Robot, tip: str) -> None:
    """Add the two angles of a rope between the link at its upper end and `rope_link`."""
    robot.turn("swing_tangential", tip, "swing_link", FORWARD)
    robot.turn("swing_radial", "swing_link", "rope_link", RIGHT)


def add_knuckle_boom(robot: Robot, support: Knuckle, joints: Sequence[str]) -> str:
    """Add pedestal, tower, boom and jib; return the jib's end link, with level x and y axes."""
    scale = _visual_scale(support)
    robot.link("base_link", _pedestal(pedestal_height(support), scale))
    tower_inertia, rod_fraction = split_rod_inertia(support)
    moments = (0.5 * tower_inertia, 0.5 * tower_inertia, tower_inertia)
    robot.link("tower_link", _tower(scale), Body(0.0, ORIGIN, moments))
    boom = [*_beam(support.boom.length, 0.34 * scale), *_cylinders(support.boom.length, scale)]
    robot.link("boom_link", boom, _rod_body(support.boom, rod_fraction))
    robot.link(
        "jib_link", _beam(support.jib.length, 0.24 * scale), _rod_body(support.jib, rod_fraction)
    )
    robot.comment(_tower_comment(support, tower_inertia))
    boom_end, jib_end = ((rod.length, 0.0, 0.0) for rod in (support.boom, support.jib))
    slew, luff, fold = joints
    robot.turn(slew, "base_link", "tower_link", UP)
    robot.turn(luff, "tower_link", "boom_link", RIGHT)
    robot.turn(
        fold, robot.level(luff, "boom_link", RIGHT, "boom_level", boom_end), "jib_link", RIGHT
    )
    return robot.level(fold, "jib_link", RIGHT, "jib_level", jib_end)


def pedestal_height(support: Knuckle) -> float:
    """Return the height of the boom pivot above the visual ground [m]; the model has no ground."""
    return 0.6 * support.boom.length


def _visual_scale(support: Knuckle) -> float:
    """Return the scale of the visuals [m]: 1 for a boom of 5 m."""
    return support.boom.length / 5.0


def split_rod_inertia(support: Knuckle) -> tuple[float, float]:
    """Return (tower's remaining slew inertia [kg m²], fraction of a rod's inertia given by it).

    The fraction is a half, the least that a rigid body can have, or less where the tower's inertia
    does not suffice.
    """
    without_axial = sum(
        rod.inertia for rod in (support.boom, support.jib) if rod.axial_inertia is None
    )
    fraction = min(0.5, support.tower.inertia / without_axial) if without_axial else 0.5
    return max(support.tower.inertia - fraction * without_axial, 0.0), fraction


def _tower_comment(support: Knuckle, tower_inertia: float) -> str:
    """Return the comment on the tower's mass and inertia."""
    mass = "tower_link has no mass: on the slew axis it has no effect, and none is simulated"
    inertia = support.tower.inertia
    if tower_inertia == inertia:
        return mass
    moved = (
        f"{inertia - tower_inertia:g} are in boom_link and jib_link, which have no axial_inertia"
    )
    return f"{mass}; of its {inertia:g} kg m² {moved}"


def _rod_body(rod: Rod, rod_fraction: float) -> Body:
    """Return the body of a rod.

    Without axial inertia it has `rod_fraction` of its inertia about both other axes.
    """
    if rod.axial_inertia is None:
        moments = (rod_fraction * rod.inertia, rod.inertia, rod_fraction * rod.inertia)
    else:
        moments = (rod.axial_inertia, rod.inertia, rod.inertia)
    return Body(rod.mass, (0.5 * rod.length, 0.0, 0.0), moments)


def _pedestal(height: float, scale: float) -> list[Shape]:
    top = 0.55 * scale
    column = height - top
    return [
        Shape((0.42 * scale, column), (0.0, 0.0, -top - 0.5 * column), GREY),
        Shape((0.62 * scale, 0.16 * scale), (0.0, 0.0, -top - 0.08 * scale), DARK),
        Shape((0.95 * scale, 0.2 * scale), (0.0, 0.0, 0.1 * scale - height), DARK),
    ]


def _tower(scale: float) -> list[Shape]:
    side_plate = (0.55 * scale, 0.08 * scale, 0.8 * scale)
    return [
        Shape((0.6 * scale, 0.14 * scale), (0.0, 0.0, -0.47 * scale), YELLOW),
        Shape(side_plate, (0.0, 0.27 * scale, -0.12 * scale), YELLOW),
        Shape(side_plate, (0.0, -0.27 * scale, -0.12 * scale), YELLOW),
        Shape((0.11 * scale, 0.74 * scale), ORIGIN, STEEL, RPY_ALONG_Y),
        Shape((0.75 * scale, 1.0 * scale, 0.55 * scale), (-0.68 * scale, 0.0, -0.13 * scale), DARK),
        Shape(
            (0.5 * scale, 0.4 * scale, 0.62 * scale),
            (0.12 * scale, 0.56 * scale, -0.09 * scale),
            GLASS,
        ),
    ]


def _cylinders(length: float, scale: float) -> list[Shape]:
    """Return boom and jib cylinders, fixed to the boom as at about 40 degrees of elevation."""
    luffing = hydraulic_cylinder(
        (-0.12 * scale, -0.61 * scale), (0.36 * length, -0.28 * scale), 0.1 * scale
    )
    return luffing + hydraulic_cylinder(
        (0.5 * length, -0.22 * scale), (0.97 * length, -0.3 * scale), 0.07 * scale
    )


def _beam(length: float, width: float) -> list[Shape]:
    root = 0.45 * length
    return [
        Shape((root, width, 1.25 * width), (0.5 * root, 0.0, 0.0), YELLOW),
        Shape(
            (length - root, 0.75 * width, 0.9 * width), (0.5 * (length + root), 0.0, 0.0), YELLOW
        ),
        Shape((0.1 * width, 1.05 * width, 1.3 * width), (root, 0.0, 0.0), DARK),
        Shape((0.55 * width, 1.15 * width), (length, 0.0, 0.0), STEEL, RPY_ALONG_Y),
    ]
