"""URDF joints of an overhead crane's cable, in the scene's coordinates: joint states place it.

- Angles are absolute in the model, while a URDF joint is relative to its parent: the frame of every
  node is kept level by a joint `level_k` that mimics the link's angle with the multiplier -1.
- Components of the unit vector of link k are three prismatic joints `link_k_x, _y, _z`, to the
  frames `unit_k_*`; three more, `reach_k_*`, to the frames `scaled_k_*`, mimic them and scale the
  vector to the link's length. There are no angles, hence no singular posture.
- Positions of the nodes are prismatic joints from the base.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from crane_sim.description.robot import DOWN, FORWARD, LEFT, RIGHT, UP, Robot
from crane_sim.description.solids import ORIGIN, STEEL, Body, Shape
from crane_sim.description.workspace import BoundingBox, validated_scene_file
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.overhead_cable import fill_list
from crane_sim.simulation.derived import world_points

CABLE_RADIUS_RATIO = 0.0035  # -, radius of the cable over the depth
AXES = {"x": FORWARD, "y": LEFT, "z": UP}


class SuspendedCable(NamedTuple):
    """Cable and payload below the trolley, from the top; lengths are the initial ones."""

    lengths: tuple[float, ...]  # (N,) m
    masses: tuple[float, ...]  # (N,) kg
    inertias: tuple[float, ...] = ()  # (N,) kg m², about the swing axis, of links that rotate as
    # rods; else empty

    @classmethod
    def from_scene(cls, scene: Scene) -> SuspendedCable:
        """Return the suspended cable of a scene."""
        nodes, tip_index = world_points(
            scene.model, 0.0, np.array(scene.initial_q), np.array(scene.initial_v)
        )
        lengths = np.linalg.norm(np.diff(nodes[tip_index:], axis=0), axis=1)
        file = validated_scene_file(scene)
        inertias = (
            fill_list(file.cable.inertia, len(lengths), "cable.inertia")
            if file.cable.inertia
            else ()
        )
        return cls(tuple(map(float, lengths)), file.parts.masses, inertias)

    @property
    def end_link_names(self) -> list[str]:
        """Return the names of the links (N,) at the lower ends of the cable's links."""
        return [*(f"node_{k}" for k in range(1, len(self.lengths))), "payload_link"]


def add_cable(robot: Robot, joints: Sequence[str], cable: SuspendedCable, box: BoundingBox) -> None:
    """Add the joints from `trolley_link` (or `base_link`) to the end links, added by the caller."""
    hoisted = "hoist" in joints
    if "node_1_x" in joints:
        _add_free_nodes(robot, joints, cable)
        if hoisted:  # the unstretched length of the first link; a frame without children
            robot.slide("hoist", "trolley_link", "hoist_link", DOWN)
    elif "link_1_x" in joints:
        add_vector_links(robot, cable, hoisted)
    elif "swing_2" in joints:
        _add_revolute_chain(robot, cable, hoisted, box)
    else:
        _add_straight_cable(robot, cable, hoisted, box)


def _add_revolute_chain(
    robot: Robot, cable: SuspendedCable, hoisted: bool, box: BoundingBox
) -> None:
    parent = "trolley_link"
    for k, (end, length) in enumerate(
        zip(cable.end_link_names, cable.lengths, strict=True), start=1
    ):
        link, at = f"link_{k}", (0.0, 0.0, -length)
        is_hoisted = hoisted and k == 1
        inertia = cable.inertias[k - 1] if cable.inertias else 0.0
        rod = Body(0.0, ORIGIN, (inertia, inertia, 0.0)) if inertia else None
        robot.link(link, [] if is_hoisted else _cable_visual(length, box), rod)
        robot.turn(f"swing_{k}", parent, link, RIGHT)
        if is_hoisted:
            robot.slide("hoist", link, "hoist_link", DOWN)
            link, at = "hoist_link", ORIGIN
        if end == "payload_link":  # it rotates with its link
            robot.fix("hook", link, end, at)
        else:
            robot.turn(f"level_{k}", link, end, RIGHT, at, mimic=f"swing_{k}")
        parent = end


def _add_straight_cable(
    robot: Robot, cable: SuspendedCable, hoisted: bool, box: BoundingBox
) -> None:
    """Add a cable that stays straight: all nodes are fixed to the only link."""
    parent, depths = "link_1", np.cumsum(cable.lengths)
    robot.link(parent, [] if hoisted else _cable_visual(float(depths[-1]), box))
    robot.turn("swing_1", "trolley_link", parent, RIGHT)
    if hoisted:  # the length of the first link
        robot.slide("hoist", parent, "hoist_link", DOWN)
        parent, depths = "hoist_link", depths - depths[0]
    for k, (end, depth) in enumerate(zip(cable.end_link_names, depths, strict=True), start=1):
        robot.fix(f"end_{k}", parent, end, (0.0, 0.0, -float(depth)))


def add_vector_links(
    robot: Robot,
    cable: SuspendedCable,
    hoisted: bool,
    parent: str = "trolley_link",
    first: int = 1,
    last: str = "payload_link",
) -> None:
    """Add links of the cable, by their unit vectors' components, from `parent` to `last`.

    Their numbers begin with `first`.

    With a hoist the vector of the first link is a product of coordinates, its length and its unit
    vector, which a URDF cannot express. The hoist then moves the link's lower end straight down,
    exact where the first link is vertical.
    """
    ends = [*(f"node_{k}" for k in range(first, first + len(cable.lengths) - 1)), last]
    for k, (end, length) in enumerate(zip(ends, cable.lengths, strict=True), start=first):
        is_hoisted = hoisted and k == 1
        for axis, way in AXES.items():
            robot.slide(f"link_{k}_{axis}", parent, f"unit_{k}_{axis}", way, limits=(-1.0, 1.0))
            parent = f"unit_{k}_{axis}"
        for axis, way in AXES.items():
            child = end if axis == "z" and not is_hoisted else f"scaled_{k}_{axis}"
            scaled = {
                "limits": (-length, length),
                "mimic": f"link_{k}_{axis}",
                "multiplier": length - 1.0,
            }
            robot.slide(f"reach_{k}_{axis}", parent, child, way, **scaled)
            parent = child
        if is_hoisted:
            robot.slide("hoist", parent, end, DOWN, (0.0, 0.0, length))
            parent = end


def _add_free_nodes(robot: Robot, joints: Sequence[str], cable: SuspendedCable) -> None:
    """Add nodes with prismatic joints from the base."""
    axes = [axis for axis in AXES if f"node_1_{axis}" in joints]
    for k, end in enumerate(cable.end_link_names, start=1):
        parent = "base_link"
        for axis in axes:
            child = end if axis == axes[-1] else f"place_{k}_{axis}"
            robot.slide(f"node_{k}_{axis}", parent, child, AXES[axis])
            parent = child


def _cable_visual(length: float, box: BoundingBox) -> list[Shape]:
    return [Shape((CABLE_RADIUS_RATIO * box.depth, length), (0.0, 0.0, -0.5 * length), STEEL)]
