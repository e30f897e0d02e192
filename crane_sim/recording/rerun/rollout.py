"""Recordings of runs without ROS, in the same form as those of a recorder."""

from __future__ import annotations

import uuid
from typing import TYPE_CHECKING, Any

from crane_sim.recording.blocks import block_of_rollout
from crane_sim.recording.layout import of_rollout
from crane_sim.recording.rerun.part_file import RecordingError
from crane_sim.recording.rerun.writer import RunWriter

if TYPE_CHECKING:
    from pathlib import Path

    from crane_sim.simulation.rollout import Rollout

BLOCK_STEPS, MAX_BLOCK_STEPS, BLOCKS = 500, 2000, 60
"""Steps of a block, at least and at most, and the number of blocks of which a viewer loads a file
at once."""


def record(rollout: Rollout, path: Path) -> Path:
    """Write a run into a complete recording; return its path.

    Raises:
        ValueError: the run has samples at other times than its control periods.
        RecordingError: the file cannot be written.
    """
    block, layout = (
        block_of_rollout(rollout),
        of_rollout(rollout, f"{rollout.scene.name}-{uuid.uuid4().hex[:12]}"),
    )
    steps = len(block.step)
    entries: dict[str, Any] = {"recording": str(path), "recorded_steps": steps, "lost_steps": 0}
    writer = RunWriter(path, layout)
    try:
        size = max(BLOCK_STEPS, min(MAX_BLOCK_STEPS, steps // BLOCKS))
        for first in range(0, steps, size):
            writer.write(block.part(slice(first, first + size)))
        writer.add_events(rollout.events)
        return writer.close(rollout.summary | entries)
    except RecordingError:
        writer.file.discard()  # the run can be recorded again
        raise
