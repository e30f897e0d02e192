"""The steps of a short run, as a recorder gets them."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from crane_sim import load_scene
from crane_sim.recording.blocks import block_of
from crane_sim.recording.layout import layout_of_scene
from crane_sim.recording.rerun.writer import RunWriter
from crane_sim.recording.step_assembler import Row
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant

STEPS = 637  # two blocks, the last one not full


SCENE = load_scene("knuckle_setpoint", {"duration": STEPS * 0.01})


def steps_of(scene: Scene) -> Iterator[Row]:
    """Yield the steps of a run under the scene's law."""
    plant = Plant(scene)
    for k in range(scene.steps):
        q, v = plant.q, plant.v
        assert scene.law is not None
        demanded = scene.law(plant.t, q, v)
        plant.advance(demanded)
        yield Row(k + 1, q, v, plant.applied, demanded, scene.reference)


def rows_at_rest(scene: Scene, count: int, first: int = 1) -> list[Row]:
    """Return steps in which a crane stays where it begins."""
    effort = (0.0,) * len(scene.actuated)
    state = scene.initial_q, scene.initial_v
    return [Row(k, *state, effort, effort, scene.reference) for k in range(first, first + count)]


class RowWriter(RunWriter):
    """A writer of a scene's recording that takes rows."""

    def __init__(self, scene: Scene, path: Path) -> None:
        super().__init__(path, layout_of_scene(scene, "test"))
        self._scene = scene

    def write_rows(self, rows: Sequence[Row]) -> None:
        """Write rows as a block."""
        self.write(block_of(self._scene, rows))

    def finish(self, summary: Mapping[str, Any]) -> dict[str, Any]:
        """Complete the recording; return its summary."""
        entries = {
            "recording": str(self.file.path),
            "recorded_steps": self.recorded,
            "lost_steps": 0,
        }
        self.close({**summary, **entries})
        return {**summary, **entries}
