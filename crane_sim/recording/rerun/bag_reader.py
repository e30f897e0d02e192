"""Reader of runs in bags, which returns them as the reader of recordings does."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crane_sim.recording.bag import read_bag
from crane_sim.recording.blocks import block_of
from crane_sim.recording.layout import layout_of_scene
from crane_sim.recording.rerun.reader import read_run
from crane_sim.recording.rerun.recorder import BLOCK_STEPS
from crane_sim.recording.rerun.writer import RunWriter

if TYPE_CHECKING:
    from crane_sim.recording.bag import RunFromBag
    from crane_sim.recording.run import RecordedRun

RUN_PROPERTIES = ("provenance", "drawn")  # those that do not follow from the scene


def read_bag_run(path: Path) -> RecordedRun:
    """Return the run in a bag as its recording would have it, but for events and metrics, which no message has.

    Raises:
        UnreadableRecording: the file lacks the scene, or messages; the message is one line.
    """
    bag = read_bag(path)
    with tempfile.TemporaryDirectory() as folder:
        run = read_run(_record(bag, Path(folder, "run.rrd")))
        return replace(run, path=path, completeness=bag.completeness)


def _record(bag: RunFromBag, path: Path) -> Path:
    layout = layout_of_scene(bag.scene, "bag", bag.has_true_states)
    kept = {key: value for key, value in bag.properties.items() if key in RUN_PROPERTIES}
    writer = RunWriter(path, layout._replace(properties={**layout.properties, **kept}))
    for first in range(0, len(bag.rows), BLOCK_STEPS):
        writer.write(block_of(bag.scene, bag.rows[first : first + BLOCK_STEPS]))
    return writer.close(_summary(bag))


def _summary(bag: RunFromBag) -> dict[str, Any]:
    scene, steps = bag.scene, len(bag.rows)
    entries: dict[str, Any] = {"scene": scene.name, "law": scene.law_name, "seed": scene.seed}
    lost = bag.lost_steps + bag.lost_commands
    entries |= {"steps": steps + bag.lost_steps, "recorded_steps": steps, "lost_steps": lost}
    entries |= {"lost_commands": bag.lost_commands} if bag.lost_commands else {}
    subjects = {"steps": bag.lost_steps, "commands": bag.lost_commands}
    missing = [f"{number} {name}" for name, number in subjects.items() if number]
    if missing:
        entries["error"] = f"{' and '.join(missing)} are not in the bag"
    return entries | {key: bag.end[key] for key in ("ended_by", "error") if key in bag.end}
