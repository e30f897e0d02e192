"""A crane on twelve falls with friction against real time, on one core: `crane bench reeving`.

The catalogue's `reeved_twelve_falls` with its law, friction by events and periods of 50 ms, by
methods with error control at several tolerances. The error is the largest distance of the payload
at a period's end from the run with the finest tolerance; times are those of the processor for the
whole loop, rows of all periods among it.
"""

import time
from typing import Any

import numpy as np

from crane_bench.speed.measurement import describe_spread, machine
from crane_sim.laws import with_initial_state
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.rollout import run_raw, simulate

SCENE, LIMIT = "reeved_twelve_falls", 1e-4  # m
FINEST = {"method": "dop853", "rtol": 1e-12, "atol": 1e-13}
TOLERANCES = ((1e-4, 1e-6), (1e-6, 1e-8), (1e-8, 1e-10))
SETTINGS = [
    {"method": method, "rtol": rtol, "atol": atol}
    for method in ("dopri5", "dop853")
    for rtol, atol in TOLERANCES
]


def seconds(scene: Scene) -> float:
    """Return the processor time [s] of one run."""
    law = with_initial_state(scene.law)
    start = time.thread_time()
    run_raw(scene, law, np.empty(0))
    return time.thread_time() - start


def measure_reeving(rounds: int = 9, duration: float | None = None) -> dict[str, Any]:
    """Return the errors of all settings, and their simulated time per processor time.

    The duration [s] is the scene's by default.
    """
    changes = {} if duration is None else {"duration": duration}
    reference = simulate(SCENE, overrides=changes | {"integrator": FINEST}).payload
    scenes = [load_scene(SCENE, changes | {"integrator": setting}) for setting in SETTINGS]
    errors = [
        float(np.linalg.norm(simulate(scene).payload - reference, axis=1).max()) for scene in scenes
    ]
    times = np.array([[scene.duration / seconds(scene) for scene in scenes] for _ in range(rounds)])
    rows = [
        {"setting": setting, "error": error, "times_real_time": describe_spread(column.tolist())}
        for setting, error, column in zip(SETTINGS, errors, times.T, strict=True)
    ]
    return {
        "scene": SCENE,
        "duration": scenes[0].duration,
        "rounds": rounds,
        "rows": rows,
        "machine": machine(),
    }


def format_reeving(results: dict[str, Any]) -> list[str]:
    """Return the table in lines."""
    lines = [
        f"{results['scene']}, {results['duration']:g} s, one core, medians of {results['rounds']} "
        "interleaved rounds"
    ]
    for row in results["rows"]:
        setting, speed = row["setting"], row["times_real_time"]
        spread = (
            f"{speed['median']:6.0f} times real time ({speed['least']:.0f} to {speed['most']:.0f})"
        )
        lines.append(
            f"{setting['method']:<7} rtol {setting['rtol']:.0e}  error {row['error']:.1e} m  "
            f"{spread}"
        )
    within = [row for row in results["rows"] if row["error"] <= LIMIT]
    fastest = max((row["times_real_time"]["median"] for row in within), default=0.0)
    return [*lines, f"within {LIMIT:.0e} m: {fastest:.0f} times real time"]
