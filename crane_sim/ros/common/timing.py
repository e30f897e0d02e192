"""Timing of real-time runs: sleeps, distributions of durations, lateness of steps; no rclpy."""

import ctypes
import sys
from array import array

_BIN = 1e-6  # s; quantiles are rounded up to it
# 0.1 s; a longer duration counts in the last bin, but exactly for the largest value
_BINS = 100_000
_QUANTILES = {"p50": 0.50, "p99": 0.99}
_PR_SET_TIMERSLACK = 29  # of prctl(2)
_TOLERATED_SHARE = 0.01  # of the steps: a desktop that does nothing else is late in fewer


def minimize_timer_slack() -> None:
    """Set the timer slack of this thread, and of threads that it starts later, to 1 ns.

    Linux lets ordinary threads sleep up to 50 us longer, so that timers of several expire together.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1))


def describe_violation(steps: int, late: int, unanswered: int) -> str:
    """Return one line on a run that was not in real time, empty for one that was but for few steps.

    Args:
        steps: all of them.
        late: those that had not ended when the next one was due.
        unanswered: those without a new command since the step before, which a time-out of commands
            does not explain.
    """
    if max(late, unanswered) <= _TOLERATED_SHARE * steps:
        return ""
    return f"{late} of {steps} steps were late, and {unanswered} had no new command"


class DurationHistogram:
    """Durations counted in bins: memory does not grow with the run."""

    def __init__(self) -> None:
        """Create it empty."""
        self._counts, self._total, self._largest = array("Q", bytes(8 * _BINS)), 0, 0.0

    def add(self, seconds: float) -> None:
        """Count a duration, s; a negative one as none."""
        self._counts[min(max(int(seconds / _BIN), 0), _BINS - 1)] += 1
        self._total += 1
        self._largest = max(self._largest, seconds)

    def metrics(self) -> dict[str, float]:
        """Return median, 99 % quantile and largest duration, µs: zeros while there is none."""
        return {name: self._quantile(part) for name, part in _QUANTILES.items()} | {
            "max": self._largest * 1e6
        }

    def _quantile(self, part: float) -> float:
        rank, passed = part * self._total, 0
        for i, count in enumerate(self._counts if self._total else ()):
            passed += count
            if passed >= rank:
                return min((i + 1) * _BIN, self._largest) * 1e6
        return 0.0


class StepTiming:
    """Lateness of steps against deadlines one period apart, and the errors of their periods."""

    def __init__(self) -> None:
        """Create it without a step."""
        self._lateness, self._period_error = DurationHistogram(), DurationHistogram()
        self._previous: float | None = None

    def note(self, due: float, now: float) -> None:
        """Record the deadline of a step and the instant at which it is taken, s on one clock."""
        lateness = now - due
        self._lateness.add(lateness)
        if self._previous is not None:
            # deadlines are equally far apart
            self._period_error.add(abs(lateness - self._previous))
        self._previous = lateness

    def pause(self) -> None:
        """Drop the previous step: the next deadline is not one period later."""
        self._previous = None

    def metrics(self) -> dict[str, dict[str, float]]:
        """Return the entries of a run's summary, µs: lateness, and errors of the periods."""
        return {
            "lateness_us": self._lateness.metrics(),
            "period_error_us": self._period_error.metrics(),
        }
