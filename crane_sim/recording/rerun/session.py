"""One recording from its first to its last row: derives what is plotted, writes blocks, counts steps."""

from __future__ import annotations

import uuid
from typing import TYPE_CHECKING, Any

from crane_sim.recording.blocks import block_of
from crane_sim.recording.layout import layout_of_scene
from crane_sim.recording.rerun.repair import repair_leftovers
from crane_sim.recording.rerun.writer import RunWriter

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from crane_sim.recording.rerun.live import LiveServer
    from crane_sim.recording.step_assembler import Row
    from crane_sim.scenes.scene import Scene


class Session:
    """Records the steps of one run of a scene.

    Attributes:
        recorded: steps that reached the disk.
    """

    def __init__(
        self, scene: Scene, path: Path, live: LiveServer | None = None, run_id: str = "", repairs: bool = True
    ) -> None:
        """Start the file, after recovering what an earlier, killed recorder left beside it.

        Args:
            scene: what is recorded.
            path: the complete file.
            live: serves the run to viewers, too.
            run_id: the viewer's recording id, the same for parts of one; empty: one of its own.
            repairs: look for leftovers.

        Raises:
            RecordingError: the file cannot be written.
        """
        self._scene = scene
        self.recorded = 0
        if repairs:
            repair_leftovers(path.parent)
        name = f"{scene.name}-{run_id or uuid.uuid4().hex[:12]}"
        self._writer = RunWriter(path, layout_of_scene(scene, name), live)

    @property
    def part(self) -> Path:
        """The file while it grows."""
        return self._writer.file.part

    def write(self, rows: Sequence[Row]) -> None:
        """Append rows.

        Raises:
            RecordingError: they did not reach the disk.
        """
        if rows:
            self._writer.write(block_of(self._scene, rows))
            self.recorded += len(rows)

    def add_note(self, step: int, text: str) -> None:
        """Add a line to the recording's log."""
        self._writer.add_note(step, text)

    def add_speed(self, step: int, real_time_factor: float) -> None:
        """Add how fast the run was lately: simulated seconds per second."""
        self._writer.add_speed(step, real_time_factor)

    def add_timeline_state(self, timeline: str, normal: str, step: int, state: str) -> None:
        """Add that a timeline, which begins in the state `normal`, has another one from the start of a step on."""
        self._writer.add_timeline_state(timeline, normal, step, state)

    def close(self, summary: Mapping[str, Any], lost: int) -> dict[str, Any]:
        """Finish the file with the run's summary; return what the recorder adds to it.

        Raises:
            RecordingError: the end of the file did not reach the disk.
        """
        entries = {"recording": str(self._writer.file.path), "recorded_steps": self.recorded, "lost_steps": lost}
        self._writer.close({**summary, **entries})
        return entries

    def failed_summary(self, why: str, lost: int, older: int = 0) -> dict[str, Any]:
        """Return the summary's entries on a file that failed; `older` steps are of before a reset."""
        suffix = f" since the last reset, and {older} from before it" if older else ""
        error = f"recorder: {why}; it has {self.recorded} of {self.recorded + lost} steps{suffix}"
        return {"recorded_steps": self.recorded, "lost_steps": lost, "error": error}
