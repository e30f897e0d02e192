"""Random Fourier features of a Gaussian kernel (Rahimi & Recht; Smith & Egeland, section 2).

The features of x are cos(w·x) / √d, sin(w·x) / √d for d frequencies w, drawn once from N(0, 1 / width²): their scalar
product at two points approximates exp(-|x - z|² / (2 width²)), and their own is 1.
"""

from typing import Any, Literal, NamedTuple

import numpy as np

from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine

FeatureArguments = Literal["y", "state", "error"]
COLUMNS: dict[FeatureArguments, tuple[int, ...]] = {"y": (0, 1), "state": (0, 1, 2, 3), "error": (4, 5, 6, 7)}
"""Possible arguments of the features, as entries of (y, y', e, e', t), e the error of y."""
TIME = 8


class Features(NamedTuple):
    """Random frequencies, and the entries of (y, y', e, e', t) that they multiply."""

    frequencies: Any  # (d, n) rad per unit of the entry
    columns: Any  # (n,) int64, entries of (y, y', e, e', t)


def draw_frequencies(number: int, width: float, of: FeatureArguments, time: bool, seed: int) -> Features:
    """Return `number` frequencies for a kernel of this width, whose arguments are those of `of`, and t if `time`."""
    columns = (*COLUMNS[of], *((TIME,) if time else ()))
    frequencies = np.random.default_rng(seed).normal(0.0, 1.0 / width, (number, len(columns)))
    return Features(frequencies, np.array(columns, dtype=np.int64))


@routine
def write_features(features, entries, out):
    """Write the features at `entries` (9,) into out (2 d,): cosine and sine in turn, of unit norm together."""
    scale = 1.0 / np.sqrt(len(features.frequencies))
    for j in range(len(features.frequencies)):
        angle = 0.0
        for k in range(len(features.columns)):
            angle += features.frequencies[j, k] * entries[features.columns[k]]
        s, c = sincos(angle)
        out[2 * j] = scale * c
        out[2 * j + 1] = scale * s
