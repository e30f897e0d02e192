"""Linear systems that kernels solve: LU factors of dense and of banded matrices, in place."""

import numpy as np

from crane_sim.jit import routine


@routine
def factor_dense(a):
    """Overwrite the matrix a (n, n) with its LU factors by partial pivoting; return the order of its rows (n,)."""
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
    """Overwrite a band with its LU factors, without pivoting: for matrices that are as good as positive definite.

    Args:
        a: entry (i, j) of the matrix at a[i, width + j - i], for |j - i| <= width; (n, 2 width + 1). The diagonal
            becomes that of 1 / U.
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


@routine
def solve_band(a, b):
    """Overwrite b (n,) with the solution, given what `factor_band` left in a."""
    n, width = len(a), a.shape[1] // 2
    for i in range(n):
        for j in range(max(0, i - width), i):
            b[i] -= a[i, width + j - i] * b[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, min(i + width, n - 1) + 1):
            b[i] -= a[i, width + j - i] * b[j]
        b[i] *= a[i, width]


@routine
def band_row(a, i, x):
    """Return entry i of the product of a band a, stored as `factor_band` takes it, with a vector x (n,)."""
    width, total = a.shape[1] // 2, 0.0
    for j in range(max(0, i - width), min(i + width, len(a) - 1) + 1):
        total += a[i, width + j - i] * x[j]
    return total
