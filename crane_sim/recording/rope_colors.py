"""Colours of ropes by tension: grey as at the start, red at twice as much, orange where slack."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.recording.layout import Array

MIN_TENSION = 1e-6  # N: a smaller one is a rounding error of 0
UNLOADED_COLOR, USUAL_COLOR, DOUBLE_COLOR, SLACK_COLOR = (
    (150, 190, 235),
    (214, 219, 226),
    (235, 60, 50),
    (255, 150, 40),
)
"""Colours (red, green, blue) of next to no tension, of that of the start, of twice as much and
more, and of none."""


def usual_tensions(tensions: Array) -> Array:
    """Return the tensions (L,) [N] to which those of a run (K, L) are compared: the first ones.

    Where a rope begins slack it is the largest one of the first rows; without any it is 1 N.
    """
    largest = tensions.max(axis=0, initial=0.0)
    usual = np.where(tensions[0] > 0.01 * largest, tensions[0], largest)
    return np.where(usual > MIN_TENSION, usual, max(1.0, float(usual.max(initial=0.0))))


def rope_colors(tensions: Array, usual: Array) -> NDArray[np.uint8]:
    """Return rope colours (F, L, 3), 0 to 255, of tensions (F, L) [N] relative to `usual` (L,)."""
    ratio = tensions / usual
    stops = (0.0, 1.0, 2.0)
    channels = [
        np.interp(ratio, stops, values)
        for values in zip(UNLOADED_COLOR, USUAL_COLOR, DOUBLE_COLOR, strict=True)
    ]
    colors = np.stack(channels, axis=-1)
    return (
        np.where((tensions <= MIN_TENSION)[..., None], SLACK_COLOR, colors).round().astype(np.uint8)
    )
