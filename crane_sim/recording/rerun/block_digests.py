"""Digests of a recording's blocks: logged behind each by its writer, compared with the rows by its reader.

A digest has the steps of its block, so that a recorder that is killed leaves blocks that can be verified, and of a
damaged file it is known which steps are as they were written.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import rerun as rr

from crane_sim.recording.digest import Rows, add_digests, digest_changes, digest_rows
from crane_sim.recording.rerun.timelines import times

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Array, Layout

ENTITY = "digests"
EVENTS, STATES = "log/events", "states/"
"""Entity of events, and beginning of those of timelines of states."""
_CURVES, _UNVERIFIED = ("plots/", "frames/"), "plots/rtf"  # speeds are logged beside the blocks


class BlockDigest(NamedTuple):
    """What a writer says of a block, or of changes that it has logged beside blocks: those have no steps."""

    first: int  # step
    last: int
    rows: str  # digest of the rows of all its curves
    changes: int  # sum of the digests of events and changes of states


def is_verified(entity: str) -> bool:
    """Whether the curves of an entity are read back, and have digests: what is only shown has none."""
    return entity.startswith(_CURVES) and entity != _UNVERIFIED


class DigestWriter:
    """What has been logged since the last digest."""

    def __init__(self, rec: rr.RecordingStream, layout: Layout) -> None:
        """Begin with nothing."""
        self._rec, self._layout = rec, layout
        self._rows: list[Rows] = []
        self._changes = 0

    def add_rows(self, entity: str, step: NDArray[np.int64], values: Array) -> None:
        """Add rows of an entity."""
        if is_verified(entity):
            self._rows.append(Rows(entity, step, (step - 1) * self._layout.period_ns, values))

    def add_changes(self, entity: str, instants: NDArray[np.int64], texts: Sequence[str]) -> None:
        """Add events, or changes of a timeline, at instants [ns]."""
        changes = digest_changes(entity, zip(instants.tolist(), texts, strict=True))
        self._changes = add_digests((self._changes, changes))

    def log(self, first: int = 1, last: int = 0) -> None:
        """Log the digest of a block from the step `first` to the step `last`; without steps that of changes alone."""
        digest = BlockDigest(first, last, digest_rows(self._rows), self._changes)
        text = rr.TextDocument.columns(text=[json.dumps(digest._asdict())])
        self._rec.send_columns(ENTITY, times(self._layout, np.array([max(last, 1)])), text)
        self._rows, self._changes = [], 0


def parse_digests(texts: Iterable[str]) -> list[BlockDigest]:
    """Return the digests in a file, without those that are damaged."""
    found = []
    for text in texts:
        try:
            found.append(BlockDigest(**json.loads(text)))
        except (ValueError, TypeError):
            continue
    return found


def verified_steps(curves: Iterable[Rows], digests: Iterable[BlockDigest]) -> NDArray[np.int64]:
    """Return the steps of blocks all of whose rows are as they were written, in order."""
    listed, good = list(curves), [np.empty(0, np.int64)]
    for digest in digests:
        block = [_between(rows, digest.first, digest.last) for rows in listed]
        if digest.first <= digest.last and digest_rows(block) == digest.rows:
            good += [rows.step for rows in block]
    return np.unique(np.concatenate(good))


def _between(rows: Rows, first: int, last: int) -> Rows:
    part = slice(*np.searchsorted(rows.step, (first, last + 1)))
    return Rows(rows.name, rows.step[part], rows.time[part], rows.values[part])
