"""Locks among processes that share compiled code."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from crane_sim.numerics.cache import FileLock

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
