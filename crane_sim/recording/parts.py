"""A recording in parts: a recorder died, another one went on in a file of its own; in the end they become one file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

from crane_sim.recording.leftover import hold
from crane_sim.recording.part_names import joining
from crane_sim.recording.repair import countdown, optimized

_MARGIN = 0.3  # s less than there are, so that the outcome can still be told


class Before(NamedTuple):
    """What earlier recorders of the same run have left."""

    after: int = 0  # the last step that is known to be on the disk
    recorded: int = 0  # steps that are
    parts: tuple[Path, ...] = ()  # their files, in order, most of them unfinished
    passes: int = 0  # resets of the plant that they have taken in


class Parts:
    """The earlier files of a run, kept from everyone who looks for leftovers."""

    def __init__(self, whole: Path, before: Before) -> None:
        """Take over what is there; `whole` is what all become in the end."""
        self._whole = whole
        self._parts = [part for part in before.parts if part.exists()]
        self._locks = [hold(part) for part in self._parts]

    def all(self, last: Path) -> list[Path]:
        """Return the earlier files and the `last` one."""
        return [*self._parts, last]

    def joined(self, last: Path, within: float) -> list[Path]:
        """Join the earlier files and the `last` one, which is complete; return the files that there are then.

        That is the whole or, where it could not be made because the disk is full or gone or it would take longer than
        `within` seconds, every part of it.
        """
        if not self._parts:
            return self.all(last)
        fresh = joining(self._whole)
        if not optimized([*self._parts, last], fresh, countdown(within - _MARGIN)):
            return self.all(last)
        fresh.replace(self._whole)
        for part in {*self._parts, last} - {self._whole}:
            part.unlink()
        for lock in self._locks:
            if lock is not None:
                os.close(lock)
        self._parts = []
        return [self._whole]
