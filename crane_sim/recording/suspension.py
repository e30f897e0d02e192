"""What a recording shows of an overhead crane's cable: plotted angles, effort scale, target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crane_sim.description.cables import SuspendedCable
from crane_sim.description.workspace import BoundingBox, estimate_bounding_box, validated_scene_file
from crane_sim.scenes.scene import Scene

Array = NDArray[np.float64]

MAX_PLOTTED_LINKS = 4


COORDINATES = ("swing_", "link_", "node_", "payload_")  # prefixes of the names of a cable's joints


class Suspension(NamedTuple):
    """The fixed facts of an overhead crane's cable."""

    hang: SuspendedCable
    room: BoundingBox  # as far as it is known before the run
    lifts: bool  # its hoist's force is drawn as an arrow
    shape: str  # what its coordinates are: "angles", "rod" (one angle), "vectors" or "positions"

    @property
    def planar(self) -> bool:
        """Return whether the cable stays in the x-z plane: its angles have a sign."""
        return not self.room.spatial

    @property
    def elastic(self) -> bool:
        """Return whether the cable's length is not given."""
        return self.shape == "positions"

    @property
    def links(self) -> list[int]:
        """Return the numbers, from 1 at the top, of the links whose angles are plotted.

        Of many links these are only a few.
        """
        if not self.planar:
            return []
        count = 1 if self.shape == "rod" else len(self.hang.lengths)
        return [int(k) for k in np.unique(np.linspace(1, count, MAX_PLOTTED_LINKS).round())]


def suspension(scene: Scene) -> Suspension | None:
    """Return a scene's, None for a crane whose cable is a single rope below a boom."""
    if scene.crane != "overhead":
        return None
    room, lifts = estimate_bounding_box(scene), "hoist" in scene.actuated
    return Suspension(SuspendedCable.from_scene(scene), room, lifts, _shape(scene.joint_names))


def _shape(joints: Sequence[str]) -> str:
    for shape, sign in (("positions", "node_1_x"), ("vectors", "link_1_x"), ("angles", "swing_2")):
        if sign in joints:
            return shape
    return "rod"


def effort_scales(scene: Scene, hang: SuspendedCable) -> tuple[float, ...]:
    """Return the efforts (nu,) that are drawn as arrows of a seventh of an overhead crane's size.

    They bring all up to speed at 0.5 m/s², and hold what hangs on the hoist.
    """
    file = validated_scene_file(scene)
    pushed = sum(hang.masses) + sum(
        group.mass or 0.0 for group in (file.trolley, file.bridge) if group is not None
    )
    scales = {"trolley": 0.5 * pushed, "bridge": 0.5 * pushed, "hoist": 9.81 * sum(hang.masses)}
    return tuple(scales[name] for name in scene.actuated)


def hanging_still(actuated: Sequence[str], reference: Array, nodes: Array) -> Array:
    """Return the nodes (K, N+1, 3) at rest at the references (K, nu).

    Each link is as long as in `nodes`.
    """
    target = dict(zip(actuated, reference.T, strict=True))
    lengths = np.linalg.norm(np.diff(nodes, axis=1), axis=2)
    lengths[:, 0] = target.get("hoist", lengths[:, 0])
    still = np.repeat(nodes[:, :1], nodes.shape[1], axis=1)
    for axis, joint in enumerate(("trolley", "bridge")):
        still[:, :, axis] = target.get(joint, nodes[:, 0, axis])[:, None]
    still[:, 1:, 2] -= np.cumsum(lengths, axis=1)
    return still
