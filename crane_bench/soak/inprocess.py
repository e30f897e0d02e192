"""Resident memory and rate of millions of control periods without ROS: `crane soak inprocess`."""

import os
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from crane_bench.soak.drift import drift_metrics
from crane_bench.soak.memory import resident
from crane_bench.soak.metrics import Metric, at_most
from crane_bench.speed.measurement import measure_processor_speed
from crane_sim import load_scene
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate

BLOCKS = 25  # samples of memory and rate; the first one is the warm-up
MAX_GROWTH = 5.0  # MB


def soak_inprocess(
    steps: int = 10_000_000, name: str = "knuckle_setpoint"
) -> tuple[list[Metric], dict[str, Any]]:
    """Take `steps` steps by each of the two methods; return (metrics, data)."""
    block = max(steps // BLOCKS, 1)
    methods: dict[str, Callable[[Scene, int], Iterator[None]]] = {
        "Plant.advance": _advance_plant,
        "simulate": _simulate_repeatedly,
    }
    metrics, data = [], dict[str, Any]()
    for method, blocks in methods.items():
        memory, rates, speeds = _measure_blocks(blocks(load_scene(name), block), block)
        ends = [block * (i + 1) for i in range(BLOCKS)]
        data[method] = {
            "steps": ends,
            "memory_MB": memory,
            "steps_per_second": rates,
            "processor_speed": speeds,
        }
        metrics += [
            Metric(f"{method}, steps", ends[-1]),
            at_most(
                f"{method}, growth of resident memory", memory[-1] - memory[0], MAX_GROWTH, "MB"
            ),
            *drift_metrics(rates[1:], speeds[1:], f"{method}, "),
        ]
    return metrics, data


def _measure_blocks(
    blocks: Iterator[None], steps: int
) -> tuple[list[float], list[float], list[float]]:
    """Return memory [MB], rate [steps/s] and processor speed after each block of steps.

    Memory is resident memory.
    """
    memory, rates, speeds = [], [], []
    start = time.perf_counter()
    for _ in blocks:
        rates.append(steps / (time.perf_counter() - start))
        memory.append(resident(os.getpid()))
        speeds.append(measure_processor_speed())
        start = time.perf_counter()
    return memory, rates, speeds


def _advance_plant(scene: Scene, block: int) -> Iterator[None]:
    """Step one plant with its law, block by block."""
    plant, law = Plant(scene), scene.law
    if law is None:
        raise RuntimeError(f"scene {scene.name} has no law")
    for _ in range(BLOCKS):
        for _ in range(block):
            plant.advance(law(plant.t, plant.q, plant.v))
        yield


def _simulate_repeatedly(scene: Scene, block: int) -> Iterator[None]:
    """Simulate the same run repeatedly, a block each."""
    run = replace(scene, duration=block * scene.period)
    for _ in range(BLOCKS):
        simulate(run)
        yield
