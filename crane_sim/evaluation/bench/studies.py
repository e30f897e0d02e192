"""What a study costs beside the runs that it is made of: `crane bench studies`.

Cranes of different masses and rope lengths under LQR, 20 s each: the compiled loop alone, on all cores, and the same
cranes as studies, which check every scene, design its law, compute all figures and the hash of its states, and write
the table: by processes of this machine and by a Dask cluster on it, of one and of two workers, interleaved; then
a large study, and its memory beside that of a smaller one. Every study runs in a process of its own, from the first
statement after its imports to its table; the start of its workers is part of it.
"""

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from crane_sim.evaluation.bench.measurement import describe_spread, machine, ratio
from crane_sim.scenes.many import load_scenes
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.batch import run_cranes
from crane_sim.study import cases, execution
from crane_sim.study.form import Study, load_study, scene_document

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
_PROGRAM = "import sys; from crane_sim.evaluation.bench.studies import run_study; run_study(*sys.argv[1:])"


def study_of(samples: int) -> Study:
    """Return the study of so many cranes."""
    return load_study(STUDY | {"samples": samples})


def _load(samples: int) -> list[Scene]:
    """Return the scenes of so many cranes."""
    study = study_of(samples)
    loaded = load_scenes(scene_document(study), [case.changes for case in cases(study)])
    return [scene for scene in loaded if isinstance(scene, Scene)]


def _kernel_seconds(scenes: Sequence[Scene]) -> float:
    """Return the time of the compiled loop alone, on all cores."""
    return run_cranes(scenes, np.empty(0), len(os.sched_getaffinity(0)), False).wall_time


def run_study(samples: str, way: str, workers: str) -> None:
    """Run a study in this process, and print its time and the largest memory of this process and of a worker."""
    with TemporaryDirectory() as folder:
        began = time.perf_counter()
        scheduler = "local" if way == "dask" else None
        execution.run(study_of(int(samples)), Path(folder) / "study", int(workers), scheduler)
        seconds = time.perf_counter() - began
    usage = {name: resource.getrusage(who).ru_maxrss for name, who in _PROCESSES.items()}
    print(json.dumps({"seconds": seconds} | {name: size * 1024 / 1e6 for name, size in usage.items()}))


_PROCESSES = {"own_MB": resource.RUSAGE_SELF, "worker_MB": resource.RUSAGE_CHILDREN}


def _measure_study(samples: int, way: str, workers: int) -> dict[str, float]:
    """Return what `run_study` prints in a process of its own."""
    command = [sys.executable, "-c", _PROGRAM, str(samples), way, str(workers)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def measure(large: int = LARGE, small: int = SMALL, medium: int = MEDIUM, rounds: int = 3) -> dict[str, Any]:
    """Return times and memory of studies of `large`, `small` and `medium` cranes, and of the compiled loop."""
    scenes, cores = _load(1024), len(os.sched_getaffinity(0))
    _kernel_seconds(scenes[:8])  # compiles
    _measure_study(64, "processes", 1)
    kernel, times = list[float](), {f"{way}_{workers}": list[float]() for way, workers in WAYS}
    for _ in range(rounds):
        kernel.append(_kernel_seconds(scenes) / len(scenes))
        for way, workers in WAYS:
            times[f"{way}_{workers}"].append(_measure_study(medium, way, workers)["seconds"] / medium)
    sizes = {str(samples): _measure_study(samples, "processes", cores) for samples in (small, large)}
    kernel.append(_kernel_seconds(scenes) / len(scenes))
    alone = describe_spread([1e6 * t for t in kernel])
    return {
        "cranes": {"large": large, "small": small, "medium": medium},
        "rounds": rounds,
        "cores": cores,
        "kernel_us": alone,
        "study_us": {name: describe_spread([1e6 * t for t in each]) for name, each in times.items()},
        "dask_rate": {n: ratio(times[f"processes_{n}"], times[f"dask_{n}"]) for n in ("1", "2")},
        "sizes": sizes,
        "overhead": 1e6 * sizes[str(large)]["seconds"] / large / alone["median"] - 1.0,
        "machine": machine(),
    }


def format_lines(results: dict[str, Any]) -> list[str]:
    """Return the costs in lines."""
    large, medium = results["cranes"]["large"], results["cranes"]["medium"]
    found, cores = results["sizes"][str(large)], results["cores"]
    each = 1e6 * found["seconds"] / large
    lines = [
        f"{large} cranes under LQR, 20 s each, on {cores} cores: {found['seconds']:.0f} s, {each:.0f} µs per crane; "
        f"the compiled loop alone {results['kernel_us']['median']:.0f} µs: overhead {results['overhead']:.0%}"
    ]
    for samples, size in results["sizes"].items():
        lines.append(f"memory of {samples}: {size['own_MB']:.0f} MB, {size['worker_MB']:.0f} MB in a worker")
    for name, spread in results["study_us"].items():
        way, workers = name.split("_")
        rate = f", {results['dask_rate'][workers]['median']:.2f} of the rate of processes" if way == "dask" else ""
        lines.append(f"{medium} cranes, {way}, {workers} workers: {spread['median']:.0f} µs per crane{rate}")
    return lines
