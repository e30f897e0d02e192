"""Arithmetic on states that are arrays, in plain Python: intrinsics cannot run with NUMBA_DISABLE_JIT=1.

It is for tests of whole runs, not of numbers: sums are not rounded as the compiled ones are. The fused multiply-add,
a quarter of the time of such runs through ctypes, is the one function that is compiled, to the C library's bits.
"""

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numba.core import types
from numba.core.registry import CPUDispatcher

from crane_sim.numerics import elementary, states

Row = Sequence[float | None]


def add_rows(h: float, weights: Row, count: int, ks: np.ndarray, x: np.ndarray | None, out: np.ndarray) -> None:
    """Write x plus the sum of h weights[j] ks[j] over the first `count` rows into `out`; x may be None."""
    total = sum(h * weight * row for weight, row in zip(weights[:count], ks[:count], strict=True) if weight)
    out[:] = total if x is None else x + total


def _add_weighted(x: Any, h: float, row: Row, ks: Any, out: Any) -> Any:
    if not isinstance(x, np.ndarray):
        return _ORIGINAL["add_weighted"](x, h, row, ks, out)
    return add_rows(h, row, len(row), ks.rows, x, out)


def _error_square(h: float, row: Row, ks: Any, x: Any, y: Any, rtol: float, atol: float) -> float:
    if not isinstance(x, np.ndarray):
        return _ORIGINAL["error_square"](h, row, ks, x, y, rtol, atol)
    error = np.empty_like(x)
    add_rows(h, row, len(row), ks.rows, None, error)
    return states.squared_error_norm(error, x, y, rtol, atol)


_ORIGINAL: dict[str, Any] = {"add_weighted": states.add_weighted, "error_square": states.error_square}
_PLAIN = {"accumulate": add_rows, "add_weighted": _add_weighted, "error_square": _error_square}


class _CompiledLibrary:
    """The functions that `elementary` takes from the C library."""

    # by its dispatcher: numba.njit would return the Python function
    fma = staticmethod(
        CPUDispatcher(lambda a, b, c: elementary._fma(a, b, c), targetoptions={"nopython": True}).compile(
            (types.float64,) * 3
        )
    )


def install() -> None:
    """Replace the arithmetic of the integrators, which have been imported."""
    elementary._LIBRARY = _CompiledLibrary
    for name, module in list(sys.modules.items()):
        if name.startswith("crane_sim.integrators.") or name in (
            "crane_sim.numerics.arrays",
            "crane_sim.numerics.states",
        ):
            vars(module).update({key: plain for key, plain in _PLAIN.items() if key in vars(module)})
