"""Decimation: fewer rows with the same curve shape, and numbers as accurate as drawing needs."""

from __future__ import annotations

from base64 import b64encode
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.recording.layout import Array

MAX_LEVEL = 2**31 - 1  # of a quantised number; the least is its negative
MIN_SPAN = 1e-12  # m or rad: a smaller span is rounding


def rows_with_peaks(values: Array, count: int) -> NDArray[np.int64]:
    """Return rows (M,), M <= 3/2 `count` + 2, that keep a curve's ends, peaks and gaps.

    Of each stretch of the curve these are the lowest and the highest value, and the first gap.

    Args:
        values: (K,); those that are not finite are no peaks; of each stretch that has any, the
            first is kept.
        count: the number of rows to which it is reduced, even.
    """
    total = len(values)
    if total <= count:
        return np.arange(total)
    edges = np.linspace(0, total, count // 2 + 1).astype(np.int64)
    rows = [0, total - 1]
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        part = values[first:last]
        finite = np.isfinite(part)
        low, high = np.where(finite, part, np.inf), np.where(finite, part, -np.inf)
        rows += [first + int(low.argmin()), first + int(high.argmax())]
        if not finite.all():
            rows.append(first + int(finite.argmin()))
    return np.unique(rows)


def encode_floats(values: Array) -> str:
    """Return numbers (M,) as base64 of little-endian float32: enough for a curve on a screen."""
    return b64encode(values.astype("<f4").tobytes()).decode()


def encode_columns(columns: Array) -> dict[str, Any]:
    """Return a matrix (F, C) as base64 of little-endian int32, column after column.

    A number is `offset + scale * integer`: it is off by less than its column's range / 2^32.
    Constant columns have scale 0 and no integers.
    """
    low, high = columns.min(axis=0), columns.max(axis=0)
    span = np.where(high - low > MIN_SPAN, high - low, 0.0)
    offset, scale = low + 0.5 * span, 0.5 * span / MAX_LEVEL
    varying = scale > 0.0
    levels = np.rint((columns[:, varying] - offset[varying]) / scale[varying])
    integers = levels.clip(-MAX_LEVEL, MAX_LEVEL).astype("<i4")
    scales = [[float(o), float(s)] for o, s in zip(offset, scale, strict=True)]
    return {
        "rows": len(columns),
        "scales": scales,
        "data": b64encode(np.asfortranarray(integers).tobytes("F")).decode(),
    }
