"""1 kHz in real time: rate, overruns as an independent subscriber counts them, period error: `crane soak realtime`."""

import time
from typing import Any

import numpy as np

from crane_sim import load_scene
from crane_sim.evaluation.bench.realtime import run_sleep_process
from crane_sim.evaluation.soak.metrics import Metric, at_most
from crane_sim.evaluation.soak.monitor import Received, monitor, wait_for_discovery
from crane_sim.orchestration import run
from crane_sim.orchestration.ros_environment import reserve_domain

PERIOD = 0.001  # s
ROUND = 10.0  # s of the bare loop, then as many of the plant
_RATE, _RATIO = 0.1, 1.5  # Hz, deviation of the mean rate; p99 of the plant's period error against the bare loop's

_MAX_DIFFERENCE = 0.5  # % of the steps, between the two counts of overruns
_MARGIN = (
    300_000  # ns: from the start of the quickest step to its state's message, and from a step's last message to its end
)


def soak(seconds: float = 60.0, name: str = "knuckle_setpoint") -> tuple[list[Metric], dict[str, Any]]:
    """Run for `seconds`, in rounds; return (metrics, data)."""
    rounds = max(round(seconds / ROUND), 1)
    scene = load_scene(name, {"duration": seconds / rounds, "control.period": PERIOD})
    data: dict[str, list[Any]] = {name: [] for name in ("bare", "plant", "counted", "near_deadline", "rates")}
    with reserve_domain() as domain, monitor(scene, domain) as monitored:
        for _ in range(rounds):
            data["bare"].append(run_sleep_process(PERIOD, scene.steps))
            summary = run(scene, mode="realtime", record=None, domain_id=domain, on_activated=wait_for_discovery)
            if "error" in summary:
                raise RuntimeError(summary["error"])
            data["plant"].append(summary)
            time.sleep(0.1)  # ten times the interval at which the monitor writes
            received = monitored.read()
            delays = completion_delays(received["s"], received["e"], scene.period_ns)
            data["counted"].append(int(np.count_nonzero(delays > scene.period_ns)))
            data["near_deadline"].append(
                int(np.count_nonzero(delays > scene.period_ns - _MARGIN)) - data["counted"][-1]
            )
            states = received["s"]
            data["rates"].append((len(states) - 1) * 1e9 / (states[-1].sent - states[0].sent))
    return _compute_metrics(**data), data


def completion_delays(states: list[Received], efforts: list[Received], period: int) -> np.ndarray:
    """Return the time from each step's deadline to its last message, the applied effort (N,), ns.

    The plant's schedule is not measured. It is taken as the latest one for which no state is early, so the true delays
    are at least these. The first state, stamped with one period, is that of no step.
    """
    begin = min(state.sent - state.stamp for state in states if state.stamp > period)
    return np.array([effort.sent - (effort.stamp + period) - begin for effort in efforts])


def _compute_metrics(
    bare: list[dict[str, Any]],
    plant: list[dict[str, Any]],
    counted: list[int],
    near_deadline: list[int],
    rates: list[float],
) -> list[Metric]:
    deviation = max(abs(rate - 1.0 / PERIOD) for rate in rates)
    p99 = [(p["period_error_us"]["p99"], b["period_error_us"]["p99"]) for p, b in zip(plant, bare, strict=True)]
    ratio = float(np.median([of_plant / of_bare for of_plant, of_bare in p99]))
    plant_counts, steps = [summary["deadline_misses"] for summary in plant], sum(summary["steps"] for summary in plant)
    return [
        Metric("rounds", len(plant)),
        Metric("mean rate, heard", float(np.mean(rates)), "Hz"),
        at_most("mean rate of a round, farthest off", deviation, _RATE, "Hz"),
        Metric("overruns of the bare loop", sum(round_["deadline_misses"] for round_ in bare)),
        Metric("overruns, the plant's own count", sum(plant_counts)),
        Metric("overruns, the subscriber's count", sum(counted)),
        Metric("steps too close to their deadline to be counted", sum(near_deadline)),
        at_most(
            "their difference, of all steps",
            100.0 * abs(sum(plant_counts) - sum(counted)) / steps,
            _MAX_DIFFERENCE,
            "%",
        ),
        Metric("period error p99, plant", float(np.median([of_plant for of_plant, _ in p99])), "us"),
        Metric("period error p99, bare loop", float(np.median([of_bare for _, of_bare in p99])), "us"),
        at_most("their ratio, median of the rounds", ratio, _RATIO),
    ]
