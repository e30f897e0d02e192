"""Functions of floats applied to rows of arrays, element by element."""

from collections.abc import Callable
from typing import Any

from crane_sim.numerics.jit import simd_range


def elementwise(f: Callable[..., tuple[Any, ...]]) -> Callable[..., None]:
    """Return a function (n, outputs, inputs) that applies f to the first n entries of rows.

    f takes a float from each input, a row or a float, and returns one for each output. Rows that
    are written are none of those that are read.
    """

    def fill(n: int, outputs: tuple[Any, ...], inputs: tuple[Any, ...]) -> None:
        for k in simd_range(n):
            values = f(*[x if isinstance(x, float) else x[k] for x in inputs])
            for row, value in zip(outputs, values, strict=True):
                row[k] = value

    return fill
