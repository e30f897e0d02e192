"""Resident memory and rate over a long lockstep run: `crane soak memory`."""

import os
import signal
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from crane_bench.soak.drift import drift_metrics
from crane_bench.soak.metrics import Metric, at_most, equal
from crane_bench.speed.measurement import measure_processor_speed
from crane_sim import load_scene
from crane_sim.orchestration import run

SCENE = "knuckle_setpoint"
MAX_GROWTH = 5.0  # MB that a process may grow after the warm-up
_WARM_UP = 60.0  # s, in short soaks a third of the time
INTERVAL = 1.0  # s between samples
# steps/s, more than any lockstep makes: the run must not end before it is stopped
_MAX_STEP_RATE = 30_000.0
_MB = 1e6


def resident(pid: int) -> float | None:
    """Return the resident memory [MB] of a process, None where it has exited."""
    try:
        return (
            int(Path(f"/proc/{pid}/statm").read_text().split()[1])
            * os.sysconf("SC_PAGE_SIZE")
            / _MB
        )
    except (FileNotFoundError, ProcessLookupError):
        # the second one: it exits between opening and reading
        return None


class MemorySampler:
    """Samples the memory of a run's nodes once a second, and interrupts the run after its time.

    Attributes:
        times: s of the run, one per sample.
        samples: (time [s], resident memory [MB]) by node, for the time that its process exists.
        steps: of the run, one number per sample.
        speeds: of the processor, see `measure_processor_speed`, one per sample.
    """

    def __init__(self, seconds: float) -> None:
        """Sample the run that this process is about to start, from its first step on."""
        self.times: list[float] = []
        self.samples: dict[str, list[tuple[float, float]]] = {}
        self.steps: list[int] = []
        self.speeds: list[float] = []
        self._seconds, self._start, self._pids = seconds, 0.0, dict[str, int]()

    def on_activated(self, name: str, pid: int) -> None:
        """Record the process id of a node."""
        self._pids[name] = pid

    def __call__(self, step: int, steps: int) -> None:
        """Take a sample if one is due; called about ten times a second by the run."""
        if step == 0 or not self._pids:
            return
        self._start = self._start or time.monotonic()
        elapsed = time.monotonic() - self._start
        if elapsed >= len(self.times) * INTERVAL:
            self.times.append(elapsed)
            self.steps.append(step)
            self.speeds.append(measure_processor_speed())
            for name, pid in self._pids.items():
                if (memory := resident(pid)) is not None:
                    self.samples.setdefault(name, []).append((elapsed, memory))
        if elapsed >= self._seconds and len(self.times) > self._seconds / INTERVAL:
            # after a stall, all its samples
            signal.raise_signal(signal.SIGINT)  # as a user ends a run: in order, files complete


def run_sampled(seconds: float) -> tuple[MemorySampler, dict[str, Any]]:
    """Return (samples, summary) of a recorded lockstep run, interrupted after some seconds.

    To be called from the main thread, which receives the interrupt.

    Raises:
        RuntimeError: the run failed; the message is one line.
    """
    sampler, period = MemorySampler(seconds), load_scene(SCENE).period
    scene = load_scene(SCENE, {"duration": _MAX_STEP_RATE * period * max(seconds, 1.0)})
    with tempfile.TemporaryDirectory(prefix="crane_sim-") as folder:
        options = {"on_progress": sampler, "on_activated": sampler.on_activated}
        summary = run(scene, record=Path(folder, "soak.rrd"), **options)
    if summary.get("error") != "interrupted":
        raise RuntimeError(summary.get("error", "the run ended before its time"))
    if not sampler.times or sampler.times[-1] < seconds - 2.0 * INTERVAL:
        raise RuntimeError("interrupted")  # from outside, before the time was over
    return sampler, summary


def soak_memory(seconds: float = 1800.0) -> tuple[list[Metric], dict[str, Any]]:
    """Run for `seconds`; return (metrics, data)."""
    warm_up = min(_WARM_UP, seconds / 3.0)
    sampler, summary = run_sampled(seconds)
    taken, recorded = summary["steps"], summary.get("recorded_steps")
    metrics = [
        Metric("wall time", sampler.times[-1], "s"),
        Metric("steps", taken),
        equal("steps that the recorder says it has", recorded, taken),
    ]
    for node, samples in sampler.samples.items():
        metrics += _node_metrics(node, samples, warm_up)
    times, steps, speeds = map(np.array, (sampler.times, sampler.steps, sampler.speeds))
    rates, means = np.diff(steps) / np.diff(times), 0.5 * (speeds[1:] + speeds[:-1])
    data = {
        "seconds": times[1:].tolist(),
        "steps_per_second": rates.tolist(),
        "processor_speed": means.tolist(),
    }
    data["memory_MB"] = {
        node: [memory for _, memory in own[1:]] for node, own in sampler.samples.items()
    }
    late = times[1:] > warm_up
    return metrics + drift_metrics(rates[late].tolist(), means[late].tolist()), data


def _node_metrics(node: str, samples: list[tuple[float, float]], warm_up: float) -> list[Metric]:
    """Return the memory of a node behind the warm-up, and its growth since."""
    warm, *later = [memory for t, memory in samples if t >= warm_up] or [samples[-1][1]]
    growth = (later or [warm])[-1] - warm
    return [
        Metric(f"{node}, after the warm-up of {warm_up:g} s", warm, "MB"),
        at_most(f"{node}, growth since the warm-up", growth, MAX_GROWTH, "MB"),
    ]
