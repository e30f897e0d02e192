"""What a study costs beside the runs that it is made of: `crane bench studies`.

Cranes of different masses and rope lengths under LQR, 20 s each: the compiled loop alone, on all cores, then the same
cranes as a study by processes of this machine and by a Dask cluster on it, interleaved. A study checks every scene,
designs its law, computes all figures and writes the table.
"""

import os
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from crane_sim.evaluation.bench.measurement import describe_spread, machine, ratio
from crane_sim.scenes.scene import load_scene
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


def study_of(samples: int) -> Study:
    """Return the study of so many cranes."""
    return load_study(STUDY | {"samples": samples})


def _kernel_seconds(study: Study) -> float:
    """Return the time of the compiled loop, on all cores."""
    document = scene_document(study)
    scenes = [load_scene(document, case.changes) for case in cases(study)]
    return run_cranes(scenes, np.empty(0), len(os.sched_getaffinity(0)), False).wall_time


def _study_seconds(study: Study, scheduler: str | None) -> float:
    """Return the time of the study from its first statement to its table."""
    with TemporaryDirectory() as folder:
        began = time.perf_counter()
        execution.run(study, Path(folder) / "study", scheduler=scheduler)
        return time.perf_counter() - began


def measure(samples: int = 4096, rounds: int = 3) -> dict[str, Any]:
    """Return µs of all cores per crane: of the compiled loop, of a study by processes, and by a Dask cluster."""
    study, times = study_of(samples), {"kernel": [], "processes": [], "dask": []}
    _kernel_seconds(study_of(8))  # compiles
    for _ in range(rounds):
        times["kernel"].append(_kernel_seconds(study))
        times["processes"].append(_study_seconds(study, None))
        times["dask"].append(_study_seconds(study, "local"))
    return {
        "samples": samples,
        "rounds": rounds,
        "us_per_crane": {name: describe_spread([1e6 * t / samples for t in each]) for name, each in times.items()},
        "processes_per_kernel": ratio(times["processes"], times["kernel"]),
        "dask_rate": ratio(times["processes"], times["dask"]),
        "machine": machine(),
    }


def format_lines(results: dict[str, Any]) -> list[str]:
    """Return the costs in lines."""
    cost = {name: each["median"] for name, each in results["us_per_crane"].items()}
    times, rate = results["processes_per_kernel"]["median"], results["dask_rate"]["median"]
    return [
        f"{results['samples']} cranes under LQR, 20 s each, all cores, medians of {results['rounds']} rounds",
        f"compiled loop alone       {cost['kernel']:8.0f} µs per crane",
        f"study, processes          {cost['processes']:8.0f} µs per crane, {times:.2f} times the loop",
        f"study, Dask cluster here  {cost['dask']:8.0f} µs per crane, {rate:.2f} of the rate of processes",
    ]
