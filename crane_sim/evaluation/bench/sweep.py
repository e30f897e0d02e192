"""Work against precision: every run once for its error, then the promising ones in rounds, taking turns."""

import statistics
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from crane_sim.evaluation.bench.cases import LEVELS, Truth
from crane_sim.evaluation.bench.engine import Run

MIN_TIMING = 2e-3  # s, of a timing: shorter runs are repeated within it
SLOWEST = 1.5  # s of wall time, from which on a method's finer settings are not tried
ROUNDS, PATIENCE = 20, 10.0
"""Timings of each promising run, as long as all those of one engine take less than so many seconds; at least three."""
CLOSE = 1.3  # times the cheapest one's time at an error: runs that may well be the cheapest
BEST = 1e-11  # m, an error below which finer settings are not tried


class Point(NamedTuple):
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


class Trial(NamedTuple):
    """A run that was done once."""

    run: Run
    error: float
    tension_error: float | None
    seconds: float  # of one pass
    evaluations: int | None
    steps: int | None


def run_trial(run: Run, truth: Truth) -> Trial:
    """Do a run for its error, and a short one once more for its time."""
    began = time.perf_counter()
    outcome = run.go(1)
    seconds = time.perf_counter() - began
    if seconds < SLOWEST / 10.0:  # cheap enough to do once more, with nothing left to load
        began = time.perf_counter()
        run.go(1)
        seconds = time.perf_counter() - began
    error = float(np.linalg.norm(np.asarray(outcome.payload, float) - truth.payload))
    pulled = None
    if truth.tension is not None and outcome.tension is not None:
        pulled = abs(outcome.tension - truth.tension)
    if not np.isfinite(error):
        error, pulled = np.inf, None
    return Trial(run, error, pulled, seconds, outcome.evaluations, outcome.steps)


def sweep_method(runs: Iterable[Run], truth: Truth) -> list[Trial]:
    """Return the trials of one method, coarsest first, until they are exact or take too long."""
    trials: list[Trial] = []
    for run in runs:
        trials.append(run_trial(run, truth))
        if trials[-1].seconds > SLOWEST or trials[-1].error < max(BEST, 2.0 * truth.trusted):
            break
    return trials


def select_candidates(trials: Sequence[Trial]) -> set[int]:
    """Return which trials of one engine may be the cheapest at one of the errors."""
    chosen: set[int] = set()
    for level in LEVELS:
        good = [i for i, trial in enumerate(trials) if trial.error <= level]
        least = min((trials[i].seconds for i in good), default=0.0)
        chosen |= {i for i in sorted(good, key=lambda i: trials[i].seconds)[:4] if trials[i].seconds <= CLOSE * least}
    return chosen


def time_run(run: Run, seconds: float) -> float:
    """Return the wall time [s] of one pass of a run that takes about so long."""
    times = max(1, round(MIN_TIMING / max(seconds, 1e-7)))
    began = time.perf_counter()
    run.go(times)
    return (time.perf_counter() - began) / times


def measure_points(trials: dict[str, list[Trial]], duration: float, on_progress: Callable[[str], Any]) -> list[Point]:
    """Return the points of all trials, by engine; the promising ones are timed in rounds, engines taking turns.

    Args:
        trials: by engine.
        duration: simulated seconds of a run.
        on_progress: called with a line at each step.
    """
    timings = {(name, i): [time_run(t.run, t.seconds)] for name, own in trials.items() for i, t in enumerate(own)}
    chosen = {name: select_candidates([t._replace(seconds=timings[name, i][0]) for i, t in enumerate(own)])
              for name, own in trials.items()}  # fmt: skip
    rounds = {name: _rounds(trials[name], indices) for name, indices in chosen.items()}
    for k in range(max(rounds.values(), default=0)):
        on_progress(f"round {k + 1} of {max(rounds.values())}")
        for name, indices in chosen.items():
            for i in indices if k < rounds[name] else ():
                timings[name, i].append(time_run(trials[name][i].run, timings[name, i][0]))
    return [_point(t, timings[name, i], duration) for name, own in trials.items() for i, t in enumerate(own)]


def _rounds(trials: Sequence[Trial], indices: set[int]) -> int:
    each = sum(max(MIN_TIMING, trials[i].seconds) for i in indices)
    return min(ROUNDS, max(3, int(PATIENCE / each))) if indices else 0


def _point(trial: Trial, seconds: Sequence[float], duration: float) -> Point:
    run, scale = trial.run, 1e6 / duration
    times = min(seconds) * scale, statistics.median(seconds) * scale, len(seconds)
    counted = trial.evaluations, trial.steps
    return Point(run.engine, run.method, run.setting, trial.error, trial.tension_error, *times, *counted)


def cheapest(points: Iterable[Point], level: float) -> Point | None:
    """Return the fastest point with an error of at most `level` [m]; None when there is none."""
    return min((p for p in points if p.error <= level), key=lambda p: p.us_per_s, default=None)
