"""Resident memory of the processes of a long lockstep run: `crane bench memory`."""

import os
import signal
import statistics
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crane_bench.speed.measurement import machine, measure_processor_speed
from crane_sim import load_scene
from crane_sim.orchestration import run

INTERVAL = 1.0  # s between samples
_MAX_STEP_RATE = 30_000.0  # steps/s, more than any lockstep makes: the run must not end before it is stopped
_MB = 1e6


def resident(pid: int) -> float | None:
    """Return the resident memory [MB] of a process, None where it has exited."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / _MB
    except (FileNotFoundError, ProcessLookupError):  # the second one: it exits between opening and reading
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
        if elapsed >= self._seconds and len(self.times) > self._seconds / INTERVAL:  # after a stall, all its samples
            signal.raise_signal(signal.SIGINT)  # as a user ends a run: in order, files complete


def measure_memory(
    name: str = "knuckle_setpoint", seconds: float = 600.0, warm_up: float = 60.0, recorder: bool = True
) -> dict[str, Any]:
    """Return the resident memory [MB] of plant, controller and recorder over a lockstep run, and how it grows.

    To be called from the main thread, which receives the interrupt that ends the run.

    Args:
        name: scene of the catalogue, with a sampled law.
        seconds: of wall time.
        warm_up: s of it in which memory may grow without being counted.
        recorder: record, to a file that is then removed (about 1 kB per step).

    Raises:
        RuntimeError: the run failed; the message is one line.
    """
    sampler = MemorySampler(seconds)
    period = load_scene(name).period
    scene = load_scene(name, {"duration": _MAX_STEP_RATE * period * max(seconds, 1.0)})
    with tempfile.TemporaryDirectory(prefix="crane_sim-") as folder:
        path = Path(folder, "bench.rrd") if recorder else None
        summary = run(scene, record=path, on_progress=sampler, on_activated=sampler.on_activated)
    if summary.get("error") != "interrupted":
        raise RuntimeError(summary.get("error", "the run ended before its time"))
    if not sampler.times or sampler.times[-1] < seconds - 2.0 * INTERVAL:
        raise RuntimeError("interrupted")  # from outside, before the time was over
    return {
        "scene": name,
        "seconds": seconds,
        "warm_up_s": warm_up,
        "steps": summary["steps"],
        "recorded_steps": summary.get("recorded_steps"),  # None: without a recorder
        "sample_times_s": [round(t, 3) for t in sampler.times],
        "sample_steps": sampler.steps,
        "sample_processor_speeds": [round(speed) for speed in sampler.speeds],
        "resident": {node: memory_metrics(samples, warm_up) for node, samples in sampler.samples.items()},
        "machine": machine(),
    }


def memory_metrics(samples: Sequence[tuple[float, float]], warm_up: float) -> dict[str, Any]:
    """Return the metrics of a process's samples (time [s], MB), of which those before `warm_up` [s] are no growth."""
    times, resident_MB = zip(*([sample for sample in samples if sample[0] >= warm_up] or samples[-1:]), strict=True)
    slope = statistics.linear_regression(times, resident_MB).slope if len(times) > 1 else 0.0
    return {
        "start_MB": samples[0][1],
        "after_warm_up_MB": resident_MB[0],
        "end_MB": resident_MB[-1],
        "most_MB": max(memory for _, memory in samples),
        "growth_MB": resident_MB[-1] - resident_MB[0],
        "slope_MB_per_hour": slope * 3600.0,
        "samples_MB": [round(memory, 3) for _, memory in samples],
    }


def format_memory(results: dict[str, Any]) -> list[str]:
    """Return the memory of every process in lines."""
    lines = [f"resident memory over {results['seconds']:g} s of lockstep, {results['steps']} steps, MB"]
    for node, metrics in results["resident"].items():
        start, warm, end = (metrics[f"{key}_MB"] for key in ("start", "after_warm_up", "end"))
        growth = f"growth {metrics['growth_MB']:+.2f} ({metrics['slope_MB_per_hour']:+.1f} per hour)"
        warmed = f"{warm:6.1f} after {results['warm_up_s']:g} s"
        lines.append(f"  {node:<11} {start:6.1f} at the start, {warmed}, {end:6.1f} at the end: {growth}")
    return lines
