"""Print the functions that a plant compiles or loads after its warm-up.

There must be none, or it stands still in a run.

Arguments: names of scenes. It is a program of its own because what another test has compiled is
ready in its process.
"""

import gc
import sys

from crane_sim import load_scene
from crane_sim.laws import with_initial_state
from crane_sim.ros.plant.warm_up import warm_up
from crane_sim.simulation.plant import BLOCK, Plant
from crane_sim.tracing.entry_point import EntryPoint


def signatures() -> set[tuple[str, str]]:
    """Return (function, signature) of what this process has compiled or loaded from the cache."""
    functions = [each for each in gc.get_objects() if isinstance(each, EntryPoint)]
    return {
        (each.__qualname__, str(signature)) for each in functions for signature in each.signatures
    }


def main() -> None:
    """Warm up, run past a full block of rows, and print a line for every missing signature."""
    for name in sys.argv[1:]:
        scene = load_scene(name)
        plant, law = Plant(scene), with_initial_state(scene.law) if scene.actuated else None
        warm_up(plant, braking=False)
        if law:
            law(plant.t, plant.q, plant.v)  # the controller's, in a process of its own
        ready = signatures()
        for _ in range(min(BLOCK + 1, scene.steps)):
            plant.advance(law(plant.t, plant.q, plant.v) if law else None)
        plant.summary()
        for function, signature in sorted(signatures() - ready):
            print(f"{name}: {function} {signature}", flush=True)


if __name__ == "__main__":
    main()
