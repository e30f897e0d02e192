"""Runs from bags, in the form of a recording's."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crane_sim.recording.bag import read_bag
from crane_sim.recording.blocks import block_of
from crane_sim.recording.layout import of_scene
from crane_sim.recording.rerun.reader import read_run
from crane_sim.recording.rerun.recorder import BLOCK_STEPS
from crane_sim.recording.rerun.writer import RunWriter

if TYPE_CHECKING:
    from crane_sim.recording.bag import BaggedRun
    from crane_sim.recording.run import RecordedRun

KEPT = ("provenance", "drawn")  # properties of the run itself; the others follow from its scene


def read_bag_run(path: Path) -> RecordedRun:
    """Return the run in a bag as its recording would have it, but for events and metrics, which no message has.

    Raises:
        UnreadableRecording: the file is damaged, or lacks the scene or messages; the message is one line.
    """
    bag = read_bag(path)
    with tempfile.TemporaryDirectory() as folder:
        return replace(read_run(_record(bag, Path(folder, "run.rrd"))), path=path)


def _record(bag: BaggedRun, path: Path) -> Path:
    layout = of_scene(bag.scene, "bag", bag.truth)
    kept = {key: value for key, value in bag.properties.items() if key in KEPT}
    writer = RunWriter(path, layout._replace(properties={**layout.properties, **kept}))
    for first in range(0, len(bag.rows), BLOCK_STEPS):
        writer.write(block_of(bag.scene, bag.rows[first : first + BLOCK_STEPS]))
    return writer.close(_summary(bag))


def _summary(bag: BaggedRun) -> dict[str, Any]:
    scene, steps = bag.scene, len(bag.rows)
    entries: dict[str, Any] = {"scene": scene.name, "law": scene.law_name, "seed": scene.seed}
    entries |= {"steps": steps + bag.lost, "recorded_steps": steps, "lost_steps": bag.lost}
    return entries | ({"error": f"{bag.lost} steps are not in the bag"} if bag.lost else {})
