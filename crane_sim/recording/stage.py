"""The 3D scene of a recording: crane, cable, payload trail and target, at about 30 frames per second."""

from __future__ import annotations

import tempfile
from math import ceil, log10
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
import rerun.urdf  # noqa: F401  (makes rr.urdf available)

from crane_sim.recording.layout import Block, Layout
from crane_sim.recording.timelines import times

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.recording.layout import Numbers

FRAME_NS = 33_000_000  # of scene time between two frames
SOLID_LINKS = 20  # the links of a longer cable are drawn as a line: that is cheap, and looks the same
WORLD = "world"  # the frame of everything that is not part of the robot
ROPE, TRAIL, TARGET, PUSH = (214, 219, 226), (255, 132, 74), (64, 214, 132), (88, 176, 255)
GROUND, GRID = (70, 77, 86), (108, 117, 128)


class Stage:
    """Draws blocks into a recording; keeps the last payload position, so that the trail joins across blocks."""

    def __init__(self, rec: rr.RecordingStream, layout: Layout) -> None:
        """Log the crane's solids and everything else that does not move."""
        self._rec, self._layout = rec, layout
        self._solid = sum(joint.startswith("swing") for joint in layout.joints) <= SOLID_LINKS
        self._stride = max(1, FRAME_NS // layout.period_ns)
        self._last: Numbers | None = None
        tree = _load(layout.robot)
        self._joints = {joint.name: joint for joint in tree.joints()}
        rec.send_chunks(tree.stream(include_joint_transforms=False))
        for joint in self._joints.values():
            if joint.joint_type == "fixed":
                rec.log(f"tf/{joint.name}", joint.compute_transform(0.0), static=True)
        self._log_fixtures()

    def draw(self, block: Block) -> None:
        """Add the frames that fall into the block."""
        rows = np.flatnonzero((block.step - 1) % self._stride == 0)
        if not rows.size:
            return
        step = block.step[rows]
        time = times(self._layout, step)
        self._move(time, block.q[rows])
        cable = block.nodes[rows, self._layout.tip :]
        self._hang(time, cable) if self._solid else self._string(time, cable)
        self._trail(time, block.nodes[rows, -1])
        self._push(time, block.effort[rows])
        if block.target is not None:
            self._aim(time, block.target[rows])

    def _log_fixtures(self) -> None:
        rec, size = self._rec, self._layout.framing.size
        for entity in ("rope", "payload/trail", "reference/path", "reference/target", "ground", "ground/grid"):
            rec.log(entity, rr.CoordinateFrame(WORLD), static=True)
        for name in self._layout.actuated:
            rec.log(f"effort/{name}", rr.CoordinateFrame(self._joints[name].child_link), static=True)
        if self._solid:
            rods = rr.Cylinders3D(lengths=1.0, radii=0.0035 * size, colors=ROPE, fill_mode="solid")
            rec.log("rope", rods, static=True)
        self._log_ground()

    def _log_ground(self) -> None:
        x, y, ground = self._layout.framing.ground
        size = self._layout.framing.size
        half, thick = ceil(self._layout.framing.ground_size), 0.01 * size
        slab = rr.Boxes3D(
            centers=(x, y, ground - thick), half_sizes=(half, half, thick), colors=GROUND, fill_mode="solid"
        )
        self._rec.log("ground", slab, static=True)
        pitch = 10 ** max(0, ceil(log10(half / 40)))  # m
        marks = range(-half, half + 1, pitch)
        lines = [[(i, -half, 0.0), (i, half, 0.0)] for i in marks] + [[(-half, i, 0.0), (half, i, 0.0)] for i in marks]
        grid = (np.array(lines) + (x, y, ground + 0.001 * size)).astype(np.float32)
        self._rec.log("ground/grid", rr.LineStrips3D(grid, colors=GRID, radii=rr.Radius.ui_points(0.6)), static=True)

    def _move(self, time: list[rr.TimeColumn], q: Numbers) -> None:
        values = dict(zip(self._layout.joints, q.T, strict=True))
        for joint in self._joints.values():
            if joint.joint_type in ("fixed", "floating"):
                continue
            mimic = joint.mimic
            own = values[joint.name] if mimic is None else mimic.multiplier * values[mimic.joint] + mimic.offset
            columns = joint.compute_transform_columns(own.tolist(), clamp=False)
            self._rec.send_columns(f"tf/{joint.name}", time, columns)

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

    def _string(self, time: list[rr.TimeColumn], nodes: Numbers) -> None:
        """Draw a long cable, and its payload, whose place no joint tells."""
        frames = len(nodes)
        radii = [0.0035 * self._layout.framing.size] * frames
        columns = rr.LineStrips3D.columns(strips=nodes.astype(np.float32), colors=[ROPE] * frames, radii=radii)
        self._rec.send_columns("rope", time, columns)
        for joint in self._joints.values():
            if joint.joint_type == "floating":
                place = rr.Transform3D.columns(
                    translation=nodes[:, -1],
                    quaternion=turn_from_z(nodes[:, -2] - nodes[:, -1]),
                    parent_frame=[joint.parent_link] * frames,
                    child_frame=[joint.child_link] * frames,
                )
                self._rec.send_columns(f"tf/{joint.name}", time, place)

    def _push(self, time: list[rr.TimeColumn], effort: Numbers) -> None:
        size = self._layout.framing.size
        for name, values, scale in zip(
            self._layout.actuated, effort.T, self._layout.framing.effort_scales, strict=True
        ):
            origin, direction = lever(self._joints[name], 0.15 * size)
            vectors = np.outer(0.14 * size * np.clip(values / scale, -2.0, 2.0), direction)
            columns = rr.Arrows3D.columns(
                vectors=vectors,
                origins=[origin] * len(vectors),
                colors=[PUSH] * len(vectors),
                radii=[0.007 * size] * len(vectors),
            )
            self._rec.send_columns(f"effort/{name}", time, columns)

    def _trail(self, time: list[rr.TimeColumn], payload: Numbers) -> None:
        before = np.vstack([payload[:1] if self._last is None else self._last, payload[:-1]])
        self._last = payload[-1:]
        strips = np.stack([before, payload], axis=1).astype(np.float32)
        columns = rr.LineStrips3D.columns(
            strips=strips, colors=[TRAIL] * len(strips), radii=[0.003 * self._layout.framing.size] * len(strips)
        )
        self._rec.send_columns("payload/trail", time, columns)

    def _aim(self, time: list[rr.TimeColumn], target: Numbers) -> None:
        size = self._layout.framing.size
        lines = rr.LineStrips3D.columns(
            strips=target.astype(np.float32), colors=[TARGET] * len(target), radii=[0.002 * size] * len(target)
        )
        self._rec.send_columns("reference/path", time, lines)
        spheres = rr.Ellipsoids3D.columns(
            centers=target[:, -1],
            half_sizes=np.full((len(target), 3), 0.03 * size),
            colors=[(*TARGET, 150)] * len(target),
            fill_mode=[rr.components.FillMode.Solid] * len(target),
        )
        self._rec.send_columns("reference/target", time, spheres)


def lever(joint: rr.urdf.UrdfJoint, arm: float) -> tuple[Numbers, Numbers]:
    """Return where, and along which unit vector, a positive effort pushes the child link, in the link's frame.

    A torque is drawn as the push it makes at this arm along the link's x axis, a force along its own axis; a level
    one stands a third of the arm aside, where the trolley does not hide it.
    """
    axis = np.array(joint.axis)
    if joint.joint_type == "prismatic":
        return arm / 3.0 * np.cross(axis, (0.0, 0.0, 1.0)), axis
    x = np.array((1.0, 0.0, 0.0))
    return arm * x, np.cross(axis, x)


def turn_from_z(direction: Numbers) -> NDArray[np.float64]:
    """Return unit quaternions (xyzw) that turn the z axis into the directions (n, 3); zero vectors give no turn."""
    unit = direction / np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-12)
    x, y, z = unit.T
    # half-way form of the shortest arc; straight down has no unique arc, the half turn about x is taken
    quaternion = np.column_stack([-y, x, np.zeros_like(z), 1.0 + z])
    quaternion[z < -1.0 + 1e-12] = (1.0, 0.0, 0.0, 0.0)
    return quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)


def _load(robot: str) -> rr.urdf.UrdfTree:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "crane.urdf")
        path.write_text(robot)
        return rr.urdf.UrdfTree.from_file_path(path)
