"""Rows of a recorded motion without their noise."""

from math import pi

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
# in a period of the cut-off: beyond, the equations lose more digits than a record has
MAX_ROWS = 5000


def smooth(times: Array, values: Array, cut_off: float) -> Array:
    """Return rows (n, m) at times (n,) [s], even or not, after a low pass that shifts no phase.

    Of a sinusoid of frequency f, 1 / (1 + (f / cut_off)⁴) is left: half of it at the cut-off [Hz],
    -6 dB. The rows are those of the smoothing spline s, which minimises, over their time, ∫ (row -
    s)² dt + (2 pi cut_off)⁻⁴ ∫ s''² dt (Reinsch, Numer. Math. 10, 1967). At the ends s'' = 0: a
    straight line stays as it is.

    Raises:
        ValueError: the times are too uneven for the equations to be solved in doubles.
    """
    # here: few scenes have a file, and it takes long to import
    from scipy.linalg import solveh_banded

    spans, stiffness = np.diff(times), (2.0 * pi * cut_off) ** -4
    # s, the time that a row stands for
    weights = 0.5 * (np.append(spans, 0.0) + np.append(0.0, spans))
    # columns of Q
    slopes = np.stack([1.0 / spans[:-1], -1.0 / spans[:-1] - 1.0 / spans[1:], 1.0 / spans[1:]])
    try:
        curvatures = solveh_banded(
            _matrix(spans, weights, slopes, stiffness), np.diff(np.diff(values.T) / spans).T
        )
    except np.linalg.LinAlgError:
        raise ValueError("its rows are too uneven for a low pass of this cut-off") from None
    moved = np.zeros_like(values)
    for k, slope in enumerate(slopes):
        moved[k : len(times) - 2 + k] += slope[:, None] * curvatures
    return values - stiffness * moved / weights[:, None]


def _matrix(spans: Array, weights: Array, slopes: Array, stiffness: float) -> Array:
    """Return R + stiffness Qᵀ W⁻¹ Q as an upper band (3, n - 2): R of Reinsch, W of weights."""
    scaled = slopes / np.sqrt(np.stack([weights[:-2], weights[1:-1], weights[2:]]))
    bands = np.zeros((3, len(spans) - 1))
    bands[2] = (spans[:-1] + spans[1:]) / 3.0 + stiffness * np.sum(scaled**2, axis=0)
    bands[1, 1:] = spans[1:-1] / 6.0
    bands[1, 1:] += stiffness * (scaled[1, :-1] * scaled[0, 1:] + scaled[2, :-1] * scaled[1, 1:])
    bands[0, 2:] = stiffness * scaled[2, :-2] * scaled[0, 2:]
    return bands
