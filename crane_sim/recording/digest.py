"""Digests of what a recording holds: those that its writer adds, and its reader computes anew.

They do not depend on how rows were divided among blocks, files and chunks, which are joined and compacted later.
"""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

DIGEST = "sha256"
"""Key of the digest of values beside them."""
_WRAP = 1 << 64


class Rows(NamedTuple):
    """Rows of a quantity, in the order of steps."""

    name: str
    step: NDArray[np.int64]  # (K,)
    time: NDArray[np.int64]  # (K,) ns
    values: NDArray[np.float64]  # (K, curves) or (K,)


def digest_rows(quantities: Iterable[Rows]) -> str:
    """Return the digest of the rows of some quantities in whichever order; those without rows do not count."""
    sha = hashlib.sha256()
    for rows in sorted((each for each in quantities if len(each.step)), key=lambda each: each.name):
        sha.update(f"{rows.name} {len(rows.step)} {rows.values.size}\n".encode())
        for array, kind in ((rows.step, "<i8"), (rows.time, "<i8"), (rows.values, "<f8")):
            sha.update(np.ascontiguousarray(array, kind).data)
    return sha.hexdigest()


def digest_values(values: Mapping[str, Any]) -> str:
    """Return the digest of numbers and texts by name, but that of the digest itself."""
    named = {name: value for name, value in values.items() if name != DIGEST}
    return hashlib.sha256(json.dumps(named, sort_keys=True).encode()).hexdigest()


def with_digest(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with their digest."""
    return {**values, DIGEST: digest_values(values)}


def agrees(values: Mapping[str, Any], required: bool) -> bool:
    """Whether values are those of the digest among them; without one, as of older versions, where none is required."""
    return values[DIGEST] == digest_values(values) if DIGEST in values else not (required and values)


def digest_changes(name: str, changes: Iterable[tuple[int, str]]) -> int:
    """Return the sum of 64-bit digests of what happened: a name, an instant [ns] and a text each, in any order."""
    return sum(_digest_text(f"{name} {time} {text}") for time, text in changes) % _WRAP


def add_digests(digests: Iterable[int]) -> int:
    """Return the sum of sums that `digest_changes` returns."""
    return sum(digests) % _WRAP


def _digest_text(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little")
