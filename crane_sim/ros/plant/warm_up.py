"""What needs compiling is compiled before a run, not in it."""

from contextlib import suppress

from crane_sim.simulation.plant import Plant, SimulationError


def warm_up(plant: Plant, braking: bool) -> None:
    """Do once all that a step does, on a plant that is then reset.

    Brakes are code of their own; `braking` says whether somebody may need them while the wall clock goes on.
    """
    effort = (0.0,) * len(plant.scene.actuated) if plant.scene.sampled else None
    with suppress(SimulationError):  # the run itself will meet it again, and report it
        plant.advance(effort)
        if braking:
            plant.braking = True
            plant.advance(effort)
    plant.summary()
    plant.reset()
