"""Eight stages of a step side by side: a row per entry of the state, a lane per stage.

Sums have an order of their own: that in which vectors of the processor add them up.
"""

from typing import Any

from crane_sim.numerics.elementary import fma
from crane_sim.numerics.jit import local_array, simd_range

STAGES = 8  # a vector of the widest processors


def _mix(matrix: Any, row: Any, j: int) -> Any:
    """Return entry j of M s: the sum of one over the even and one over the odd stages."""
    even, odd = matrix[0, j] * row[0], matrix[1, j] * row[1]
    for i in range(2, STAGES, 2):
        even, odd = fma(matrix[i, j], row[i], even), fma(matrix[i + 1, j], row[i + 1], odd)
    return even + odd


def _fold(values: Any) -> float:
    """Return the sum of an array (8,), which is overwritten: of first and last four, and so on."""
    for j in simd_range(STAGES // 2):
        values[j] += values[j + STAGES // 2]
    return (values[0] + values[2]) + (values[1] + values[3])


def mix_stages(matrix: Any, source: Any, i: int, to: Any, k: int, scale: float) -> None:
    """Write scale M s into row k of `to`, s being row i of `source`; `matrix` (8, 8) is Mᵀ."""
    row = source[i]
    for j in simd_range(STAGES):
        to[k, j] = scale * _mix(matrix, row, j)


def reach_stages(
    matrix: Any, source: Any, i: int, to: Any, k: int, path: tuple[float, float, float, Any]
) -> None:
    """Write x + nodes move + scale M s into row k of `to`, see `mix_stages`.

    path = (x, move, scale, nodes (8,)).
    """
    (x, move, scale, nodes), row = path, source[i]
    for j in simd_range(STAGES):
        to[k, j] = fma(scale, _mix(matrix, row, j), fma(nodes[j], move, x))


def take_row(source: Any, to: Any, i: int) -> float:
    """Copy the stages of row i from `source` to `to`; return the sum of the squared changes."""
    squares = local_array((STAGES,))
    for j in simd_range(STAGES):
        change = source[i, j] - to[i, j]
        to[i, j] = source[i, j]
        squares[j] = change * change
    return _fold(squares)


def weigh_stages(weights: Any, source: Any, i: int) -> float:
    """Return the sum of weights (8,) times the stages of row i."""
    products = local_array((STAGES,))
    for j in simd_range(STAGES):
        products[j] = weights[j] * source[i, j]
    return _fold(products)
