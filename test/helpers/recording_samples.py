"""The steps of a short run, as a recorder gets them."""

from collections.abc import Iterator

from crane_sim import load_scene
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
