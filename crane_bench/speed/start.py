"""Time from the start of a process to its first simulated step: `crane bench start`.

Cold: with an empty cache of compiled code; warm: with a filled one. Imports and the interpreter's
own start count, and are measured beside it, since no compiled code can avoid them.
"""

import os
import subprocess
import sys
import tempfile
import time
from typing import Any

from crane_bench.speed.measurement import describe_spread, machine

FIRST_STEP = """
from crane_sim.simulation.plant import Plant
from crane_sim.scenes.scene import load_scene
plant = Plant(load_scene({scene!r}))
plant.advance(plant.scene.law(0.0, plant.q, plant.v) if plant.scene.sampled else None)
"""
IMPORTS = "import numpy, llvmlite.binding, pydantic, yaml"
LABELS = {
    "cold_s": "first step, cold",
    "warm_s": "first step, warm",
    "imports_s": "imports of packages alone",
    "interpreter_s": "an empty program",
}


def seconds(program: str, cache: str) -> float:
    """Return the wall time of a process that runs a Python program, with this cache folder."""
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", program], env=os.environ | {"CRANE_SIM_CACHE": cache}, check=True
    )
    return time.perf_counter() - start


def measure_start(
    name: str = "knuckle_setpoint", rounds: int = 10, cold_rounds: int = 3
) -> dict[str, Any]:
    """Return the wall times, s, of cold and warm starts of a scene, and of unavoidable parts.

    Args:
        name: scene of the catalogue.
        rounds: warm starts, each followed by one of the bare processes.
        cold_rounds: starts with an empty cache, at least one.
    """
    program = FIRST_STEP.format(scene=name)
    times: dict[str, list[float]] = {key: [] for key in LABELS}
    with tempfile.TemporaryDirectory() as folder:
        caches = [f"{folder}/{i}" for i in range(cold_rounds)]
        times["cold_s"] = [seconds(program, cache) for cache in caches]
        for _ in range(rounds):
            for key, ran in (("warm_s", program), ("imports_s", IMPORTS), ("interpreter_s", "")):
                times[key].append(seconds(ran, caches[-1]))
    spreads = {key: describe_spread(values) for key, values in times.items()}
    return {
        "scene": name,
        "rounds": rounds,
        "cold_rounds": cold_rounds,
        **spreads,
        "machine": machine(),
    }


def format_start(results: dict[str, Any]) -> list[str]:
    """Return the times in lines."""
    lines = [
        f"from a new process to the first simulated step of {results['scene']}, imports included, s"
    ]
    for key, label in LABELS.items():
        time_s = results[key]
        of = (
            f"median of {len(time_s['rounds'])}; least {time_s['least']:.2f}, most "
            f"{time_s['most']:.2f}"
        )
        lines.append(f"  {label:<36} {time_s['median']:5.2f}  ({of})")
    return lines
