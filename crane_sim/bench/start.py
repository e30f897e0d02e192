"""How long a process takes from nothing to its first simulated step: `python -m crane_sim.bench.start`.

Cold: with an empty cache of compiled code; warm: with a filled one. Imports and the interpreter's own start count.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time

FIRST_STEP = """
from crane_sim.plant import Plant
from crane_sim.scene import load_scene
plant = Plant(load_scene("knuckle_setpoint"))
plant.advance(plant.scene.law(0.0, plant.q, plant.v))
"""
ROUNDS = 10


def seconds(cache: str) -> float:
    """Return the wall time of a process that takes one step, with this cache folder."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", FIRST_STEP], env=os.environ | {"CRANE_SIM_CACHE": cache}, check=True)
    return time.perf_counter() - began


def main() -> int:
    """Print both times."""
    with tempfile.TemporaryDirectory() as cache:
        cold = seconds(cache)
        warm = [seconds(cache) for _ in range(ROUNDS)]
    print("from a new process to the first simulated step, imports included")
    print(f"  cold  {cold:.2f} s")
    print(f"  warm  {statistics.median(warm):.2f} s (median of {ROUNDS}; least {min(warm):.2f}, most {max(warm):.2f})")
    return 0


if __name__ == "__main__":
    sys.exit(main())
