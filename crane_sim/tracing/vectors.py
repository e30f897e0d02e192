"""What a function says of its loops that are to become vector instructions, and of arrays that it needs for itself."""

from typing import Any

import numpy as np


def simd_range(*bounds: int) -> range:
    """Return range(*bounds) for a loop that stays one: its turns are independent, and run in lanes of vectors.

    A turn reads no element of an array that another one writes. Where it calls a `routine`, or has a loop, there are
    no lanes, nor where few turns, whose number is known, leave lanes of vectors free: they are written out. Other loops
    have none: each takes as long to compile as some hundred instructions.
    """
    return range(*bounds)


def local_array(shape: tuple[int, ...]) -> Any:
    """Return an undefined array of floats that is gone when the function that asks for it returns."""
    return np.empty(shape)


def use_wide_vectors() -> None:
    """Have the function that calls this compiled for the widest vectors of the processor.

    Without it LLVM halves its vectors on processors that once clocked down.
    """
