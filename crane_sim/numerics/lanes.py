"""Many cranes side by side: trees of numbers as columns, states as columns of one buffer.

A loop over the lanes of a buffer, a `simd_range`, becomes vector instructions: one crane in each
lane, with the very arithmetic of one crane alone.
"""

from typing import Any

import numpy as np

from crane_sim.numerics.states import leaves
from crane_sim.tracing.trees import rebuilt

LANES = 16
"""Cranes that move in step: two of the widest vectors, and few enough to stay in the first
cache."""


def take_entry(columns: Any, i: int) -> Any:
    """Return crane i: entry i of every array of a tree of columns, in the same NamedTuples."""
    if isinstance(columns, tuple):
        return rebuilt(columns, [take_entry(part, i) for part in columns])
    return None if columns is None else _plain(columns[i])


def _plain(entry: Any) -> Any:
    """Return a number as Python's: NumPy's are slower there, and warn."""
    if isinstance(entry, float):
        return float(entry)
    return int(entry) if isinstance(entry, np.integer) else entry


def put_entry(columns: Any, i: int, tree: Any) -> None:
    """Write the numbers of crane i into entry i of every array of a tree of columns."""
    if isinstance(columns, tuple):
        for part, entry in zip(columns, tree, strict=True):
            put_entry(part, i, entry)
    elif columns is not None:
        columns[i] = tree


def lane(like: Any, buffer: Any, j: int) -> Any:
    """Return lane j of a buffer (floats, LANES) as a state of the same type as `like`."""
    return _read_lane(like, buffer, j, 0)[0]


def _read_lane(like: Any, buffer: Any, j: int, row: int) -> tuple[Any, int]:
    """Return (the state like this one from a row of the buffer on, the row behind it)."""
    if not isinstance(like, tuple):
        return buffer[row, j], row + 1
    parts = ()
    for part in like:
        value, row = _read_lane(part, buffer, j, row)
        parts = (*parts, value)
    return rebuilt(like, parts), row


def put_lane(buffer: Any, j: int, x: Any) -> None:
    """Write the floats of the state x into lane j of a buffer (floats, LANES)."""
    for row, value in enumerate(leaves(x)):
        buffer[row, j] = value
