"""Warm-up of a plant: what has to be compiled is compiled before the run, not in it."""

from contextlib import suppress

from crane_sim.hardware.instruments import standard_normals
from crane_sim.simulation.base_state import base_state
from crane_sim.simulation.plant import Plant, SimulationError


def warm_up(plant: Plant, braking: bool) -> None:
    """Take a step, and reset the plant.

    `braking`: the brakes may act in real time, so their code is compiled as well.
    """
    effort = (0.0,) * len(plant.scene.actuated) if plant.scene.sampled else None
    with suppress(SimulationError):  # the run itself will fail in the same way, and report it
        plant.advance(effort)
        if braking:
            plant.braking = True
            plant.advance(effort)
    plant.summary()
    plant.reset()
    base_state(plant.scene, 0.0)
    if plant.scene.instruments is not None:
        standard_normals(0, 0, 0, 1)
