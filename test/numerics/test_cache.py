"""Compiled code on the disk: locks among processes that share it, and files that are damaged or cannot be written."""

import errno
import os
import random
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from shutil import rmtree

import numpy as np
import pytest
from crane_sim.numerics.checked_cache import CheckedCache
from numba import types
from numba.core import config
from numba.core.caching import FunctionCache, IndexDataCacheFile

from crane_sim.hardware.instruments import fill_standard_normals
from crane_sim.numerics.jit import entry_point, watch_compiling
from crane_sim.simulation.metrics import world_points
from crane_sim.tracing import cache, checked_cache
from crane_sim.tracing.cache import FileLock

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


def test_a_lock_whose_folder_is_removed_closes_no_other_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the file of a lock cannot be opened anew, its number is not closed a second time: it may be another's."""
    folder, open_lock, attempts = tmp_path / "cache", FileLock._open, list[FileLock]()

    def open_once(lock: FileLock) -> None:
        attempts.append(lock)
        if len(attempts) > 1:
            raise FileNotFoundError
        open_lock(lock)

    monkeypatch.setattr(FileLock, "_open", open_once)
    monkeypatch.setattr(cache.fcntl, "flock", lambda *_: rmtree(folder))
    lock = FileLock(folder / "lock", TIMEOUT)
    other = os.open(tmp_path, os.O_RDONLY)  # takes the number that is free
    lock.release()
    os.close(other)  # raises where it is closed already
    assert len(attempts) == 2


def test_sources_that_are_no_files_are_left_out(tmp_path: Path) -> None:
    """A link to nowhere, as an editor leaves beside a file that is being changed, is no source."""
    (tmp_path / "a.py").write_text("A = 1\n")
    before = cache.digest((tmp_path,))
    (tmp_path / ".#a.py").symlink_to("user@host.123")
    assert cache.digest((tmp_path,)) == before and cache.SourceState((tmp_path,)).is_current()


def test_a_failed_compilation_leaves_no_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process whose compilation or saving raised does not wait for its own lock at the next attempt, nor keep it."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(FunctionCache, "load_overload", lambda *_: None)
    monkeypatch.setattr(checked_cache, "_LOCK_TIMEOUT", 0.0)
    lock, signature = tmp_path / "lock", (types.float64,)
    compiled = CheckedCache(world_points.py_func)
    monkeypatch.setattr(compiled, "_lock_file", lambda _: lock)
    for _ in range(2):  # the first compilation raises: nothing is saved
        assert compiled.load_overload(signature, None) is None and lock.exists()
    with pytest.raises(AttributeError):
        compiled.save_overload(signature, None)
    assert not lock.exists(), "a lock that was not acquired, or not released"


@pytest.mark.parametrize("kind", ["none", "own", "link", "another user's"])
def test_compiled_code_is_only_taken_from_an_own_folder(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Below the folder of temporary files, one of the user's name that another user made, or a link, is not taken."""
    usual = tmp_path / f"crane_sim_{os.getuid()}"
    if kind == "link":
        (tmp_path / "elsewhere").mkdir()
        usual.symlink_to(tmp_path / "elsewhere")
    elif kind != "none":
        usual.mkdir(mode=0o777)
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("CRANE_SIM_CACHE", "/dev/null/nowhere")
    if kind == "another user's":
        monkeypatch.setattr(cache.os, "getuid", lambda: os.geteuid() + 1)
        (tmp_path / f"crane_sim_{os.getuid()}").mkdir()
    cache._temporary_folder.cache_clear()
    try:
        root = cache.cache_folder().parent
    finally:
        cache._temporary_folder.cache_clear()
    assert (root == usual) is (kind in ("none", "own"))
    assert root.stat().st_mode & 0o077 == 0 and root.parent == tmp_path


def draw_once() -> tuple[bytes, bool]:
    """Return what a function draws that is loaded from the cache, or compiled, and whether it was compiled."""
    function, compilations, drawn = entry_point(fill_standard_normals.py_func), list[None](), np.zeros(4)
    with watch_compiling(lambda: compilations.append(None)):
        function(1, 2, 3, drawn)
    return drawn.tobytes(), bool(compilations)


def flip_bit(content: bytes) -> bytes:
    """Return bytes with one bit flipped, at a place that follows from them."""
    place = random.Random(content).randrange(8 * len(content))
    flipped = bytearray(content)
    flipped[place // 8] ^= 1 << place % 8
    return bytes(flipped)


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[: len(content) // 2],
        lambda content: content[:-1],
        lambda content: bytes(len(content)),
        lambda content: content[1024:] + content[:1024],
        flip_bit,
    ],
    ids=["empty", "half", "cut", "zeros", "swapped", "flipped"],
)
def test_a_damaged_file_costs_a_compilation(
    damage: Callable[[bytes], bytes], suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The function is compiled once more, returns the same, and is whole on the disk from then on."""
    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    drawn, compiled = draw_once()
    assert compiled and draw_once() == (drawn, False)
    (file,) = tmp_path.rglob(f"*.{suffix}")
    file.write_bytes(damage(file.read_bytes()))
    assert draw_once() == (drawn, True) and draw_once() == (drawn, False)


def test_a_cache_on_a_full_disk_costs_compilations(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a file of the cache cannot be written, each process compiles; its lock is released."""

    def fail(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    monkeypatch.setattr(IndexDataCacheFile, "_open_for_write", fail)
    assert draw_once() == draw_once() and draw_once()[1]
    monkeypatch.setattr("tempfile.TemporaryFile", fail)  # no folder can be written: there is no cache at all
    assert draw_once()[1] and not [*tmp_path.rglob("*.lock"), *tmp_path.rglob("*.nb?")]
