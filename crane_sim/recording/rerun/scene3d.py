"""The 3D scene of a recording: crane, cable, payload trail and target, at about 30 frames per second."""

from __future__ import annotations

from math import ceil, log10
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from crane_sim.description.transforms import WORLD
from crane_sim.recording.base_frame import base_quaternions, to_base
from crane_sim.recording.camera import MotionRange
from crane_sim.recording.rerun.cranes import GantryVisual, RobotVisual
from crane_sim.recording.rerun.timelines import times
from crane_sim.recording.rerun.vessel import Vessel
from crane_sim.recording.rope_colors import rope_colors, usual_tensions

if TYPE_CHECKING:
    from crane_sim.recording.camera import Framing
    from crane_sim.recording.layout import Array, Block, Layout

TRAIL_COLOR, TARGET_COLOR, EFFORT_COLOR = (255, 132, 74), (64, 214, 132), (88, 176, 255)
GROUND_COLOR, GRID_COLOR = (70, 77, 86), (108, 117, 128)


class Scene3D:
    """Draws blocks into a recording; keeps the last payload position, so that the trail joins across blocks."""

    def __init__(self, rec: rr.RecordingStream, layout: Layout) -> None:
        """Log the crane's solids and everything else that does not move."""
        self._rec, self._layout, self._framing = rec, layout, layout.framing
        self._stride = layout.frame_stride
        self._last: Array | None = None
        self._usual: Array | None = None
        self._aimed, self._range = False, MotionRange(layout.framing)
        self._cast = (
            GantryVisual(rec, layout.suspension, layout.stand.frame) if layout.suspension else RobotVisual(rec, layout)
        )
        for entity in ("payload/trail", "reference/path", "reference/target"):
            rec.log(entity, rr.CoordinateFrame(WORLD), static=True)
        for name in layout.actuated:
            rec.log(f"effort/{name}", rr.CoordinateFrame(self._cast.effort_arrow(name).frame), static=True)
        self._vessel = None if layout.stand.frame == WORLD else Vessel(rec, layout.stand.frame, layout.stand.sea)
        self._fit(layout.framing)

    def draw(self, block: Block) -> None:
        """Add the frames that fall into the block."""
        rows = np.flatnonzero((block.step - 1) % self._stride == 0)
        if not rows.size:
            return
        time = times(self._layout, block.step[rows])
        base = None if block.base is None else block.base[rows]
        self._usual = usual_tensions(block.tensions) if self._usual is None else self._usual
        colors = rope_colors(block.tensions[rows], self._usual)
        self._fit(self._cast.move(time, block.q[rows], to_base(block.nodes[rows], base), colors))
        if base is not None:
            self._move_stand(time, base)
        if self._vessel:
            self._vessel.move(time, np.float64(1e-9 * self._layout.period_ns) * (block.step[rows] - 1))
        self._range.add(block.nodes[rows])
        self._draw_trail(time, block.nodes[rows, -1])
        self._draw_efforts(time, block.effort[rows])
        if block.target is not None:
            self._draw_target(time, block.target[rows])

    def _move_stand(self, time: list[rr.TimeColumn], base: Array) -> None:
        """Move the frame that the crane stands in."""
        frames = len(base)
        columns = rr.Transform3D.columns(
            translation=base[:, :3],
            quaternion=base_quaternions(base),
            parent_frame=[WORLD] * frames,
            child_frame=[self._layout.stand.frame] * frames,
        )
        self._rec.send_columns(f"tf/{self._layout.stand.frame}", time, columns)

    def fit_to_motion(self) -> Framing | None:
        """Fit everything that stands still to the whole motion; return how to look at it, None if that is as before."""
        framing = self._cast.fit_to_motion()
        self._fit(framing)
        return framing or self._range.fit()

    def _fit(self, framing: Framing | None) -> None:
        """Log the ground and the widths of lines, which replace those that were logged before."""
        if framing is None:
            return
        self._framing, rec, size = framing, self._rec, framing.size
        self._cast.set_size(size)
        rec.log("payload/trail", rr.LineStrips3D.from_fields(colors=TRAIL_COLOR, radii=0.003 * size), static=True)
        rec.log("reference/path", rr.LineStrips3D.from_fields(colors=TARGET_COLOR, radii=0.002 * size), static=True)
        if self._aimed:
            self._log_ball()
        for name in self._layout.actuated:
            rec.log(f"effort/{name}", rr.Arrows3D.from_fields(colors=EFFORT_COLOR, radii=0.007 * size), static=True)
        if self._vessel:
            self._vessel.fit(framing)
        else:
            log_ground(rec, framing)

    def _log_ball(self) -> None:
        """Log how the target looks; a ball without a centre would stand in the world's origin."""
        halves = [[0.03 * self._framing.size] * 3]
        ball = rr.Ellipsoids3D.from_fields(half_sizes=halves, colors=(*TARGET_COLOR, 150), fill_mode="solid")
        self._rec.log("reference/target", ball, static=True)

    def _draw_efforts(self, time: list[rr.TimeColumn], effort: Array) -> None:
        size = self._framing.size
        for name, values, scale in zip(self._layout.actuated, effort.T, self._layout.effort_scales, strict=True):
            _, origin, direction = self._cast.effort_arrow(name)
            vectors = np.outer(0.14 * size * np.clip(values / scale, -2.0, 2.0), direction)
            origins = np.tile(size * np.array(origin), (len(vectors), 1))
            self._rec.send_columns(f"effort/{name}", time, rr.Arrows3D.columns(vectors=vectors, origins=origins))

    def _draw_trail(self, time: list[rr.TimeColumn], payload: Array) -> None:
        previous = np.vstack([payload[:1] if self._last is None else self._last, payload[:-1]])
        self._last = payload[-1:]
        strips = np.stack([previous, payload], axis=1).astype(np.float32)
        self._rec.send_columns("payload/trail", time, rr.LineStrips3D.columns(strips=strips))

    def _draw_target(self, time: list[rr.TimeColumn], target: Array) -> None:
        if not self._aimed:
            self._aimed = True
            self._log_ball()
        self._rec.send_columns("reference/path", time, rr.LineStrips3D.columns(strips=target.astype(np.float32)))
        self._rec.send_columns("reference/target", time, rr.Ellipsoids3D.columns(centers=target[:, -1]))


def log_ground(rec: rr.RecordingStream, framing: Framing) -> None:
    """Log ground that rests in the world, which replaces what was logged before."""
    (x, y, ground), size, half = framing.ground, framing.size, ceil(framing.ground_size)
    thick = 0.01 * size
    slab = rr.Boxes3D(
        centers=(x, y, ground - thick), half_sizes=(half, half, thick), colors=GROUND_COLOR, fill_mode="solid"
    )
    rec.log("ground", rr.CoordinateFrame(WORLD), slab, static=True)
    pitch = 10 ** max(0, ceil(log10(half / 40)))  # m
    marks = range(-half, half + 1, pitch)
    lines = [[(i, -half, 0.0), (i, half, 0.0)] for i in marks] + [[(-half, i, 0.0), (half, i, 0.0)] for i in marks]
    grid = (np.array(lines) + (x, y, ground + 0.001 * size)).astype(np.float32)
    strips = rr.LineStrips3D(grid, colors=GRID_COLOR, radii=rr.Radius.ui_points(0.6))
    rec.log("ground/grid", rr.CoordinateFrame(WORLD), strips, static=True)
