"""A run in real time at 1 kHz against a loop that only sleeps: `crane bench realtime`.

The bare loop, in a process of its own, sleeps until the same absolute deadlines and does nothing else: its
lateness is that of the system's timer and scheduler.
"""

import json
import subprocess
import sys
import time
from typing import Any

from crane_bench.speed.measurement import describe_spread, machine, ratio
from crane_sim import load_scene
from crane_sim.orchestration import run
from crane_sim.process_signals import set_parent_death_signal
from crane_sim.ros.common.timing import StepTiming, minimize_timer_slack

LABELS = {"bare": "a loop that only sleeps", "plant": "plant, with its controller"}
_PROGRAM = """
import json
from crane_bench.speed.realtime import run_sleep_loop
print(json.dumps(run_sleep_loop({period}, {steps})))
"""


def run_sleep_loop(period: float, steps: int) -> dict[str, Any]:
    """Sleep until each of `steps` deadlines, a period [s] apart; return the metrics of a real-time run's summary.

    Like a plant's, the calling thread has the least timer slack from then on.
    """
    timing, misses = StepTiming(), 0
    minimize_timer_slack()
    due = start = time.monotonic()
    for _ in range(steps):
        due += period
        if (remaining := due - time.monotonic()) > 0.0:
            time.sleep(remaining)
        timing.note(due, time.monotonic())
        misses += time.monotonic() > due + period
    wall = time.monotonic() - start
    return timing.metrics() | {"steps_per_second": steps / wall, "deadline_misses": misses}


def run_sleep_process(period: float, steps: int) -> dict[str, Any]:
    """Return the metrics of `run_sleep_loop` in a process of its own."""
    command = [sys.executable, "-c", _PROGRAM.format(period=period, steps=steps)]
    return json.loads(
        subprocess.run(command, check=True, stdout=subprocess.PIPE, preexec_fn=set_parent_death_signal()).stdout
    )


def measure_real_time(
    name: str = "knuckle_setpoint", period: float = 0.001, duration: float = 10.0, rounds: int = 5
) -> dict[str, Any]:
    """Return the timing errors of real-time runs and of the bare loop, interleaved.

    For each of the two: quantiles of the lateness (step taken after its deadline) and of the period error, or jitter
    (distance of one period from its nominal length), µs; overruns, steps that end after the next deadline; the mean
    rate, Hz.

    Args:
        name: scene of the catalogue, with a sampled law.
        period: control period, s.
        duration: s per round.
        rounds: of both.

    Raises:
        RuntimeError: a run failed; the message is one line.
    """
    scene = load_scene(name, {"duration": duration, "control.period": period})
    summaries: dict[str, list[dict[str, Any]]] = {"bare": [], "plant": []}
    for _ in range(rounds):
        summaries["bare"].append(run_sleep_process(period, scene.steps))
        summary = run(scene, mode="realtime", record=None)
        if "error" in summary:
            raise RuntimeError(summary["error"])
        summaries["plant"].append(summary)
    kinds = {kind: _timing_metrics(values) for kind, values in summaries.items()}
    p99_by_round = (kinds[kind]["period_error_us"]["p99"]["rounds"] for kind in ("plant", "bare"))
    return {
        "scene": name,
        "period_s": period,
        "steps_per_round": scene.steps,
        "rounds": rounds,
        **kinds,
        "ratio_of_p99_period_errors": ratio(*p99_by_round),
        "machine": machine(),
    }


def _timing_metrics(summaries: list[dict[str, Any]]) -> dict[str, Any]:
    errors = {
        key: {name: describe_spread([round_[key][name] for round_ in summaries]) for name in summaries[0][key]}
        for key in ("lateness_us", "period_error_us")
    }
    rate = describe_spread([round_["steps_per_second"] for round_ in summaries])
    return errors | {"rate_Hz": rate, "overruns": [round_["deadline_misses"] for round_ in summaries]}


def format_real_time(results: dict[str, Any]) -> list[str]:
    """Return the metrics of both in lines."""
    steps, rate = results["steps_per_round"], 1.0 / results["period_s"]
    lines = [f"{steps} periods at {rate:g} Hz, medians of {results['rounds']} interleaved rounds, µs"]
    return lines + [f"  {label:<28} {_line(results[kind])}" for kind, label in LABELS.items()]


def _line(metrics: dict[str, Any]) -> str:
    parts = []
    for key, words in (("period_error_us", "period error"), ("lateness_us", "late")):
        numbers = "/".join(f"{values['median']:.0f}" for values in metrics[key].values())
        parts.append(f"{words} p50/p99/max {numbers}")
    over, rate = sum(metrics["overruns"]), metrics["rate_Hz"]["median"]
    return f"{', '.join(parts)}; {over} overruns, {rate:.3f} Hz"
