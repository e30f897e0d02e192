"""Locks among processes that share compiled code."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from numba import types
from numba.core.caching import FunctionCache

from crane_sim.numerics import checked_cache
from crane_sim.numerics.cache import FileLock
from crane_sim.numerics.checked_cache import CheckedCache
from crane_sim.simulation.metrics import world_points

TIMEOUT = 60.0  # s; the sixty holders take less than one together


def test_one_at_a_time_holds_a_lock(tmp_path: Path) -> None:
    """Three that count in a file, which each reads and writes under the lock, lose no count, though it is removed."""
    lock, count = tmp_path / "lock", tmp_path / "count"
    count.write_text("0")

    def add(_: int) -> None:
        held = FileLock(lock, TIMEOUT)
        count.write_text(str(int(count.read_text()) + 1))
        held.release()

    with ThreadPoolExecutor(3) as pool:
        list(pool.map(add, range(60)))
    assert count.read_text() == "60" and not lock.exists()


def test_a_failed_compilation_leaves_no_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process whose compilation or saving raised does not wait for its own lock at the next attempt, nor keep it."""
    monkeypatch.setattr(FunctionCache, "load_overload", lambda *_: None)
    monkeypatch.setattr(checked_cache, "_LOCK_TIMEOUT", 0.0)
    lock, signature = tmp_path / "lock", (types.float64,)
    cache = CheckedCache(world_points.py_func)
    monkeypatch.setattr(cache, "_lock_file", lambda _: lock)
    for _ in range(2):  # the first compilation raises: nothing is saved
        assert cache.load_overload(signature, None) is None and lock.exists()
    with pytest.raises(AttributeError):
        cache.save_overload(signature, None)
    assert not lock.exists(), "a lock that was not acquired, or not released"
