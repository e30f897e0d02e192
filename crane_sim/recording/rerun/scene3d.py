"""The 3D scene of a recording: crane, cable, payload trail, target, at about 30 frames a second."""

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
from crane_sim.recording.rope_colors import rope_colors, usual_tensions
from crane_sim.trajectories.waves import GRAVITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.recording.camera import Framing
    from crane_sim.recording.layout import Array, Block, Layout
    from crane_sim.trajectories.waves import SineSum


TRAIL_COLOR, TARGET_COLOR, EFFORT_COLOR = (255, 132, 74), (64, 214, 132), (88, 176, 255)
GROUND_COLOR, GRID_COLOR = (70, 77, 86), (108, 117, 128)


class Scene3D:
    """Draws blocks into a recording.

    It keeps the last payload position, so that the trail joins across blocks.
    """

    def __init__(self, rec: rr.RecordingStream, layout: Layout) -> None:
        """Log the crane's solids and everything else that does not move."""
        self._rec, self._layout, self._framing = rec, layout, layout.framing
        self._stride = layout.frame_stride
        self._last: Array | None = None
        self._usual: Array | None = None
        self._aimed, self._range = False, MotionRange(layout.framing)
        self._cast = (
            GantryVisual(rec, layout.suspension, layout.stand.frame)
            if layout.suspension
            else RobotVisual(rec, layout)
        )
        for entity in ("payload/trail", "reference/path", "reference/target"):
            rec.log(entity, rr.CoordinateFrame(WORLD), static=True)
        for name in layout.actuated:
            rec.log(
                f"effort/{name}",
                rr.CoordinateFrame(self._cast.effort_arrow(name).frame),
                static=True,
            )
        self._vessel = (
            None
            if layout.stand.frame == WORLD
            else Vessel(rec, layout.stand.frame, layout.stand.sea)
        )
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
            self._vessel.move(
                time, np.float64(1e-9 * self._layout.period_ns) * (block.step[rows] - 1)
            )
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
        """Fit all that stands still to the motion; return the new view, None if unchanged."""
        framing = self._cast.fit_to_motion()
        self._fit(framing)
        return framing or self._range.fit()

    def _fit(self, framing: Framing | None) -> None:
        """Log the ground and the widths of lines, which replace those that were logged before."""
        if framing is None:
            return
        self._framing, rec, size = framing, self._rec, framing.size
        self._cast.set_size(size)
        trail = rr.LineStrips3D.from_fields(colors=TRAIL_COLOR, radii=0.003 * size)
        rec.log("payload/trail", trail, static=True)
        path = rr.LineStrips3D.from_fields(colors=TARGET_COLOR, radii=0.002 * size)
        rec.log("reference/path", path, static=True)
        if self._aimed:
            self._log_ball()
        for name in self._layout.actuated:
            arrow = rr.Arrows3D.from_fields(colors=EFFORT_COLOR, radii=0.007 * size)
            rec.log(f"effort/{name}", arrow, static=True)
        if self._vessel:
            self._vessel.fit(framing)
        else:
            log_ground(rec, framing)

    def _log_ball(self) -> None:
        """Log how the target looks; a ball without a centre would stand in the world's origin."""
        halves = [[0.03 * self._framing.size] * 3]
        ball = rr.Ellipsoids3D.from_fields(
            half_sizes=halves, colors=(*TARGET_COLOR, 150), fill_mode="solid"
        )
        self._rec.log("reference/target", ball, static=True)

    def _draw_efforts(self, time: list[rr.TimeColumn], effort: Array) -> None:
        size = self._framing.size
        for name, values, scale in zip(
            self._layout.actuated, effort.T, self._layout.effort_scales, strict=True
        ):
            _, origin, direction = self._cast.effort_arrow(name)
            vectors = np.outer(0.14 * size * np.clip(values / scale, -2.0, 2.0), direction)
            origins = np.tile(size * np.array(origin), (len(vectors), 1))
            self._rec.send_columns(
                f"effort/{name}", time, rr.Arrows3D.columns(vectors=vectors, origins=origins)
            )

    def _draw_trail(self, time: list[rr.TimeColumn], payload: Array) -> None:
        previous = np.vstack([payload[:1] if self._last is None else self._last, payload[:-1]])
        self._last = payload[-1:]
        strips = np.stack([previous, payload], axis=1).astype(np.float32)
        self._rec.send_columns("payload/trail", time, rr.LineStrips3D.columns(strips=strips))

    def _draw_target(self, time: list[rr.TimeColumn], target: Array) -> None:
        if not self._aimed:
            self._aimed = True
            self._log_ball()
        self._rec.send_columns(
            "reference/path", time, rr.LineStrips3D.columns(strips=target.astype(np.float32))
        )
        self._rec.send_columns(
            "reference/target", time, rr.Ellipsoids3D.columns(centers=target[:, -1])
        )


def log_ground(rec: rr.RecordingStream, framing: Framing) -> None:
    """Log ground that rests in the world, which replaces what was logged before."""
    (x, y, ground), size, half = framing.ground, framing.size, ceil(framing.ground_size)
    thick = 0.01 * size
    slab = rr.Boxes3D(
        centers=(x, y, ground - thick),
        half_sizes=(half, half, thick),
        colors=GROUND_COLOR,
        fill_mode="solid",
    )
    rec.log("ground", rr.CoordinateFrame(WORLD), slab, static=True)
    pitch = 10 ** max(0, ceil(log10(half / 40)))  # m
    marks = range(-half, half + 1, pitch)
    lines = [[(i, -half, 0.0), (i, half, 0.0)] for i in marks] + [
        [(-half, i, 0.0), (half, i, 0.0)] for i in marks
    ]
    grid = (np.array(lines) + (x, y, ground + 0.001 * size)).astype(np.float32)
    strips = rr.LineStrips3D(grid, colors=GRID_COLOR, radii=rr.Radius.ui_points(0.6))
    rec.log("ground/grid", rr.CoordinateFrame(WORLD), strips, static=True)


HULL_COLOR, DECK_COLOR, SEAM_COLOR, WATER_COLOR = (
    (52, 60, 70),
    (84, 92, 100),
    (112, 120, 128),
    (30, 66, 96),
)
FREEBOARD, DRAUGHT = 0.2, 0.25  # of the crane's size
WATER_RATIO = 2.0  # size of the water by that of the ground
CREST_POINTS = 64  # of the water, along x


class Vessel:
    """Hull and water of a recording."""

    def __init__(self, rec: rr.RecordingStream, stand: str, waves: SineSum | None) -> None:
        """Prepare for a crane that stands in the frame `stand`."""
        self._rec, self._waves = rec, waves
        self._x, self._y = np.empty(0), (0.0, 0.0)  # m, of the points of the water
        self._half = self._level = 0.0  # m
        for entity, frame in (
            *((f"vessel/{part}", stand) for part in ("hull", "deck", "seams")),
            ("water", WORLD),
        ):
            rec.log(entity, rr.CoordinateFrame(frame), static=True)

    def fit(self, framing: Framing) -> None:
        """Log the hull and the water at rest, which replace those that were logged before."""
        (x, y, deck), half, size = framing.ground, framing.ground_size, framing.size
        waves = 0.0 if self._waves is None else 2.0 * float(np.linalg.norm(self._waves.amplitudes))
        freeboard, thick = FREEBOARD * size + waves, 0.02 * size
        height = freeboard + DRAUGHT * size
        length, width = half * framing.deck[0], half * framing.deck[1]
        self._log_box(
            "vessel/deck", (x, y, deck - 0.5 * thick), (length, width, 0.5 * thick), DECK_COLOR
        )
        self._log_box(
            "vessel/hull",
            (x, y, deck - thick - 0.5 * height),
            (0.97 * length, 0.97 * width, 0.5 * height),
            HULL_COLOR,
        )
        self._log_seams((x, y, deck), length, width)
        self._half, self._level = WATER_RATIO * half, deck - freeboard
        self._x = np.linspace(x - self._half, x + self._half, CREST_POINTS)
        self._y = (y - self._half, y + self._half)
        self._log_still_water()

    def _log_seams(self, at: tuple[float, float, float], length: float, width: float) -> None:
        """Log the seams along the deck, given the middle and half the sides of the deck."""
        x, y, deck = at
        seams = [
            [(x - length, y + i * width, deck), (x + length, y + i * width, deck)]
            for i in np.linspace(-1, 1, 9)
        ]
        lines = rr.LineStrips3D(seams, colors=SEAM_COLOR, radii=rr.Radius.ui_points(0.6))
        self._rec.log("vessel/seams", lines, static=True)

    def _log_still_water(self) -> None:
        """Log the water at rest."""
        first = 2 * np.arange(CREST_POINTS - 1)[:, None]
        triangles = np.vstack([first + (0, 2, 1), first + (1, 2, 3)])
        still = self._surface(np.zeros((1, CREST_POINTS)))[0]
        water = rr.Mesh3D(
            vertex_positions=still, triangle_indices=triangles, albedo_factor=WATER_COLOR
        )
        self._rec.log("water", water, static=True)

    def move(self, time: list[rr.TimeColumn], t: Array) -> None:
        """Add the water at scene times t (F,) [s]."""
        if self._waves is None:
            return
        number = self._waves.frequencies**2 / GRAVITY  # rad/m, of deep water
        phase = (
            self._waves.frequencies * t[:, None, None]
            + self._waves.phases
            - number * self._x[:, None]
        )
        elevation = np.sin(phase) @ self._waves.amplitudes
        slope = -np.cos(phase) @ (number * self._waves.amplitudes)
        normals = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], axis=-1)
        columns = rr.Mesh3D.columns(
            vertex_positions=self._surface(elevation).reshape(-1, 3),
            vertex_normals=np.repeat(normals, 2, axis=1).reshape(-1, 3),
        )
        self._rec.send_columns("water", time, columns.partition([2 * CREST_POINTS] * len(t)))

    def _surface(self, elevation: Array) -> NDArray[np.float32]:
        """Return the points (F, 2 n, 3) of the water with elevations (F, n), two for each x."""
        points = np.empty((*elevation.shape, 2, 3))
        points[..., 0] = self._x[:, None]
        points[..., 1] = self._y
        points[..., 2] = self._level + elevation[..., None]
        return points.reshape(len(elevation), -1, 3).astype(np.float32)

    def _log_box(
        self,
        entity: str,
        center: tuple[float, ...],
        halves: tuple[float, ...],
        color: tuple[int, int, int],
    ) -> None:
        box = rr.Boxes3D(centers=[center], half_sizes=[halves], colors=color, fill_mode="solid")
        self._rec.log(entity, box, static=True)
