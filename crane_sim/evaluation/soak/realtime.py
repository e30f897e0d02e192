"""1 kHz in real time: rate, overruns as an independent subscriber counts them, punctuality: `crane soak realtime`."""

import time
from typing import Any

import numpy as np

from crane_sim import load_scene
from crane_sim.evaluation.bench.realtime import bare_apart
from crane_sim.evaluation.soak.figures import Figure, at_most
from crane_sim.evaluation.soak.monitor import Received, monitor, wait_for_discovery
from crane_sim.orchestration import run
from crane_sim.orchestration.ros_environment import reserve_domain

PERIOD = 0.001  # s
ROUND = 10.0  # s of the bare loop, then as many of the plant
_RATE, _RATIO = 0.1, 1.5  # Hz that the mean rate may be off; p99 of the plant's period error against the bare loop's

_DOUBT = 0.5  # % of the steps
_UNCLEAR = 300_000  # ns: what the quickest step takes to send its state, and what a step does behind its last message


def soak(seconds: float = 60.0, name: str = "knuckle_setpoint") -> tuple[list[Figure], dict[str, Any]]:
    """Run for so long, in rounds; return figures, and the data behind them."""
    rounds = max(round(seconds / ROUND), 1)
    scene = load_scene(name, {"duration": seconds / rounds, "control.period": PERIOD})
    data: dict[str, list[Any]] = {name: [] for name in ("bare", "plant", "counted", "unclear", "rates")}
    with reserve_domain() as domain, monitor(scene, domain) as monitored:
        for _ in range(rounds):
            data["bare"].append(bare_apart(PERIOD, scene.steps))
            summary = run(scene, mode="realtime", record=None, domain_id=domain, on_filled=wait_for_discovery)
            if "error" in summary:
                raise RuntimeError(summary["error"])
            data["plant"].append(summary)
            time.sleep(0.1)  # ten times the interval at which the monitor writes
            received = monitored.read()
            late = lateness(received["s"], received["e"], scene.period_ns)
            data["counted"].append(int(np.count_nonzero(late > scene.period_ns)))
            data["unclear"].append(int(np.count_nonzero(late > scene.period_ns - _UNCLEAR)) - data["counted"][-1])
            states = received["s"]
            data["rates"].append((len(states) - 1) * 1e9 / (states[-1].sent - states[0].sent))
    return _figures(**data), data


def lateness(states: list[Received], efforts: list[Received], period: int) -> np.ndarray:
    """Return how long after its deadline each step sent the last of its messages, the applied effort (N,), ns.

    The schedule is not known: it is the latest one that no step is ahead of with its state, so a step is at least as
    late as found here. The first state, stamped with one period, is that of no step.
    """
    begin = min(state.sent - state.stamp for state in states if state.stamp > period)
    return np.array([effort.sent - (effort.stamp + period) - begin for effort in efforts])


def _figures(
    bare: list[dict[str, Any]],
    plant: list[dict[str, Any]],
    counted: list[int],
    unclear: list[int],
    rates: list[float],
) -> list[Figure]:
    off = max(abs(rate - 1.0 / PERIOD) for rate in rates)
    p99 = [(p["period_error_us"]["p99"], b["period_error_us"]["p99"]) for p, b in zip(plant, bare, strict=True)]
    ratio = float(np.median([ours / theirs for ours, theirs in p99]))
    own, steps = [summary["deadline_misses"] for summary in plant], sum(summary["steps"] for summary in plant)
    return [
        Figure("rounds", len(plant)),
        Figure("mean rate, heard", float(np.mean(rates)), "Hz"),
        at_most("mean rate of a round, farthest off", off, _RATE, "Hz"),
        Figure("overruns of the bare loop", sum(round_["deadline_misses"] for round_ in bare)),
        Figure("overruns, the plant's own count", sum(own)),
        Figure("overruns, the subscriber's count", sum(counted)),
        Figure("steps too close to their deadline to be counted", sum(unclear)),
        at_most("their difference, of all steps", 100.0 * abs(sum(own) - sum(counted)) / steps, _DOUBT, "%"),
        Figure("period error p99, plant", float(np.median([ours for ours, _ in p99])), "us"),
        Figure("period error p99, bare loop", float(np.median([theirs for _, theirs in p99])), "us"),
        at_most("their ratio, median of the rounds", ratio, _RATIO),
    ]
