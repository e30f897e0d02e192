"""Thousands of cranes at once, in vector lanes and one by one, beside MuJoCo's rollout.

All are measured on one core and on all cores.

`crane bench batch` runs cranes of different payload mass: steps per second, and the time of a
crane's simulated second at equal error. A batch's error is that of its worst crane. MuJoCo's
rollout integrates copies of one crane on all cores; its rows are missing where it is not installed.
"""

import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_bench.speed.engine import EngineUnavailable, sweep_values
from crane_bench.speed.measurement import describe_spread, machine
from crane_bench.speed.peers import mujoco_engine
from crane_bench.speed.problem import problem_of
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.batch import Batch, run_cranes, scenes_of
from crane_sim.simulation.plant import Plant

Array = npt.NDArray[np.float64]
SCENES = {"overhead_swing": (5.0, 20.0), "knuckle_springs": (0.5, 2.0)}
"""Scenes of the catalogue, and the range of payload masses [kg]."""
METHODS, ERRORS = ("rk4", "rk8"), (1e-4, 1e-6)  # m
STEP = 1e-3  # s, of rates
MULTIPLES, DIVISORS = (
    (25, 20, 16, 12, 10, 8, 6, 5, 4, 3, 2),
    (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 50),
)
STEPS = (*(0.01 * n for n in MULTIPLES), *(0.01 / n for n in DIVISORS))  # s, of a sweep
PEER_STEPS = sweep_values(0.05, 1e-4, 8)  # s
NO_INPUTS = np.empty(0)


def batch_scenes(name: str, method: str, step: float, count: int) -> list[Scene]:
    """Return the scenes of a batch."""
    scene = load_scene(name, {"integrator": {"method": method, "step": step}})
    return scenes_of(scene, {"payload.mass": np.linspace(*SCENES[name], count)}, None)


def measure_rates(name: str, count: int, rounds: int) -> dict[str, Any]:
    """Return millions of RK4 steps a second, in lanes and one by one, on one core and on all.

    The measurements are interleaved.

    `scenes_us`: time to check one crane's scene; `compile_s`: to compile, or to load from the
    cache.
    """
    start = time.perf_counter()
    scenes = batch_scenes(name, "rk4", STEP, count)
    checked = time.perf_counter() - start
    variants = {
        f"{kind}_{n}": (kind == "lanes", n)
        for kind in ("lanes", "one_by_one")
        for n in (1, cores())
    }
    compiled = {
        variant: run_cranes(scenes[:1], NO_INPUTS, 1, lanes).setup_time
        for variant, (lanes, n) in variants.items()
        if n == 1
    }
    rates: dict[str, list[float]] = {variant: [] for variant in variants}
    for _ in range(rounds):
        for variant, (lanes, threads) in variants.items():
            batch = run_cranes(scenes, NO_INPUTS, threads, lanes)
            rates[variant].append(float(batch.steps.sum()) / batch.wall_time / 1e6)
    speeds = {variant: describe_spread(values) for variant, values in rates.items()}
    return {
        "million_steps_per_s": speeds,
        "scenes_us": checked / count * 1e6,
        "compile_s": compiled,
    }


def costs_at_errors(name: str, count: int, rounds: int) -> dict[str, Any]:
    """Return, by error and method, the coarsest step [s], and µs per crane and simulated second."""
    references = [
        run_cranes(batch_scenes(name, "rk8", STEP / n, count), NO_INPUTS, cores(), True).payload
        for n in (1, 2)
    ]
    results: dict[str, Any] = {"reference_doubt_m": _largest_distance(*references)}
    for error in ERRORS:
        results[f"{error:g}"] = {
            method: _cheapest_run(name, method, count, error, references[1], rounds)
            for method in METHODS
        }
    return results


def _cheapest_run(
    name: str, method: str, count: int, error: float, exact: Array, rounds: int
) -> dict[str, Any] | None:
    for step in STEPS:
        scenes = batch_scenes(name, method, step, count)
        if (
            error_m := _largest_distance(
                run_cranes(scenes, NO_INPUTS, cores(), True).payload, exact
            )
        ) <= error:
            batches = _repeat(
                lambda scenes=scenes: run_cranes(scenes, NO_INPUTS, cores(), True), rounds
            )
            per_second = [1e6 * batch.wall_time / (count * scenes[0].duration) for batch in batches]
            return {
                "step": step,
                "error_m": error_m,
                "us_per_crane_second": describe_spread(per_second),
            }
    return None


def measure_mujoco(name: str, count: int, rounds: int) -> dict[str, Any]:
    """Return MuJoCo's RK4 rates and costs on all cores, or why it is missing.

    The keys are those of this simulator.
    """
    scene = load_scene(name, {"integrator": {"method": "rk8", "step": STEP / 2}})
    plant = Plant(scene)
    problem = problem_of(scene, np.array(plant.payload))
    assert problem is not None, name
    for _ in range(scene.steps):
        plant.advance()
    results: dict[str, Any] = {}
    try:
        for step in PEER_STEPS:
            ends, _ = mujoco_engine.batch(problem, 1, step, 1)
            error_m = _largest_distance(ends, np.array(plant.payload))
            pending = [error for error in ERRORS if f"{error:g}" not in results]
            reached = [error for error in pending if error_m <= error]
            if reached:
                times = [
                    mujoco_engine.batch(problem, count, step, cores())[1] for _ in range(rounds)
                ]
                row = {"step": step, "error_m": error_m}
                row |= _describe_times(times, count, scene.duration, step)
                results |= {f"{error:g}": row for error in reached}
            if len(reached) == len(pending):
                break
    except EngineUnavailable as missing:
        return {"missing": str(missing)}
    return results


def _describe_times(times: list[float], count: int, duration: float, step: float) -> dict[str, Any]:
    """Return cost and rate of batches of `count` cranes that took `times` [s]."""
    steps, seconds = round(duration / step), count * duration
    cost = [1e6 * wall_time / seconds for wall_time in times]
    speed = [count * steps / wall_time / 1e6 for wall_time in times]
    return {
        "us_per_crane_second": describe_spread(cost),
        "million_steps_per_s": describe_spread(speed),
    }


def _largest_distance(ends: Array, expected: Array) -> float:
    """Return the largest distance [m] between payloads (n, 3); infinite with a non-finite one."""
    distance = np.linalg.norm(ends - expected, axis=-1).max()
    return float(distance) if np.isfinite(distance) else float("inf")


def _repeat(run: Callable[[], Batch], rounds: int) -> list[Batch]:
    return [run() for _ in range(rounds)]


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


def measure_batch(count: int = 1024, peer_count: int = 64, rounds: int = 5) -> dict[str, Any]:
    """Return rates and costs of both scenes, of `count` cranes, and `peer_count` of MuJoCo's."""
    results: dict[str, Any] = {
        "cranes": count,
        "peer_cranes": peer_count,
        "rounds": rounds,
        "cores": cores(),
    }
    for name in SCENES:
        own_results = {
            "rates": measure_rates(name, count, rounds),
            "costs": costs_at_errors(name, count, rounds),
        }
        results[name] = own_results | {"mujoco": measure_mujoco(name, peer_count, rounds)}
    return results | {"machine": machine()}


def format_batch(results: dict[str, Any]) -> list[str]:
    """Return the rates and costs in lines."""
    lines = [
        f"{results['cranes']} cranes of {results['cores']} cores against {results['peer_cranes']} "
        "of MuJoCo's rollout"
    ]
    for name in SCENES:
        lines += _scene_lines(name, results[name])
    return lines


def _scene_lines(name: str, results: dict[str, Any]) -> list[str]:
    own_results, mujoco = results["rates"], results["mujoco"]
    lines = [f"{name}: {own_results['scenes_us']:.0f} µs to check a crane's scene"]
    for variant, speed in own_results["million_steps_per_s"].items():
        lines.append(
            f"  {variant.replace('_', ' '):<14} {speed['median']:8.2f} million RK4 steps/s"
        )
    for error in (f"{error:g}" for error in ERRORS):
        rows = results["costs"][error] | {"MuJoCo": mujoco.get(error)}
        for method, row in rows.items():
            cost = (
                f"{row['us_per_crane_second']['median']:9.3f} µs, step {row['step']:.2g} s"
                if row
                else "      -"
            )
            lines.append(f"  error {error} m  {method:<7} {cost} per crane and simulated second")
    return [*lines, f"  {mujoco['missing']}"] if "missing" in mujoco else lines
