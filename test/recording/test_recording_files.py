"""Names of a recording's files: its parts by several recorders, and files from before resets."""

import fcntl
import time
from pathlib import Path

import pytest

from crane_sim.recording.files import (
    acquire_lock,
    before_reset,
    existing_parts,
    files_before_resets,
)
from crane_sim.recording.rerun.repair import repair


def test_parts_are_listed_under_their_present_names(tmp_path: Path) -> None:
    """Finished or not, a part of this run is listed, in order; one of an earlier run is not."""
    names = ("run.rrd.part", "run.rrd", "run.part2.rrd", "run.part3.rrd.part", "run.part4.rrd")
    for name in names:
        (tmp_path / name).touch()
    path = str(tmp_path / "run.rrd")
    assert [file.name for file in existing_parts(path, 3, since=0.0)] == list(names[:4])
    assert existing_parts(path, 3, since=time.time() + 60.0) == []
    assert before_reset(tmp_path / "run.rrd", 1).name == "run.before_reset_1.rrd"
    (tmp_path / "run.before_reset_1.rrd").touch()
    assert before_reset(tmp_path / "run.rrd", 1).name == "run.before_reset_2.rrd"


def test_files_from_before_resets_are_listed(tmp_path: Path) -> None:
    """Files from before this run's resets, its parts' too, are listed, none of others."""
    expected = ["run.before_reset_1.rrd", "run.part2.before_reset_2.rrd"]
    for name in (*expected, "run.before_reset_1.mcap", "rerun.before_reset_1.rrd", "run.rrd"):
        (tmp_path / name).touch()
    path = str(tmp_path / "run.rrd")
    assert sorted(file.name for file in files_before_resets(path, since=0.0)) == expected
    assert files_before_resets(path, since=time.time() + 60.0) == []


def test_a_file_that_another_process_removes_is_not_locked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A leftover repaired by another recorder meanwhile, before or after opening, is not locked."""
    part = tmp_path / "run.rrd.part"
    assert acquire_lock(part) is None and repair(part) is None
    part.touch()
    lock = fcntl.flock

    def lock_removed(descriptor: int, how: int) -> None:
        part.unlink()
        lock(descriptor, how)

    monkeypatch.setattr("crane_sim.recording.files.fcntl.flock", lock_removed)
    assert acquire_lock(part) is None
