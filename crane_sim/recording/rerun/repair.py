"""Repair of `.part` recordings that a killed recorder left, and joining of a recording's parts.

A recording has parts where a recorder died and its successor wrote a file of its own; in the end
they become one file.
"""

from __future__ import annotations

import logging
import os
import subprocess
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import rerun_cli

from crane_sim.process_signals import set_parent_death_signal
from crane_sim.recording.files import acquire_lock, lock_file, recovered_name, temporary_name

REPAIR_TIMEOUT = 60.0  # s for the repair of one recording
COMPACTED_BYTES = 500_000_000  # of a recording at most; its compaction needs twice as much memory
_POLL = 0.05  # s between two checks of the time left
_MARGIN = 0.3  # s before the deadline, so that the outcome can still be reported


def repair_leftovers(folder: Path) -> list[Path]:
    """Repair a folder's `.rrd.part` files that no process writes; return the recovered ones.

    A file from which nothing can be recovered stays as it is.
    """
    if not folder.is_dir():
        return []
    recovered = [repair(part) for part in sorted(folder.glob("*.rrd.part"))]
    return [path for path in recovered if path is not None]


def repair(part: Path, time_left: Callable[[], float] | None = None) -> Path | None:
    """Turn one leftover into `<name>.recovered.rrd`, or the first such name that is free.

    Returns None, and leaves the file alone, where a recorder is still writing it, nothing can be
    recovered, or there are no seconds `time_left`; without that argument there are
    `REPAIR_TIMEOUT`.
    """
    with lock_file(part) as acquired:
        if not acquired:
            return None
        target = recovered_name(part)
        temporary = temporary_name(target)
        if not join_recordings([part], temporary, time_left or countdown(REPAIR_TIMEOUT)):
            return None
        temporary.replace(target)
        part.unlink()
    logging.getLogger(__name__).warning(
        "%s was left by a killed run: recovered as %s", part, target
    )
    return target


def countdown(seconds: float) -> Callable[[], float]:
    """Return a function that returns the remaining seconds."""
    until = time.monotonic() + seconds
    return lambda: until - time.monotonic()


def join_recordings(
    parts: Sequence[Path], complete_file: Path, time_left: Callable[[], float]
) -> bool:
    """Join recordings, also unfinished ones, into `complete_file`; return whether it exists.

    Joining is given up as soon as `time_left` [s] is 0, which is called repeatedly, since a
    deadline may be set meanwhile. The Rerun process that joins them ends with this process in any
    case.
    """
    if time_left() <= 0.0:
        return False
    command = [
        rerun_executable(),
        "rrd",
        "optimize",
        "--profile",
        "live",
        "-o",
        complete_file,
        *parts,
    ]
    none = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    with subprocess.Popen(command, preexec_fn=set_parent_death_signal(), **none) as program:
        while program.poll() is None and time_left() > 0.0:
            with suppress(subprocess.TimeoutExpired):
                program.wait(_POLL)
        program.kill()  # if it still runs
    if not program.returncode and complete_file.is_file():
        return True
    complete_file.unlink(missing_ok=True)
    return False


def compact(recording: Path, time_limit: float) -> None:
    """Join a complete recording's chunks into large indexed ones.

    A viewer takes its time for each chunk.

    The file stays as it is where it is larger than `COMPACTED_BYTES`, or `time_limit` seconds are
    not enough.
    """
    temporary = temporary_name(recording)
    if recording.stat().st_size > COMPACTED_BYTES:
        return
    if join_recordings([recording], temporary, countdown(time_limit - _MARGIN)):
        temporary.replace(recording)


def rerun_executable() -> Path:
    """Return the Rerun executable's own path; killing its Python wrapper would not end it."""
    return Path(rerun_cli.__file__).with_name("rerun")


class EarlierFiles(NamedTuple):
    """Files of earlier recorders of the same run."""

    last_step: int = 0  # that is known to be on the disk
    recorded: int = 0  # number of steps on the disk
    parts: tuple[Path, ...] = ()  # their files, in order, most of them unfinished
    resets: int = 0  # resets of the plant that they contain
    lost_commands: int = 0  # steps on the disk that lack their command


class Parts:
    """The earlier files of a run, hidden from searches for leftovers."""

    def __init__(self, complete_file: Path, previous: EarlierFiles) -> None:
        """Lock the existing files; all are joined into `complete_file` in the end."""
        self._complete_file = complete_file
        self._parts = [part for part in previous.parts if part.exists()]
        self._locks = [acquire_lock(part) for part in self._parts]

    def all(self, last: Path) -> list[Path]:
        """Return the earlier files and the `last` one."""
        return [*self._parts, last]

    def join(self, last: Path, time_limit: float) -> list[Path]:
        """Join the earlier files and the `last` one, which is complete; return the resulting files.

        That is the complete file or, after an error of the disk or beyond `time_limit` seconds,
        every part of it.
        """
        if not self._parts:
            return self.all(last)
        temporary = temporary_name(self._complete_file)
        if not join_recordings([*self._parts, last], temporary, countdown(time_limit - _MARGIN)):
            return self.all(last)
        temporary.replace(self._complete_file)
        for part in {*self._parts, last} - {self._complete_file}:
            part.unlink()
        for lock in self._locks:
            if lock is not None:
                os.close(lock)
        self._parts = []
        return [self._complete_file]
