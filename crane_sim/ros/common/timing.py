"""How punctually the steps of a real-time run were taken; no rclpy here."""

from array import array

_BIN = 1e-6  # s, what quantiles are rounded up to
_BINS = 100_000  # 0.1 s; what is longer counts as this long, but for the largest value
_QUANTILES = {"p50": 0.50, "p99": 0.99}


class Errors:
    """Counts durations in bins: memory does not grow with the run."""

    def __init__(self) -> None:
        """Begin with none."""
        self._counts, self._total, self._largest = array("Q", bytes(8 * _BINS)), 0, 0.0

    def add(self, seconds: float) -> None:
        """Count a duration, s; a negative one as none."""
        self._counts[min(max(int(seconds / _BIN), 0), _BINS - 1)] += 1
        self._total += 1
        self._largest = max(self._largest, seconds)

    def figures(self) -> dict[str, float]:
        """Return median, 99 % quantile and largest duration, µs: zeros while there is none."""
        return {name: self._quantile(part) for name, part in _QUANTILES.items()} | {"max": self._largest * 1e6}

    def _quantile(self, part: float) -> float:
        wanted, passed = part * self._total, 0
        for i, count in enumerate(self._counts if self._total else ()):
            passed += count
            if passed >= wanted:
                return min((i + 1) * _BIN, self._largest) * 1e6
        return 0.0


class StepTiming:
    """Compares the instants at which steps were taken with their deadlines, one period apart."""

    def __init__(self) -> None:
        """Begin with no step."""
        self._late, self._period = Errors(), Errors()
        self._before: float | None = None

    def note(self, due: float, now: float) -> None:
        """Take the deadline of a step and the instant at which it is taken, s on one clock."""
        late = now - due
        self._late.add(late)
        if self._before is not None:
            self._period.add(abs(late - self._before))  # deadlines are equally far apart
        self._before = late

    def pause(self) -> None:
        """Forget the step before: the next deadline is not one period later."""
        self._before = None

    def figures(self) -> dict[str, dict[str, float]]:
        """Return what a run's summary says, µs: lateness, and how far periods are from their nominal length."""
        return {"lateness_us": self._late.figures(), "period_error_us": self._period.figures()}
