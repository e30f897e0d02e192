"""Cranes of several recorded runs in one 3D scene: the first run's in its own colours, the others' as ghosts.

A ghost is a translucent crane in the colour of its run. F is the number of frames, the steps that are drawn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
import rerun as rr

from crane_sim.description.suspended import ATTITUDE_JOINT
from crane_sim.description.transforms import WORLD
from crane_sim.recording.base_frame import base_quaternions
from crane_sim.recording.rerun.cranes import CABLE_RADIUS_RATIO, joint_transforms, load_robot
from crane_sim.recording.rerun.timelines import time_columns

if TYPE_CHECKING:
    from crane_sim.recording.layout import Array
    from crane_sim.recording.rerun.curves import Color
    from crane_sim.recording.run import RecordedRun

GHOST_OPACITY = 0.45


def draw_run(rec: rr.RecordingStream, run: RecordedRun, key: str, color: Color, ghost: bool) -> None:
    """Draw the crane of a run with its ropes, and the path of its payload in a colour; a ghost is all in this colour.

    All entities, and the names of all coordinate frames, begin with `key`.
    """
    tree = load_robot(_colored(run.urdf, color) if ghost else run.urdf, f"{key}/crane", f"{key}/")
    root, joints = f"{key}/{tree.root_link().name}", tree.joints()
    rec.send_chunks(tree.stream(include_joint_transforms=False))
    for joint in joints:
        if joint.joint_type == "fixed" and joint.name != ATTITUDE_JOINT:
            rec.log(f"{key}/tf/{joint.name}", joint.compute_transform(0.0), static=True)
    steps = run.frame_steps
    time = time_columns(run.frames.t)
    values = dict(zip(run.crane.joint_names, run.q[steps].T, strict=True))
    for name, columns in joint_transforms(joints, values):
        rec.send_columns(f"{key}/tf/{name}", time, columns)
    _place(rec, f"{key}/tf/stand", root, time, None if run.base is None else run.base[steps])
    _draw_ropes(rec, run, key, root, color)
    _draw_path(rec, run, key, color)


def _colored(urdf: str, color: Color) -> str:
    """Return a URDF with all its solids in a colour, translucent."""
    robot = ElementTree.fromstring(urdf)
    rgb = " ".join(f"{component / 255:.3f}" for component in color)
    for each in robot.iter("color"):
        each.set("rgba", f"{rgb} {GHOST_OPACITY}")
    return ElementTree.tostring(robot, encoding="unicode")


def _place(rec: rr.RecordingStream, entity: str, root: str, time: list[rr.TimeColumn], base: Array | None) -> None:
    """Place the root of a crane in the world: at rest, or with its base (F, 6), positions [m] and angles [rad]."""
    if base is None:
        rec.log(entity, rr.Transform3D(parent_frame=WORLD, child_frame=root), static=True)
        return
    columns = rr.Transform3D.columns(
        translation=base[:, :3],
        quaternion=base_quaternions(base),
        parent_frame=[WORLD] * len(base),
        child_frame=[root] * len(base),
    )
    rec.send_columns(entity, time, columns)


def _draw_ropes(rec: rr.RecordingStream, run: RecordedRun, key: str, root: str, color: Color) -> None:
    """Draw the cable from the tip to the payload in the world, or the falls in the frame of the base."""
    frames, radius = run.frames, CABLE_RADIUS_RATIO * run.crane.framing["size"]
    strips = frames.nodes[:, None, run.crane.tip_index :] if frames.falls is None else frames.falls
    count, ropes = strips.shape[:2]
    style = rr.LineStrips3D.from_fields(colors=color, radii=radius)
    rec.log(f"{key}/rope", rr.CoordinateFrame(WORLD if frames.falls is None else root), style, static=True)
    columns = rr.LineStrips3D.columns(strips=strips.reshape(-1, *strips.shape[2:]).astype(np.float32))
    rec.send_columns(f"{key}/rope", time_columns(frames.t), columns.partition([ropes] * count))


def _draw_path(rec: rr.RecordingStream, run: RecordedRun, key: str, color: Color) -> None:
    """Draw the path of the payload: each frame has the line from its position at the frame before."""
    payload = run.frames.nodes[:, -1]
    lines = np.stack([np.vstack([payload[:1], payload[:-1]]), payload], axis=1).astype(np.float32)
    style = rr.LineStrips3D.from_fields(colors=color, radii=0.003 * run.crane.framing["size"])
    rec.log(f"{key}/path", rr.CoordinateFrame(WORLD), style, static=True)
    rec.send_columns(f"{key}/path", time_columns(run.frames.t), rr.LineStrips3D.columns(strips=lines))
