"""Arithmetic on states that are arrays, as plain Python: intrinsics cannot run with NUMBA_DISABLE_JIT=1.

It serves tests of what goes on around the equations: sums are not rounded as the compiled ones are.
"""

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from crane_sim.numerics import states

Row = Sequence[float | None]


def weigh(h: float, weights: Row, count: int, ks: np.ndarray, x: np.ndarray | None, out: np.ndarray) -> None:
    """Write x plus the sum of h weights[j] ks[j] over the first `count` rows into `out`; x may be None."""
    total = sum(h * weight * row for weight, row in zip(weights[:count], ks[:count], strict=True) if weight)
    out[:] = total if x is None else x + total


def _moved(x: Any, h: float, row: Row, ks: Any, out: Any) -> Any:
    if not isinstance(x, np.ndarray):
        return _ORIGINAL["add_weighted"](x, h, row, ks, out)
    return weigh(h, row, len(row), ks.rows, x, out)


def _error_square(h: float, row: Row, ks: Any, x: Any, y: Any, rtol: float, atol: float) -> float:
    if not isinstance(x, np.ndarray):
        return _ORIGINAL["error_square"](h, row, ks, x, y, rtol, atol)
    error = np.empty_like(x)
    weigh(h, row, len(row), ks.rows, None, error)
    return states.squared_error_norm(error, x, y, rtol, atol)


_ORIGINAL: dict[str, Any] = {"add_weighted": states.add_weighted, "error_square": states.error_square}
_PLAIN = {"accumulate": weigh, "add_weighted": _moved, "error_square": _error_square}


def install() -> None:
    """Let the integrators, which have been imported, work on arrays in plain Python."""
    for name, module in list(sys.modules.items()):
        if name.startswith("crane_sim.integrators.") or name in (
            "crane_sim.numerics.arrays",
            "crane_sim.numerics.states",
        ):
            vars(module).update({key: plain for key, plain in _PLAIN.items() if key in vars(module)})
