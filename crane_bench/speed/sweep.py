"""Work against precision: every run once for its error, the promising ones in rounds.

The rounds are interleaved.
"""

import statistics
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.speed.cases import ERROR_LEVELS, ReferenceSolution
from crane_bench.speed.engine import Run

Array = npt.NDArray[np.float64]
MIN_TIMING = 2e-3  # s, of a timing: shorter runs are repeated within it
SLOWEST = 1.5  # s of wall time, from which on a method's finer settings are not tried
ROUNDS, PATIENCE = 20, 10.0
"""Timings of each promising run, while all those of one engine take less than PATIENCE [s]; at
least three."""
PROBES, QUICK = 5, 0.02
"""Timings of a run that takes less than QUICK [s], of which the least says whether it is promising;
of others one."""
CLOSE = 1.3  # times the cheapest one's time at an error: runs that may well be the cheapest
BEST = 2e-13  # m, an error below which finer settings are not tried


class WorkPrecisionPoint(NamedTuple):
    """One run, measured."""

    engine: str
    method: str
    setting: float  # step [s] or relative tolerance
    error: float  # m, of the payload at the end; inf where the run failed
    tension_error: float | None  # N, at the end
    us_per_s: float  # µs of wall time per simulated second, least of the timings
    median: float  # of the timings
    timings: int
    evaluations: int | None
    steps: int | None
    attitude_error: float | None = None  # rad, of a rigid load at the end


class Trial(NamedTuple):
    """A run after its first execution."""

    run: Run
    error: float
    tension_error: float | None
    seconds: float  # of one execution
    evaluations: int | None
    steps: int | None
    attitude_error: float | None = None  # rad


def run_trial(run: Run, reference: ReferenceSolution) -> Trial:
    """Execute a run for its error, and a short one again for its time."""
    start = time.perf_counter()
    outcome = run.execute(1)
    seconds = time.perf_counter() - start
    if seconds < SLOWEST / 10.0:  # cheap enough to repeat, with everything loaded
        start = time.perf_counter()
        run.execute(1)
        seconds = time.perf_counter() - start
    error = float(np.linalg.norm(np.asarray(outcome.payload, float) - reference.payload))
    tension_error = None
    if reference.tension is not None and outcome.tension is not None:
        tension_error = abs(outcome.tension - reference.tension)
    attitude_error = None
    if reference.attitude is not None and outcome.attitude is not None:
        attitude_error = angle_between(outcome.attitude, reference.attitude)
    if not np.isfinite(error):
        error, tension_error, attitude_error = np.inf, None, None
    return Trial(
        run, error, tension_error, seconds, outcome.evaluations, outcome.steps, attitude_error
    )


def angle_between(a: Array, b: Array) -> float:
    """Return the angle [rad] by which one rotation matrix (3, 3) is turned from another."""
    return float(2.0 * np.arcsin(min(np.linalg.norm(a - b) / np.sqrt(8.0), 1.0)))


def sweep_method(runs: Iterable[Run], reference: ReferenceSolution) -> list[Trial]:
    """Return the trials of one method, coarsest first, until they are exact or too slow."""
    trials: list[Trial] = []
    for run in runs:
        trials.append(run_trial(run, reference))
        if trials[-1].seconds > SLOWEST or trials[-1].error < max(
            BEST, 2.0 * reference.error_bound
        ):
            break
    return trials


def select_candidates(trials: Sequence[Trial]) -> set[int]:
    """Return the indices of one engine's trials that may be the cheapest at one of the errors."""
    candidates: set[int] = set()
    for level in ERROR_LEVELS:
        good = [i for i, trial in enumerate(trials) if trial.error <= level]
        least = min((trials[i].seconds for i in good), default=0.0)
        candidates |= {
            i
            for i in sorted(good, key=lambda i: trials[i].seconds)[:4]
            if trials[i].seconds <= CLOSE * least
        }
    return candidates


def time_run(run: Run, seconds: float) -> float:
    """Return the wall time [s] of one execution of a run that takes about `seconds`."""
    repetitions = max(1, round(MIN_TIMING / max(seconds, 1e-7)))
    start = time.perf_counter()
    run.execute(repetitions)
    return (time.perf_counter() - start) / repetitions


def measure_points(
    trials: dict[str, list[Trial]], duration: float, on_progress: Callable[[str], Any]
) -> list[WorkPrecisionPoint]:
    """Return the points of all trials, by engine.

    The promising ones are timed in rounds, engines interleaved.

    Args:
        trials: by engine.
        duration: simulated seconds of a run.
        on_progress: called with a line at each step.
    """
    timings = {
        (name, i): [time_run(t.run, t.seconds) for _ in range(PROBES if t.seconds < QUICK else 1)]
        for name, own in trials.items()
        for i, t in enumerate(own)
    }
    candidates = {
        name: select_candidates(
            [t._replace(seconds=min(timings[name, i])) for i, t in enumerate(own)]
        )
        for name, own in trials.items()
    }
    rounds = {name: _rounds(trials[name], indices) for name, indices in candidates.items()}
    for k in range(max(rounds.values(), default=0)):
        on_progress(f"round {k + 1} of {max(rounds.values())}")
        for name, indices in candidates.items():
            for i in indices if k < rounds[name] else ():
                timings[name, i].append(time_run(trials[name][i].run, min(timings[name, i])))
    return [
        _point(t, timings[name, i], duration)
        for name, own in trials.items()
        for i, t in enumerate(own)
    ]


def _rounds(trials: Sequence[Trial], indices: set[int]) -> int:
    round_time = sum(max(MIN_TIMING, trials[i].seconds) for i in indices)
    return min(ROUNDS, max(3, int(PATIENCE / round_time))) if indices else 0


def _point(trial: Trial, seconds: Sequence[float], duration: float) -> WorkPrecisionPoint:
    run, scale = trial.run, 1e6 / duration
    times = min(seconds) * scale, statistics.median(seconds) * scale, len(seconds)
    counts = trial.evaluations, trial.steps, trial.attitude_error
    return WorkPrecisionPoint(
        run.engine, run.method, run.setting, trial.error, trial.tension_error, *times, *counts
    )


def cheapest(points: Iterable[WorkPrecisionPoint], level: float) -> WorkPrecisionPoint | None:
    """Return the fastest point with an error of at most `level` [m]; None when there is none."""
    return min((p for p in points if p.error <= level), key=lambda p: p.us_per_s, default=None)
