"""An overhead crane that the nodes of its cable place: solids on rails, one line for the cable, one entity for nodes.

Rails and legs are as long as the motion needs. They are static, and what is static can be logged anew: the picture
grows with a run, and is fitted to all of it in the end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from crane_sim.description import gantry
from crane_sim.description.room import room_of
from crane_sim.recording.cast import ROPE, STRAND, Lever, turn_from_z
from crane_sim.recording.framing import TROLLEY, of_room
from crane_sim.recording.solids import log_solids

if TYPE_CHECKING:
    from crane_sim.description.room import Room
    from crane_sim.recording.framing import Framing
    from crane_sim.recording.layout import Numbers
    from crane_sim.recording.suspension import Suspension

NODE = (184, 191, 199)
SLACK = 0.3  # of its edges, that a room grows beyond what it has to hold: it grows seldom
LEVERS = {
    "trolley": Lever("trolley", (0.0, -0.06, 0.03), (1.0, 0.0, 0.0)),
    "bridge": Lever("trolley", (0.1, 0.0, 0.03), (0.0, 1.0, 0.0)),
    "hoist": Lever("trolley", (0.1, -0.06, 0.03), (0.0, 0.0, -1.0)),
}


class GantryCast:
    """Draws what `Suspension` tells."""

    def __init__(self, rec: rr.RecordingStream, suspension: Suspension, stand: str) -> None:
        """Log the solids in the room that is expected; all of them stand in the frame `stand`."""
        self._rec, self._suspension, self._stand = rec, suspension, stand
        self._low, self._high, self._shortest = np.full(3, np.inf), np.full(3, -np.inf), np.inf
        for entity in ("rope", "rope/nodes"):
            rec.log(entity, rr.CoordinateFrame(stand), static=True)
        self._build(suspension.room)

    def lever(self, joint: str) -> Lever:
        """Return a place beside the trolley, where it hides nothing."""
        return LEVERS[joint]

    def dress(self, size: float) -> None:
        """Log the cable's thickness."""
        self._rec.log("rope", rr.LineStrips3D.from_fields(colors=ROPE, radii=STRAND * size), static=True)
        radii = np.array(self._radii(self._room))
        self._beads = bool(np.any(radii > STRAND * size))  # others are hidden in the line
        if self._beads:
            self._rec.log("rope/nodes", rr.Points3D.from_fields(colors=NODE, radii=radii), static=True)

    def move(self, time: list[rr.TimeColumn], q: Numbers, nodes: Numbers) -> Framing | None:
        """Add frames; the framing is a new one where the room was too small."""
        self._watch(nodes)
        grown = None
        if not self._room.holds(self._low, self._high):
            more = SLACK * (self._high - self._low)
            grown = self._build(room_of(self._low - more, self._high + more, self._shortest, self._room.spatial))
        if self._room.spatial:
            self._place(time, "bridge", nodes[:, 0] * (0.0, 1.0, 0.0))
        self._place(time, "trolley", nodes[:, 0])
        self._place(time, "payload", nodes[:, -1], turn_from_z(nodes[:, -2] - nodes[:, -1]))
        self._rec.send_columns("rope", time, rr.LineStrips3D.columns(strips=nodes.astype(np.float32)))
        if self._beads:
            beads = rr.Points3D.columns(positions=nodes[:, 1:-1].reshape(-1, 3))
            self._rec.send_columns("rope/nodes", time, beads.partition([nodes.shape[1] - 2] * len(nodes)))
        return grown

    def settle(self) -> Framing | None:
        """Make the room as large as the motion was."""
        if not np.isfinite(self._low).all():
            return None
        return self._build(room_of(self._low, self._high, self._shortest, self._room.spatial))

    def _watch(self, nodes: Numbers) -> None:
        """Remember the room that the nodes (F, N+1, 3) take."""
        self._low, self._high = np.minimum(self._low, nodes.min((0, 1))), np.maximum(self._high, nodes.max((0, 1)))
        self._shortest = min(self._shortest, float(np.linalg.norm(nodes[:, -1] - nodes[:, 0], axis=1).min()))

    def _build(self, room: Room) -> Framing:
        """Log the solids, which replace those that were logged before."""
        self._room = room
        mass = self._suspension.hang.masses[-1]
        log_solids(self._rec, "crane/base", self._stand, gantry.base(room))
        if room.spatial:
            log_solids(self._rec, "crane/bridge", "bridge", gantry.bridge(room))
        log_solids(self._rec, TROLLEY, "trolley", gantry.trolley(room))
        log_solids(self._rec, "payload/box", "payload", gantry.payload(mass, room))
        return of_room(room)

    def _radii(self, room: Room) -> list[float]:
        hang = self._suspension.hang
        pairs = list(zip(hang.masses, hang.lengths, strict=True))
        return [gantry.node_radius(mass, length, room) for mass, length in pairs[:-1]]

    def _place(self, time: list[rr.TimeColumn], frame: str, at: Numbers, turn: Numbers | None = None) -> None:
        frames = len(at)
        columns = rr.Transform3D.columns(
            translation=at, quaternion=turn, parent_frame=[self._stand] * frames, child_frame=[frame] * frames
        )
        self._rec.send_columns(f"tf/{frame}", time, columns)
