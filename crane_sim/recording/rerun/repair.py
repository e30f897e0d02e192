"""Makes recordings whole again that a killed recorder left as `.part` files.

A recording in parts: a recorder died, another one went on in a file of its own; in the end they become one file.
"""

from __future__ import annotations

import logging
import os
import subprocess
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import rerun_cli

from crane_sim.process_signals import set_parent_death_signal
from crane_sim.recording.files import acquire_lock, free_name, lock_file, temporary_name

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


LIMIT = 60.0  # s for making one recording of what there is


_LOOK = 0.05  # s between two looks at what time is left


def repair_leftovers(folder: Path) -> list[Path]:
    """Repair every `.rrd.part` file in a folder that no process is writing, and return the recovered recordings.

    A file from which nothing can be recovered stays as it is.
    """
    if not folder.is_dir():
        return []
    recovered = [repair(part) for part in sorted(folder.glob("*.rrd.part"))]
    return [path for path in recovered if path is not None]


def repair(part: Path, time_left: Callable[[], float] | None = None) -> Path | None:
    """Turn one leftover into `<name>.recovered.rrd`, or the first such name that is free.

    Returns None, and leaves the file alone, where a recorder is still writing it, nothing can be recovered, or there
    are no seconds `time_left`; without that, `LIMIT`.
    """
    with lock_file(part) as ours:
        if not ours:
            return None
        target = free_name(part)
        fresh = temporary_name(target)
        if not optimize_recordings([part], fresh, time_left or countdown(LIMIT)):
            return None
        fresh.replace(target)
        part.unlink()
    logging.getLogger(__name__).warning("%s was left by a killed run: recovered as %s", part, target)
    return target


def countdown(seconds: float) -> Callable[[], float]:
    """Return a function that returns how many of these seconds are left."""
    until = time.monotonic() + seconds
    return lambda: until - time.monotonic()


def optimize_recordings(parts: Sequence[Path], whole: Path, time_left: Callable[[], float]) -> bool:
    """Whether recordings, which may be unfinished, have become the `whole`; else there is none.

    It is given up as soon as `time_left` [s] is 0; that is called repeatedly, since a deadline may be set meanwhile.
    The program that does it ends with this process, however that ends.
    """
    if time_left() <= 0.0:
        return False
    command = [str(viewer_program()), "rrd", "optimize", *map(str, parts), "-o", str(whole)]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(
        command, stdin=quiet, stdout=quiet, stderr=quiet, preexec_fn=set_parent_death_signal()
    ) as program:
        while program.poll() is None and time_left() > 0.0:
            with suppress(subprocess.TimeoutExpired):
                program.wait(_LOOK)
        program.kill()  # if it still runs
    if not program.returncode and whole.is_file():
        return True
    whole.unlink(missing_ok=True)
    return False


def viewer_program() -> Path:
    """Return the Rerun program itself; its Python wrapper would leave it behind when killed."""
    return Path(rerun_cli.__file__).with_name("rerun")


_MARGIN = 0.3  # s less than there are, so that the outcome can still be reported


class Previous(NamedTuple):
    """Files of earlier recorders of the same run."""

    after: int = 0  # the last step that is known to be on the disk
    recorded: int = 0  # steps that are
    parts: tuple[Path, ...] = ()  # their files, in order, most of them unfinished
    passes: int = 0  # resets of the plant that they have taken in


class Parts:
    """The earlier files of a run, hidden from searches for leftovers."""

    def __init__(self, whole: Path, before: Previous) -> None:
        """Take over what is there; `whole` is what all become in the end."""
        self._whole = whole
        self._parts = [part for part in before.parts if part.exists()]
        self._locks = [acquire_lock(part) for part in self._parts]

    def all(self, last: Path) -> list[Path]:
        """Return the earlier files and the `last` one."""
        return [*self._parts, last]

    def join(self, last: Path, within: float) -> list[Path]:
        """Join the earlier files and the `last` one, which is complete; return the files that there are then.

        That is the whole or, where it could not be made because the disk is full or gone or it would take longer than
        `within` seconds, every part of it.
        """
        if not self._parts:
            return self.all(last)
        fresh = temporary_name(self._whole)
        if not optimize_recordings([*self._parts, last], fresh, countdown(within - _MARGIN)):
            return self.all(last)
        fresh.replace(self._whole)
        for part in {*self._parts, last} - {self._whole}:
            part.unlink()
        for lock in self._locks:
            if lock is not None:
                os.close(lock)
        self._parts = []
        return [self._whole]
