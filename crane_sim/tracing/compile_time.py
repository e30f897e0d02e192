"""How long this process has compiled, which is no part of the wall time of a run."""

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager


class CompileTimer:
    """A timer of this process's compilations; of nested blocks the outermost one counts."""

    def __init__(self) -> None:
        self._seconds, self._depth, self._started = 0.0, 0, 0.0
        self._watchers: list[Callable[[], object]] = []

    @property
    def seconds(self) -> float:
        """Seconds up to now."""
        return self._seconds + (time.perf_counter() - self._started if self._depth else 0.0)

    def __enter__(self) -> None:
        """Begin to count."""
        if not self._depth:
            self._started = time.perf_counter()
        self._depth += 1
        for watcher in self._watchers:
            watcher()

    @contextmanager
    def watch(self, callback: Callable[[], object]) -> Iterator[None]:
        """Call `callback` whenever a compilation begins within the block."""
        self._watchers.append(callback)
        try:
            yield
        finally:
            self._watchers.remove(callback)

    def __exit__(self, *_: object) -> None:
        """End counting."""
        self._depth -= 1
        if not self._depth:
            self._seconds += time.perf_counter() - self._started


COMPILE_TIMER = CompileTimer()


def compile_time() -> float:
    """Return how long this process has compiled [s]."""
    return COMPILE_TIMER.seconds


def watch_compiling(callback: Callable[[], object]) -> AbstractContextManager[None]:
    """Call `callback` for each function compiled within the block, not for one from the cache."""
    return COMPILE_TIMER.watch(callback)
