"""Small symmetric systems, written out: L D Lᵀ without pivoting, for matrices that are positive definite."""

from collections.abc import Sequence
from typing import Any, NamedTuple

Matrix = tuple[tuple[Any, ...], ...]
"""Rows of a matrix (n, n)."""


class Factors(NamedTuple):
    """A factored matrix L D Lᵀ."""

    lower: Matrix  # L below its diagonal of ones
    inverse_pivots: tuple[Any, ...]  # 1 / D


def factor(matrix: Matrix) -> Factors:
    """Return the factors of a positive definite matrix, whose lower triangle is read."""
    n = len(matrix)
    lower: list[list[Any]] = [[0.0] * n for _ in range(n)]
    inverse: list[Any] = []
    for j in range(n):
        scaled: list[Any] = []  # D_k L_jk
        for k in range(j):
            scaled.append(matrix[j][k] - inner(scaled, lower[k]))
            lower[j][k] = scaled[k] * inverse[k]
        inverse.append(1.0 / (matrix[j][j] - inner(scaled, lower[j])))
    return Factors(tuple(map(tuple, lower)), tuple(inverse))


def solve(factors: Factors, b: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the solution x (n,) of L D Lᵀ x = b."""
    lower, inverse = factors
    y: list[Any] = []
    for i, entry in enumerate(b):
        y.append(entry - inner(y, lower[i]))
    x = [entry * pivot for entry, pivot in zip(y, inverse, strict=True)]
    for i in reversed(range(len(b))):
        for k in range(i + 1, len(b)):
            x[i] = x[i] - lower[k][i] * x[k]
    return tuple(x)


def add(a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a + b (n,)."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def inner(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return the sum of the products of the entries of a with the first ones of b, from left to right."""
    total = 0.0
    for x, y in zip(a, b, strict=False):
        total = total + x * y
    return total
