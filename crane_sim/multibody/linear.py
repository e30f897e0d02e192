"""Small symmetric positive definite systems, written out: L D Lᵀ without pivoting."""

from typing import Any, NamedTuple

Matrix = tuple[tuple[Any, ...], ...]
"""Rows of a matrix (n, n), or of its lower triangle."""


class Factors(NamedTuple):
    """A factored matrix L D Lᵀ."""

    lower: Matrix  # rows of L left of its diagonal of ones
    inverse_pivots: tuple[Any, ...]  # 1 / D


def factor(matrix: Matrix) -> Factors:
    """Return the factors of a positive definite matrix, whose lower triangle is read."""
    lower, inverse = (), ()
    for j, row in enumerate(matrix):
        scaled, own = (), ()  # D_k L_jk, L_jk
        for k in range(j):
            entry = row[k] - inner(scaled, lower[k])
            scaled, own = (*scaled, entry), (*own, entry * inverse[k])
        lower, inverse = (*lower, own), (*inverse, 1.0 / (row[j] - inner(scaled, own)))
    return Factors(lower, inverse)


def solve(factors: Factors, b: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the solution x (n,) of L D Lᵀ x = b."""
    y, x = (), ()
    for entry, row in zip(b, factors.lower, strict=True):
        y = (*y, entry - inner(y, row))
    for i in reversed(range(len(b))):
        total = y[i] * factors.inverse_pivots[i]
        for k, further in enumerate(x):
            total = total - factors.lower[i + 1 + k][i] * further
        x = (total, *x)
    return x


def add(a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a + b (n,)."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def subtract(a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a - b (n,)."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(factor: Any, a: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a multiple of a (n,)."""
    return tuple(factor * x for x in a)


def inner(a: tuple[Any, ...], b: tuple[Any, ...]) -> Any:
    """Return the sum, from left to right, of products of the entries of a with the first of b."""
    return sum(x * y for x, y in zip(a, b, strict=False))


def product(matrix: Matrix, a: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the product (n,) of a symmetric matrix, given by its lower triangle, and a vector."""
    n = len(a)
    return tuple(
        sum((matrix[i][k] if k <= i else matrix[k][i]) * a[k] for k in range(n)) for i in range(n)
    )
