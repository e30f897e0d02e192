"""Hull that moves with a crane's base, and the water around it, with the waves of the scene's sea.

The size of the hull follows from the crane, not from the vessel. Waves are long-crested, as the scene's
sea is: they run along x of the world with the wavelength of deep water, and at the origin they are the sea of the base.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from crane_sim.description.transforms import WORLD
from crane_sim.trajectories.waves import GRAVITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.recording.camera import Framing
    from crane_sim.recording.layout import Array
    from crane_sim.trajectories.waves import SineSum

HULL_COLOR, DECK_COLOR, SEAM_COLOR, WATER_COLOR = (52, 60, 70), (84, 92, 100), (112, 120, 128), (30, 66, 96)
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
        for entity, frame in (*((f"vessel/{part}", stand) for part in ("hull", "deck", "seams")), ("water", WORLD)):
            rec.log(entity, rr.CoordinateFrame(frame), static=True)

    def fit(self, framing: Framing) -> None:
        """Log the hull and the water at rest, which replace those that were logged before."""
        (x, y, deck), half, size = framing.ground, framing.ground_size, framing.size
        waves = 0.0 if self._waves is None else 2.0 * float(np.linalg.norm(self._waves.amplitudes))
        freeboard, thick = FREEBOARD * size + waves, 0.02 * size
        height = freeboard + DRAUGHT * size
        length, width = half * framing.deck[0], half * framing.deck[1]
        self._log_box("vessel/deck", (x, y, deck - 0.5 * thick), (length, width, 0.5 * thick), DECK_COLOR)
        self._log_box(
            "vessel/hull", (x, y, deck - thick - 0.5 * height), (0.97 * length, 0.97 * width, 0.5 * height), HULL_COLOR
        )
        seams = [[(x - length, y + i * width, deck), (x + length, y + i * width, deck)] for i in np.linspace(-1, 1, 9)]
        lines = rr.LineStrips3D(seams, colors=SEAM_COLOR, radii=rr.Radius.ui_points(0.6))
        self._rec.log("vessel/seams", lines, static=True)
        self._half, self._level = WATER_RATIO * half, deck - freeboard
        self._x = np.linspace(x - self._half, x + self._half, CREST_POINTS)
        self._y = (y - self._half, y + self._half)
        first = 2 * np.arange(CREST_POINTS - 1)[:, None]
        triangles = np.vstack([first + (0, 2, 1), first + (1, 2, 3)])
        still = self._surface(np.zeros((1, CREST_POINTS)))[0]
        water = rr.Mesh3D(vertex_positions=still, triangle_indices=triangles, albedo_factor=WATER_COLOR)
        self._rec.log("water", water, static=True)

    def move(self, time: list[rr.TimeColumn], t: Array) -> None:
        """Add the water at scene times t (F,) [s]."""
        if self._waves is None:
            return
        number = self._waves.frequencies**2 / GRAVITY  # rad/m, of deep water
        phase = self._waves.frequencies * t[:, None, None] + self._waves.phases - number * self._x[:, None]
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
        self, entity: str, center: tuple[float, ...], halves: tuple[float, ...], color: tuple[int, int, int]
    ) -> None:
        box = rr.Boxes3D(centers=[center], half_sizes=[halves], colors=color, fill_mode="solid")
        self._rec.log(entity, box, static=True)
