"""The joints of an overhead crane's cable, in the coordinates that the scene has, so that joint states alone place it.

- Angles are absolute in the model, while a URDF joint is relative to its parent: every node's frame is level again,
  by a joint `level_k` that turns back by the link's angle.
- Components of a link's unit vector are three sliding joints; three more, `reach_k_*`, follow them and stretch the unit
  vector to the link's length. There is no angle, hence no singular posture.
- Positions of the nodes are sliding joints from the world.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree

import numpy as np

from crane_sim.description import gantry
from crane_sim.description.robot import DOWN, FORWARD, LEFT, RAISE, UP, add_joint, add_link
from crane_sim.description.solids import ORIGIN, STEEL, Body, Shape
from crane_sim.description.workspace import form_of
from crane_sim.scenes.schema.overhead_cable import fill_list
from crane_sim.simulation.metrics import polyline

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.description.workspace import Room
    from crane_sim.scenes.scene import Scene

ALONG = {"x": FORWARD, "y": LEFT, "z": UP}


class Hang(NamedTuple):
    """What hangs on the trolley, from the top; lengths are those at the start."""

    lengths: tuple[float, ...]  # (N,) m
    masses: tuple[float, ...]  # (N,) kg
    inertias: tuple[float, ...] = ()  # (N,) kg m², of links that turn as rods, about their swing; none of others

    @classmethod
    def of(cls, scene: Scene) -> Hang:
        """Return what hangs on a scene's trolley."""
        nodes, tip = polyline(scene.model, 0.0, np.array(scene.initial_q), np.array(scene.initial_v))
        lengths = np.linalg.norm(np.diff(nodes[tip:], axis=0), axis=1)
        form = form_of(scene)
        inertias = fill_list(form.cable.inertia, len(lengths), "cable.inertia") if form.cable.inertia else ()
        return cls(tuple(map(float, lengths)), form.parts.masses, inertias)

    @property
    def ends(self) -> list[str]:
        """Return the names of the links (N,) at the lower ends of the pieces of cable."""
        return [*(f"node_{k}" for k in range(1, len(self.lengths))), "payload_link"]


def add_cable(robot: ElementTree.Element, joints: Sequence[str], hang: Hang, room: Room) -> None:
    """Add the joints between `trolley_link` (or `world`) and the ends of the hang; the ends are up to the caller."""
    hoisted = "hoist" in joints
    if "node_1_x" in joints:
        _free(robot, joints, hang)
        if hoisted:  # the first piece's length at rest, a frame that nothing hangs on
            _slide(robot, "hoist", ("trolley_link", "hoist_link"), DOWN)
    elif "link_1_x" in joints:
        add_directed(robot, hang, hoisted)
    elif "swing_2" in joints:
        _turning(robot, hang, hoisted, room)
    else:
        _add_straight_cable(robot, hang, hoisted, room)


def _turning(robot: ElementTree.Element, hang: Hang, hoisted: bool, room: Room) -> None:
    above = "trolley_link"
    for k, (end, length) in enumerate(zip(hang.ends, hang.lengths, strict=True), start=1):
        link, at = f"link_{k}", (0.0, 0.0, -length)
        winch = hoisted and k == 1
        inertia = hang.inertias[k - 1] if hang.inertias else 0.0
        rod = Body(0.0, ORIGIN, (inertia, inertia, 0.0)) if inertia else None
        add_link(robot, link, [] if winch else _strand(length, room), rod)
        add_joint(robot, "revolute", f"swing_{k}", (above, link), axis=RAISE)
        if winch:
            _slide(robot, "hoist", (link, "hoist_link"), DOWN)
            link, at = "hoist_link", ORIGIN
        if end == "payload_link":  # it turns with its link
            add_joint(robot, "fixed", "hook", (link, end), at)
        else:
            add_joint(robot, "revolute", f"level_{k}", (link, end), at, RAISE, follows=f"swing_{k}")
        above = end


def _add_straight_cable(robot: ElementTree.Element, hang: Hang, hoisted: bool, room: Room) -> None:
    """Add a cable that stays straight: all nodes are fixed to the only link."""
    above, below = "link_1", np.cumsum(hang.lengths)
    add_link(robot, above, [] if hoisted else _strand(float(below[-1]), room))
    add_joint(robot, "revolute", "swing_1", ("trolley_link", above), axis=RAISE)
    if hoisted:  # the length of the first piece
        _slide(robot, "hoist", (above, "hoist_link"), DOWN)
        above, below = "hoist_link", below - below[0]
    for k, (end, depth) in enumerate(zip(hang.ends, below, strict=True), start=1):
        add_joint(robot, "fixed", f"end_{k}", (above, end), (0.0, 0.0, -float(depth)))


def add_directed(robot: ElementTree.Element, hang: Hang, hoisted: bool, above: str = "trolley_link") -> None:
    """Add links along unit vectors, the first below the link `above`.

    With a hoist the first link's vector is a product of two coordinates, which no joint of a URDF can be. The hoist
    then moves the cable's lower end straight down, which is exact where the first link is vertical.
    """
    for k, (end, length) in enumerate(zip(hang.ends, hang.lengths, strict=True), start=1):
        winch = hoisted and k == 1
        for axis in ALONG:
            _slide(robot, f"link_{k}_{axis}", (above, f"unit_{k}_{axis}"), ALONG[axis], (-1.0, 1.0))
            above = f"unit_{k}_{axis}"
        for axis in ALONG:
            child = end if axis == "z" and not winch else f"scaled_{k}_{axis}"
            span = (-length, length)
            follow = (f"link_{k}_{axis}", length - 1.0)
            _slide(robot, f"reach_{k}_{axis}", (above, child), ALONG[axis], span, follow, made=child != end)
            above = child
        if winch:
            add_joint(robot, "prismatic", "hoist", (above, end), (0.0, 0.0, length), DOWN)
            above = end


def _free(robot: ElementTree.Element, joints: Sequence[str], hang: Hang) -> None:
    """Add nodes that slide from the world."""
    axes = [axis for axis in ALONG if f"node_1_{axis}" in joints]
    for k, end in enumerate(hang.ends, start=1):
        above = "world"
        for axis in axes:
            child = end if axis == axes[-1] else f"place_{k}_{axis}"
            _slide(robot, f"node_{k}_{axis}", (above, child), ALONG[axis], made=child != end)
            above = child


def _slide(
    robot: ElementTree.Element,
    name: str,
    links: tuple[str, str],
    axis: tuple[float, float, float],
    span: tuple[float, float] | None = None,
    follow: tuple[str, float] | None = None,
    made: bool = True,
) -> None:
    """Add a sliding joint that may follow another one by a factor, and, if so wished, its bare child link."""
    if made:
        ElementTree.SubElement(robot, "link", name=links[1])
    joint, factor = follow or (None, -1.0)
    add_joint(robot, "prismatic", name, links, ORIGIN, axis, span, joint, factor)


def _strand(length: float, room: Room) -> list[Shape]:
    return [Shape((gantry.STRAND * room.depth, length), (0.0, 0.0, -0.5 * length), STEEL)]
