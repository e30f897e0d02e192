"""Resident memory and rate over a long lockstep run: `crane soak memory`."""

from typing import Any

import numpy as np

from crane_bench.soak.drift import drift_metrics
from crane_bench.soak.metrics import Metric, at_most, equal
from crane_bench.speed import memory

MAX_GROWTH = 5.0  # MB that a process may grow after the warm-up
_WARM_UP = 60.0  # s, in short soaks a third of the time


def soak_memory(seconds: float = 1800.0) -> tuple[list[Metric], dict[str, Any]]:
    """Run for `seconds`; return (metrics, data)."""
    warm_up = min(_WARM_UP, seconds / 3.0)
    measured = memory.measure_memory(seconds=seconds, warm_up=warm_up)
    metrics = [Metric("wall time", measured["sample_times_s"][-1], "s"), Metric("steps", measured["steps"])]
    metrics += [equal("steps that the recorder says it has", measured["recorded_steps"], measured["steps"])]
    for node, resident in measured["resident"].items():
        metrics += [
            Metric(f"{node}, after the warm-up of {warm_up:g} s", resident["after_warm_up_MB"], "MB"),
            at_most(f"{node}, growth since the warm-up", resident["growth_MB"], MAX_GROWTH, "MB"),
        ]
    times, rates, speeds = _step_rates(measured)
    data: dict[str, Any] = {"seconds": times, "steps_per_second": rates, "processor_speed": speeds}
    data["memory_MB"] = {node: resident["samples_MB"][1:] for node, resident in measured["resident"].items()}
    first = next((i for i, t in enumerate(times) if t > warm_up), len(times))
    return metrics + drift_metrics(rates[first:], speeds[first:]), data


def _step_rates(measured: dict[str, Any]) -> tuple[list[float], list[float], list[float]]:
    """Return the ends [s] of the intervals between two samples of a run, its steps per second and the speeds in them.

    A speed is the mean of those at both ends of the interval.
    """
    times, steps = np.array(measured["sample_times_s"]), np.array(measured["sample_steps"])
    speeds = np.array(measured["sample_processor_speeds"])
    means = 0.5 * (speeds[1:] + speeds[:-1])
    return times[1:].tolist(), (np.diff(steps) / np.diff(times)).tolist(), means.tolist()
