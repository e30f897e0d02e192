"""1 kHz in real time: rate, overruns and period error, `crane soak realtime`.

An independent subscriber counts the overruns.
"""

import json
import statistics
import subprocess
import sys
import time
from typing import Any

import numpy as np

from crane_bench.soak.metrics import Metric, at_most
from crane_bench.soak.monitor import Messages, Received, monitor, wait_for_discovery
from crane_bench.speed.measurement import ratio
from crane_sim import load_scene
from crane_sim.orchestration import run
from crane_sim.orchestration.ros_environment import reserve_domain
from crane_sim.process_signals import set_parent_death_signal
from crane_sim.ros.common.timing import StepTiming, minimize_timer_slack
from crane_sim.scenes.scene import Scene

PERIOD = 0.001  # s
ROUND = 10.0  # s of the bare loop, then as many of each run
# Hz, deviation of the mean rate; p99 of the plant's period error against the bare loop's
_RATE, _RATIO = 0.1, 1.5

_MAX_DIFFERENCE = 0.5  # % of the steps, between the two counts of overruns
# ns: from the start of the quickest step to its state's message, and from a step's last message to
# its end
_MARGIN = 300_000


_PROGRAM = """
import json
from crane_bench.soak.realtime import run_sleep_loop
print(json.dumps(run_sleep_loop({period}, {steps})))
"""


def run_sleep_loop(period: float, steps: int) -> dict[str, Any]:
    """Sleep until each of `steps` deadlines, a period [s] apart; return real-time metrics.

    They are those of a run's summary.

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
        subprocess.run(
            command, check=True, stdout=subprocess.PIPE, preexec_fn=set_parent_death_signal()
        ).stdout
    )


def soak_real_time(
    seconds: float = 60.0, name: str = "knuckle_setpoint"
) -> tuple[list[Metric], dict[str, Any]]:
    """Run for `seconds` in rounds of bare loop, run, and run with monitor: (metrics, data).

    The plant measures its period error itself. On a machine with few cores the monitor takes time
    from the nodes that it observes, so the run that is compared with the bare loop has none.
    """
    rounds = max(round(seconds / ROUND), 1)
    scene = load_scene(name, {"duration": seconds / rounds, "control.period": PERIOD})
    data: dict[str, list[Any]] = {
        name: [] for name in ("bare", "alone", "monitored", "counted", "near_deadline", "rates")
    }
    for _ in range(rounds):
        data["bare"].append(run_sleep_process(PERIOD, scene.steps))
        with reserve_domain() as domain:
            data["alone"].append(_run(scene, domain))
            with monitor(scene, domain) as monitored:
                data["monitored"].append(_run(scene, domain))
                received: Messages = {}
                monitored.read_to_end(received, lambda messages: len(messages["e"]) >= scene.steps)
        delays = completion_delays(received["s"], received["e"], scene.period_ns)
        data["counted"].append(int(np.count_nonzero(delays > scene.period_ns)))
        data["near_deadline"].append(
            int(np.count_nonzero(delays > scene.period_ns - _MARGIN)) - data["counted"][-1]
        )
        data["rates"].append(mean_rate([state.sent for state in received["s"]]))
    return _compute_metrics(**data), data


def _run(scene: Scene, domain: int) -> dict[str, Any]:
    """Return the summary of a run in real time without a recorder."""
    summary = run(
        scene, mode="realtime", record=None, domain_id=domain, on_activated=wait_for_discovery
    )
    if "error" in summary:
        raise RuntimeError(summary["error"])
    return summary


def completion_delays(states: list[Received], efforts: list[Received], period: int) -> np.ndarray:
    """Return the time from each step's deadline to its last message, the applied effort (N,), ns.

    The plant's schedule is not measured. It is taken as the latest one for which no state is early,
    so the true delays are at least these. The first state, stamped with one period, is that of no
    step.
    """
    begin = min(state.sent - state.stamp for state in states if state.stamp > period)
    return np.array([effort.sent - (effort.stamp + period) - begin for effort in efforts])


def mean_rate(sent: list[int]) -> float:
    """Return the rate [Hz] of messages sent at instants [ns], by a line of least squares.

    The first and the last message alone would not do: 1 ms of delay of either is 0.1 Hz over 10 s.
    """
    index = np.arange(len(sent)) - 0.5 * (len(sent) - 1)
    return 1e9 * float(index @ index) / float(index @ (np.array(sent) - sent[0]))


def _compute_metrics(
    bare: list[dict[str, Any]],
    alone: list[dict[str, Any]],
    monitored: list[dict[str, Any]],
    counted: list[int],
    near_deadline: list[int],
    rates: list[float],
) -> list[Metric]:
    deviation = max(abs(rate - 1.0 / PERIOD) for rate in rates)
    misses, steps = _overruns(monitored), sum(summary["steps"] for summary in monitored)
    difference = 100.0 * abs(misses - sum(counted)) / steps
    error_ratio = ratio(_period_errors(alone), _period_errors(bare))["median"]
    monitored_error = statistics.median(_period_errors(monitored))
    return [
        Metric("rounds", len(monitored)),
        Metric("overruns of the bare loop", _overruns(bare)),
        Metric("overruns, run by itself", _overruns(alone)),
        Metric("period error p99, bare loop", statistics.median(_period_errors(bare)), "us"),
        Metric("period error p99, run by itself", statistics.median(_period_errors(alone)), "us"),
        at_most("their ratio, median of the rounds", error_ratio, _RATIO),
        Metric("period error p99, beside the monitor", monitored_error, "us"),
        Metric("mean rate, heard", float(np.mean(rates)), "Hz"),
        at_most("mean rate of a round, farthest off", deviation, _RATE, "Hz"),
        Metric("overruns beside the monitor, the plant's count", misses),
        Metric("overruns beside the monitor, its count", sum(counted)),
        Metric("steps too close to their deadline to be counted", sum(near_deadline)),
        at_most("their difference, of all steps", difference, _MAX_DIFFERENCE, "%"),
    ]


def _overruns(rounds: list[dict[str, Any]]) -> int:
    return sum(round_["deadline_misses"] for round_ in rounds)


def _period_errors(rounds: list[dict[str, Any]]) -> list[float]:
    """Return the 99 % quantile of each round, us."""
    return [round_["period_error_us"]["p99"] for round_ in rounds]
