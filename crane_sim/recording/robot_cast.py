"""A crane whose joints place all of it: its URDF moves in the recording."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
import rerun.urdf  # noqa: F401  (makes rr.urdf available)

from crane_sim.recording.cast import ROPE, STRAND, Lever, turn_from_z

if TYPE_CHECKING:
    from crane_sim.recording.framing import Framing
    from crane_sim.recording.layout import Layout, Numbers

ARM = 0.15  # of the crane's size: where the push is drawn that a torque makes


class RobotCast:
    """Draws the solids of a URDF at the joint coordinates, and rods from node to node of the rope."""

    def __init__(self, rec: rr.RecordingStream, layout: Layout) -> None:
        """Log the solids."""
        self._rec, self._layout = rec, layout
        tree = _load(layout.robot)
        self._joints = {joint.name: joint for joint in tree.joints()}
        rec.send_chunks(tree.stream(include_joint_transforms=False))
        for joint in self._joints.values():
            if joint.joint_type == "fixed" and layout.stand != joint.child_link:
                rec.log(f"tf/{joint.name}", joint.compute_transform(0.0), static=True)
        rec.log("rope", rr.CoordinateFrame(layout.stand), static=True)

    def lever(self, joint: str) -> Lever:
        """Return a torque's push at the arm along the link's x axis, a force's along its own axis."""
        found = self._joints[joint]
        axis = np.array(found.axis)
        if found.joint_type == "prismatic":
            return Lever(found.child_link, (0.0, 0.0, 0.0), _vector(axis))
        return Lever(found.child_link, (ARM, 0.0, 0.0), _vector(np.cross(axis, (1.0, 0.0, 0.0))))

    def dress(self, size: float) -> None:
        """Log the rope's thickness."""
        rods = rr.Cylinders3D(lengths=1.0, radii=STRAND * size, colors=ROPE, fill_mode="solid")
        self._rec.log("rope", rods, static=True)

    def move(self, time: list[rr.TimeColumn], q: Numbers, nodes: Numbers) -> Framing | None:
        """Add frames; the framing stays."""
        values = dict(zip(self._layout.joints, q.T, strict=True))
        for joint in self._joints.values():
            if joint.joint_type == "fixed":
                continue
            mimic = joint.mimic
            own = values[joint.name] if mimic is None else mimic.multiplier * values[mimic.joint] + mimic.offset
            columns = joint.compute_transform_columns(own.tolist(), clamp=False)
            self._rec.send_columns(f"tf/{joint.name}", time, columns)
        self._hang(time, nodes[:, self._layout.tip :])

    def settle(self) -> Framing | None:
        """Return None: a boom's reach is known from the start."""

    def _hang(self, time: list[rr.TimeColumn], nodes: Numbers) -> None:
        frames, links = nodes.shape[0], nodes.shape[1] - 1
        start, end = nodes[:, :-1].reshape(-1, 3), nodes[:, 1:].reshape(-1, 3)
        length = np.linalg.norm(end - start, axis=1)
        columns = rr.InstancePoses3D.columns(
            translations=0.5 * (start + end),
            quaternions=turn_from_z(end - start),
            scales=np.column_stack([np.ones_like(length), np.ones_like(length), length]),
        )
        self._rec.send_columns("rope", time, columns.partition([links] * frames))


def _vector(values: Numbers) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _load(robot: str) -> rr.urdf.UrdfTree:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "crane.urdf")
        path.write_text(robot)
        return rr.urdf.UrdfTree.from_file_path(path)
