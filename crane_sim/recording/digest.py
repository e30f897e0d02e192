"""Digests of what a recording holds: its writer adds them, its reader computes them anew.

A digest of rows has the steps of its block, so that a recorder that is killed leaves blocks that
can be verified, and of a damaged file it is known which steps are as they were written.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

DIGEST = "sha256"
"""Key of a digest beside the values that it is of."""


class Rows(NamedTuple):
    """Rows of a quantity, in the order of steps."""

    name: str
    step: NDArray[np.int64]  # (K,)
    time: NDArray[np.int64]  # (K,) ns
    values: NDArray[np.float64]  # (K, curves) or (K,)

    def between(self, first: int, last: int) -> Rows:
        """Return the rows of the steps from one to another."""
        part = slice(*np.searchsorted(self.step, (first, last + 1)))
        return Rows(self.name, self.step[part], self.time[part], self.values[part])

    def at(self, steps: NDArray[np.int64]) -> Rows:
        """Return the rows at some of the steps."""
        kept = np.isin(self.step, steps)
        return Rows(self.name, self.step[kept], self.time[kept], self.values[kept])


def digest_rows(quantities: Iterable[Rows]) -> str:
    """Return the digest of quantities' rows in any order; those without rows do not count."""
    sha = hashlib.sha256()
    for rows in sorted((each for each in quantities if len(each.step)), key=lambda each: each.name):
        sha.update(f"{rows.name} {len(rows.step)} {rows.values.size}\n".encode())
        for array, kind in ((rows.step, "<i8"), (rows.time, "<i8"), (rows.values, "<f8")):
            sha.update(np.ascontiguousarray(array, kind).data)
    return sha.hexdigest()


def describe_block(
    first: int, last: int, quantities: Iterable[Rows], changes: Iterable[str]
) -> str:
    """Return the digest of a block from the step `first` to the step `last` as text.

    `changes` are the digests of events and changes of states that were logged since the last one.
    """
    rows = digest_rows(quantities)
    return json.dumps({"first": first, "last": last, "rows": rows, "changes": [*changes]})


def verified_steps(curves: Iterable[Rows], blocks: Iterable[str]) -> NDArray[np.int64]:
    """Return, in order, the steps of blocks all of whose rows are as they were written.

    `blocks` have their digests.
    """
    listed, good = list(curves), [np.empty(0, np.int64)]
    for text in blocks:
        with suppress(ValueError, TypeError, LookupError, OverflowError):  # the digest is damaged
            digest = json.loads(text)
            first, last = np.array([digest["first"], digest["last"]], np.int64).tolist()
            block = [rows.between(first, last) for rows in listed]
            if first <= last and digest_rows(block) == digest["rows"]:
                good += [rows.step for rows in block]
    return np.unique(np.concatenate(good))


def digest_values(values: Mapping[str, Any]) -> str:
    """Return the digest of numbers and texts by name, but that of the digest itself."""
    named = {name: value for name, value in values.items() if name != DIGEST}
    return hashlib.sha256(json.dumps(named, sort_keys=True).encode()).hexdigest()


def with_digest(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with their digest."""
    return {**values, DIGEST: digest_values(values)}


def agrees(values: Mapping[str, Any], required: bool) -> bool:
    """Whether values agree with the digest among them.

    Without one, as of older versions, they agree if none is required.
    """
    return (
        values[DIGEST] == digest_values(values) if DIGEST in values else not (required and values)
    )


def digest_changes(name: str, changes: Iterable[tuple[int, str]]) -> list[str]:
    """Return digests, 64 bits each, of an entity's events or states: instants [ns] and texts."""
    lines = [f"{name} {time} {text}" for time, text in changes]
    return [hashlib.sha256(line.encode()).hexdigest()[:16] for line in lines]


def lacks_changes(changes: Mapping[str, Iterable[tuple[int, str]]], blocks: Iterable[str]) -> bool:
    """Return whether an event or a state that a block's digest has is not among `changes`.

    More may be there: a recorder that was killed has left some without a digest.
    """
    found = {digest for name, each in changes.items() for digest in digest_changes(name, each)}
    for text in blocks:
        with suppress(ValueError, TypeError, LookupError):  # the digest is damaged
            if not found.issuperset(json.loads(text).get("changes", ())):
                return True
    return False
