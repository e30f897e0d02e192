"""Random Fourier features of a Gaussian kernel (Rahimi & Recht; Smith & Egeland, section 2).

The features of x are cos(w·x) / √d, sin(w·x) / √d for d frequencies w, drawn once from N(0, 1 /
width²). The scalar product of the features at x and z approximates exp(-|x - z|² / (2 width²)), and
each vector of features has unit norm.
"""

from typing import Any, Literal, NamedTuple

import numpy as np

from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine

FeatureArguments = Literal["y", "state", "error"]
COLUMNS: dict[FeatureArguments, tuple[int, ...]] = {
    "y": (0, 1),
    "state": (0, 1, 2, 3),
    "error": (4, 5, 6, 7),
}
"""Possible arguments of the features, as indices into (y, y', e, e', t), where e is the error of
y."""
TIME = 8


class Features(NamedTuple):
    """Random frequencies, and the inputs among (y, y', e, e', t) that they multiply."""

    frequencies: Any  # (d, n) rad per unit of the input
    columns: Any  # (n,) int64, indices into (y, y', e, e', t)


def draw_frequencies(
    number: int, width: float, arguments: FeatureArguments, time: bool, seed: int
) -> Features:
    """Return `number` frequencies for a Gaussian kernel of this width in `arguments`.

    They are for t too if `time` is set.
    """
    columns = (*COLUMNS[arguments], *((TIME,) if time else ()))
    frequencies = np.random.default_rng(seed).normal(0.0, 1.0 / width, (number, len(columns)))
    return Features(frequencies, np.array(columns, dtype=np.int64))


@routine
def write_features(features, inputs, out):
    """Write the features at `inputs` (9,) = (y, y', e, e', t) into out (2 d,).

    They are cosine and sine in turn, of unit norm.
    """
    scale = 1.0 / np.sqrt(len(features.frequencies))
    for j in range(len(features.frequencies)):
        angle = 0.0
        for k in range(len(features.columns)):
            angle += features.frequencies[j, k] * inputs[features.columns[k]]
        s, c = sincos(angle)
        out[2 * j] = scale * c
        out[2 * j + 1] = scale * s
