"""How long this process has compiled, which is no part of the wall time of a run."""

import time


class CompileTimer:
    """A timer of this process's compilations, and of its waits for other processes that compile.

    Its blocks may be nested: the outermost one counts.
    """

    def __init__(self) -> None:
        self._seconds, self._depth, self._started = 0.0, 0, 0.0

    @property
    def seconds(self) -> float:
        """Seconds up to now."""
        return self._seconds + (time.perf_counter() - self._started if self._depth else 0.0)

    def __enter__(self) -> None:
        """Begin to count."""
        if not self._depth:
            self._started = time.perf_counter()
        self._depth += 1

    def __exit__(self, *_: object) -> None:
        """End counting."""
        self._depth -= 1
        if not self._depth:
            self._seconds += time.perf_counter() - self._started


COMPILE_TIMER = CompileTimer()


def compile_time() -> float:
    """Return how long this process has compiled, or waited for another one that compiles the same function [s]."""
    return COMPILE_TIMER.seconds
