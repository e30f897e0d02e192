"""What a study costs beside the runs that it is made of: `crane bench studies`.

Cranes of different masses and rope lengths under LQR, 20 s each: the compiled loop alone, and the
same cranes as studies, which check every scene, design its law, compute all metrics and the hash of
its states, and write the table: by processes of this machine and by a Dask cluster on it, of one
and of two workers, interleaved; then a large study, its time and memory beside those of a smaller
one. Every study runs in a process of its own. The overhead is that of processors' times, which a
busy machine changes less, of what the large study has more than the smaller one.
"""

import json
import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from crane_bench.speed.measurement import describe_spread, machine, ratio
from crane_sim.scenes.scene import Scene, load_scenes
from crane_sim.simulation.batch_metrics import allocate_arrays, run_all
from crane_sim.simulation.columns import make_driven, stack_columns
from crane_sim.stepping.batch import TimeGrid, simulate_range
from crane_sim.study import cases, execution
from crane_sim.study.runs import rows_of
from crane_sim.study.schema import Study, load_study, scene_document

STUDY = {
    "scene": "overhead_energy",
    "design": "latin_hypercube",
    "changes": {"control.law": "lqr"},
    "parameters": {
        "cable.node_masses.0": {"distribution": "uniform", "low": 5.0, "high": 20.0},
        "cable.lengths.0": {"distribution": "uniform", "low": 1.5, "high": 3.0},
    },
}
LARGE, SMALL, MEDIUM = 100_000, 10_000, 8_192  # cranes
WAYS = (("processes", 1), ("dask", 1), ("processes", 2), ("dask", 2))
_PROGRAM = "import sys; from crane_bench.speed.studies import run_study; run_study(*sys.argv[1:])"


def study_of(samples: int) -> Study:
    """Return the study of so many cranes."""
    return load_study(STUDY | {"samples": samples})


def _load_cranes(samples: int) -> list[Scene]:
    """Return the scenes of so many cranes."""
    study = study_of(samples)
    loaded = load_scenes(scene_document(study), [case.changes for case in cases(study)])
    return [scene for scene in loaded if isinstance(scene, Scene)]


def _kernel_time(scenes: Sequence[Scene]) -> float:
    """Return the time of a processor [s] that the compiled loop alone takes for each crane."""
    cranes, arrays = (
        stack_columns([make_driven(scene) for scene in scenes]),
        allocate_arrays(scenes, 0),
    )
    grid = TimeGrid(scenes[0].period, scenes[0].steps, np.empty(0))
    simulate_range(cranes, grid, arrays, 0, 0)  # compiles
    start = time.process_time()
    simulate_range(cranes, grid, arrays, 0, len(scenes))
    return (time.process_time() - start) / len(scenes)


def _parts(samples: int) -> dict[str, float]:
    """Return what parts of a row take of a processor [s] for each crane."""
    study = study_of(samples)
    document, listed, found = scene_document(study), cases(study), dict[str, float]()
    scenes = _load_cranes(samples)
    steps = {
        "scenes and laws": lambda: _load_cranes(samples),
        "runs, metrics, hashes": lambda: run_all(scenes),
        "rows in all": lambda: rows_of(listed, 0, samples, document),
    }
    for name, step in steps.items():
        step()  # compiles
        start = time.process_time()
        step()
        found[name] = (time.process_time() - start) / samples
    return found


def run_study(samples: str, way: str, workers: str) -> None:
    """Run a study in this process, and print what it takes.

    Times are those until the table is there, from the beginning and from the first finished block
    on, and that of all processors; memory is the largest of this process and of a worker.
    """
    start, first = time.perf_counter(), list[tuple[float, int]]()

    def note(done: int, _: int) -> None:
        if done and not first:
            first.append((time.perf_counter(), done))

    with TemporaryDirectory() as folder:
        scheduler = "local" if way == "dask" else None
        execution.run(study_of(int(samples)), Path(folder) / "study", int(workers), scheduler, note)
    (at, done), end = first[0], time.perf_counter()
    usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    found = {
        "seconds": end - start,
        "running": (end - at) * int(samples) / (int(samples) - done),
        "processor": sum(each.ru_utime + each.ru_stime for each in usage),
        "own_MB": usage[0].ru_maxrss * 1024 / 1e6,
        "worker_MB": usage[1].ru_maxrss * 1024 / 1e6,
    }
    print(json.dumps(found))


def _measure_study(samples: int, way: str, workers: int) -> dict[str, float]:
    """Return what `run_study` prints in a process of its own."""
    command = [sys.executable, "-c", _PROGRAM, str(samples), way, str(workers)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def measure_studies(
    large: int = LARGE, small: int = SMALL, medium: int = MEDIUM, rounds: int = 3
) -> dict[str, Any]:
    """Return times and memory of studies and of the compiled loop.

    The studies have `large`, `small` and `medium` cranes.
    """
    scenes, cores = _load_cranes(256), len(os.sched_getaffinity(0))
    _measure_study(64, "processes", 1)  # compiles
    kernel, ways = _measure_in_turn(scenes, medium, rounds)
    sizes = {str(count): _measure_study(count, "processes", cores) for count in (small, large)}
    kernel.append(_kernel_time(scenes))
    running = {name: [each["running"] / medium for each in found] for name, found in ways.items()}
    processor = (sizes[str(large)]["processor"] - sizes[str(small)]["processor"]) / (large - small)
    rates = {n: ratio(running[f"processes_{n}"], running[f"dask_{n}"]) for n in ("1", "2")}
    return {
        "cranes": {"large": large, "small": small, "medium": medium},
        "rounds": rounds,
        "cores": cores,
        "kernel_us": _describe_times(kernel),
        "running_us": {name: _describe_times(each) for name, each in running.items()},
        "dask_rate": rates,
        "sizes": sizes,
        "processor_us": 1e6 * processor,
        "parts_us": {name: 1e6 * t for name, t in _parts(len(scenes)).items()},
        "overhead": processor / statistics.median(kernel) - 1.0,
        "machine": machine(),
    }


def _measure_in_turn(
    scenes: Sequence[Scene], samples: int, rounds: int
) -> tuple[list[float], dict[str, list[dict[str, float]]]]:
    """Return (times of the compiled loop [s], what studies in each way take), interleaved."""
    kernel = list[float]()
    ways = {f"{way}_{workers}": list[dict[str, float]]() for way, workers in WAYS}
    for _ in range(rounds):
        kernel.append(_kernel_time(scenes))
        for way, workers in WAYS:
            ways[f"{way}_{workers}"].append(_measure_study(samples, way, workers))
    return kernel, ways


def _describe_times(times: Sequence[float]) -> dict[str, Any]:
    """Return the spread of times [s] in µs."""
    return describe_spread([1e6 * t for t in times])


def format_studies(results: dict[str, Any]) -> list[str]:
    """Return the costs in lines."""
    large, medium = results["cranes"]["large"], results["cranes"]["medium"]
    found = results["sizes"][str(large)]
    lines = [
        f"{large} cranes under LQR, 20 s each, {results['cores']} cores: {found['seconds']:.0f} s, "
        f"{1e6 * found['seconds'] / large:.0f} µs per crane",
        f"of a processor, per further crane: {results['processor_us']:.0f} µs, the compiled loop "
        f"alone {results['kernel_us']['median']:.0f} µs: overhead {results['overhead']:.0%}",
    ]
    parts = ", ".join(f"{name} {t:.0f} µs" for name, t in results["parts_us"].items())
    lines.append(f"of it: {parts}")
    for samples, size in results["sizes"].items():
        lines.append(
            f"memory of {samples}: {size['own_MB']:.0f} MB, {size['worker_MB']:.0f} MB in a worker"
        )
    for name, spread in results["running_us"].items():
        way, workers = name.split("_")
        dask_rate = results["dask_rate"][workers]["median"]
        rate = f", {dask_rate:.2f} of the rate of processes" if way == "dask" else ""
        lines.append(
            f"{medium} cranes, {way}, {workers} workers, once they run: {spread['median']:.0f} µs "
            f"per crane{rate}"
        )
    return lines
