"""What functions say of loops that become vector instructions, and of their own arrays."""

from typing import Any

import numpy as np


def simd_range(*bounds: int) -> range:
    """Return range(*bounds) for a loop in the code whose independent turns run in vector lanes.

    A turn reads no element of an array that another one writes. Where it calls a `routine`, or has
    a loop, there are no lanes, nor where few turns, whose number is known, leave lanes of vectors
    free: they are written out. Other loops have none: each takes as long to compile as some hundred
    instructions.
    """
    return range(*bounds)


def local_array(shape: tuple[int, ...]) -> Any:
    """Return an undefined array of floats that ends with the function that asks for it."""
    return np.empty(shape)


def use_wide_vectors() -> None:
    """Have the function that calls this compiled for the widest vectors of the processor.

    Without it LLVM halves its vectors on processors that once clocked down.
    """
