"""A recording in parts: a recorder died, another one went on in a file of its own; in the end they become one file."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import NamedTuple

from crane_sim.recording.leftover import hold
from crane_sim.recording.repair import viewer_program


class Before(NamedTuple):
    """What earlier recorders of the same run have left."""

    after: int = 0  # the last step that is known to be on the disk
    recorded: int = 0  # steps that are
    parts: tuple[Path, ...] = ()  # their unfinished files, in order


class Parts:
    """The earlier files of a run, kept from everyone who looks for leftovers."""

    def __init__(self, whole: Path, before: Before) -> None:
        """Take over what is there; `whole` is what all become in the end."""
        self._whole = whole
        self._parts = [part for part in before.parts if part.exists()]
        self._locks = [hold(part) for part in self._parts]

    def joined(self, last: Path) -> list[Path]:
        """Join the earlier files and the `last` one, which is complete; return the files that there are then.

        That is the whole or, where it could not be made because the disk is full or gone, every part of it.
        """
        if not self._parts:
            return [last]
        fresh = self._whole.with_name(self._whole.name + ".tmp")
        command = [str(viewer_program()), "rrd", "optimize", *map(str, self._parts), str(last), "-o", str(fresh)]
        done = subprocess.run(command, capture_output=True, check=False)
        if done.returncode or not fresh.is_file():
            fresh.unlink(missing_ok=True)
            return [*self._parts, last]
        fresh.replace(self._whole)
        for part in (*self._parts, last):
            part.unlink()
        for lock in self._locks:
            if lock is not None:
                os.close(lock)
        self._parts = []
        return [self._whole]
