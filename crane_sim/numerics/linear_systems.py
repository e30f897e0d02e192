"""Linear systems that equations solve: LU factors of dense and of banded matrices, in place."""

import numpy as np

from crane_sim.numerics.jit import routine


@routine
def factor_dense(a):
    """Overwrite a (n, n) with its LU factors by partial pivoting; return its rows' order (n,)."""
    n = len(a)
    order = np.arange(n)
    for j in range(n):
        best = j
        for i in range(j + 1, n):
            if abs(a[i, j]) > abs(a[best, j]):
                best = i
        order[j] = best
        for k in range(n):
            a[j, k], a[best, k] = a[best, k], a[j, k]
        for i in range(j + 1, n):
            a[i, j] /= a[j, j]
            for k in range(j + 1, n):
                a[i, k] -= a[i, j] * a[j, k]
    return order


@routine
def solve_dense(a, order, b):
    """Overwrite b (n,) with the solution, given what `factor_dense` left in a and returned."""
    n = len(a)
    for j in range(n):
        b[j], b[order[j]] = b[order[j]], b[j]
        for i in range(j):
            b[j] -= a[j, i] * b[i]
    for j in range(n - 1, -1, -1):
        for k in range(j + 1, n):
            b[j] -= a[j, k] * b[k]
        b[j] /= a[j, j]


@routine
def factor_band(a):
    """Overwrite a band with its LU factors, without pivoting: for nearly definite matrices.

    Args:
        a: entry (i, j) of the matrix at a[i, width + j - i], for |j - i| <= width; (n, 2 width +
            1). The diagonal becomes that of 1 / U.
    """
    n, width = len(a), a.shape[1] // 2
    for j in range(n):
        a[j, width] = 1.0 / a[j, width]
        last = min(j + width, n - 1)
        for i in range(j + 1, last + 1):
            factor = a[i, width + j - i] * a[j, width]
            a[i, width + j - i] = factor
            for k in range(j + 1, last + 1):
                a[i, width + k - i] -= factor * a[j, width + k - j]


def solve_band(a, b, width, work):
    """Overwrite b (n,) with the solution, given what `factor_band` left in a.

    Args:
        a: (n, 2 width + 1), 0 where the band sticks out of the matrix.
        b: (n,)
        width: of the band; where it is a constant of the caller, loops along the band cost nothing.
        work: (n + 2 width,), its first and last `width` entries 0.
    """
    for i in range(len(a)):
        total = b[i]
        for j in range(width):
            total -= a[i, j] * work[i + j]
        work[i + width] = total
    for i in range(len(a) - 1, -1, -1):
        total = work[i + width]
        for j in range(width + 1, 2 * width + 1):
            total -= a[i, j] * work[i + j]
        b[i] = total * a[i, width]
        work[i + width] = b[i]


def add_band_product(a, x, factor, b, width, work):
    """Add factor times the product of a band with x (n,) to b (n,); arguments of `solve_band`."""
    for i in range(len(a)):
        work[i + width] = x[i]
    for i in range(len(a)):
        total = 0.0
        for j in range(2 * width + 1):
            total += a[i, j] * work[i + j]
        b[i] += factor * total
