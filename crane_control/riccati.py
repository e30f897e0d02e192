"""Algebraic Riccati equations of many plants: their stabilising solutions, by QZ on extended pencils.

Van Dooren, *A generalized eigenvalue approach for solving Riccati equations*, SIAM J. Sci. Stat. Comput. 2 (1981), with
the balancing of Benner, *Symplectic balancing of Hamiltonian matrices*, SIAM J. Sci. Comput. 22 (2001): the algorithm
of `scipy.linalg.solve_discrete_are` and `solve_continuous_are`, with the same calls of LAPACK and so the same bits,
without what they check anew for every plant. Whatever does not depend on LAPACK is computed for all plants at once.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import lapack

lapack_calls: Any = lapack
Array = npt.NDArray[np.float64]


def solve_riccati(a: Array, b: Array, q: Array, r: Array, discrete: bool) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Return (solutions (n, m, m), whether each of them was found).

    Args:
        a, b: of x' = a x + b u, or of the next x of sampled plants: (n, m, m) and (n, m, nu).
        q, r: weights of the states (n, m, m), and of the efforts (n, nu, nu); symmetric.
        discrete: whether the plants are sampled.
    """
    h, j = _discrete_pencils(a, b, q, r) if discrete else _continuous_pencils(a, b, q, r)
    n, m, nu = b.shape
    scale = _balance(h, j, m)[:, :m]
    bases = [_stable_basis(*pencil, m, nu, discrete) for pencil in zip(h, j, strict=True)]
    found = np.array([basis is not None for basis in bases])
    whole = np.array([np.eye(2 * m) if basis is None else basis for basis in bases])
    quotients, upper = map(np.array, zip(*(_quotient(basis, m) for basis in whole), strict=True))
    found &= _are_symmetric(whole, m) & (1.0 / np.linalg.cond(np.triu(upper)) >= np.spacing(1.0))
    quotients *= scale[:, :, None] * scale[:, None]
    return (quotients + np.swapaxes(quotients, 1, 2)) / 2, found


def _discrete_pencils(a: Array, b: Array, q: Array, r: Array) -> tuple[Array, Array]:
    """Return the extended pencils H - z J of sampled plants, (n, 2 m + nu, 2 m + nu) each."""
    n, m, nu = b.shape
    h, j = np.zeros((2, n, 2 * m + nu, 2 * m + nu))
    h[:, :m, :m], h[:, :m, 2 * m :] = a, b
    h[:, m : 2 * m, :m], h[:, m : 2 * m, m : 2 * m] = -q, np.eye(m)
    h[:, 2 * m :, 2 * m :] = r
    j[:, :m, :m] = np.eye(m)
    j[:, m : 2 * m, m : 2 * m], j[:, 2 * m :, m : 2 * m] = np.swapaxes(a, 1, 2), -np.swapaxes(b, 1, 2)
    return h, j


def _continuous_pencils(a: Array, b: Array, q: Array, r: Array) -> tuple[Array, Array]:
    """Return the extended pencils H - s J of continuous plants, (n, 2 m + nu, 2 m + nu) each."""
    n, m, nu = b.shape
    h, j = np.zeros((2, n, 2 * m + nu, 2 * m + nu))
    h[:, :m, :m], h[:, :m, 2 * m :] = a, b
    h[:, m : 2 * m, :m], h[:, m : 2 * m, m : 2 * m] = -q, -np.swapaxes(a, 1, 2)
    h[:, 2 * m :, m : 2 * m], h[:, 2 * m :, 2 * m :] = np.swapaxes(b, 1, 2), r
    j[:, : 2 * m, : 2 * m] = np.eye(2 * m)
    return h, j


def _balance(h: Array, j: Array, m: int) -> Array:
    """Scale the pencils in place so that they stay symplectic; return the scales (n, 2 m + nu), powers of 2."""
    sizes = np.abs(h) + np.abs(j)
    np.einsum("nii->ni", sizes)[:] = 0.0
    scales = np.array([lapack_calls.dgebal(each, scale=1, permute=0)[3] for each in sizes])
    logs = np.log2(scales)
    halves = np.round((logs[:, m : 2 * m] - logs[:, :m]) / 2)
    scales = 2.0 ** np.concatenate([halves, -halves, logs[:, 2 * m :]], axis=1)
    factors = scales[:, :, None] * np.reciprocal(scales)[:, None]
    h *= factors
    j *= factors
    return scales


def _stable_basis(h: Array, j: Array, m: int, nu: int, discrete: bool) -> Array | None:
    """Return a basis (2 m, 2 m) whose first m columns span the stable subspace of a pencil; None where none was found.

    Raises:
        ValueError: the pencil is too ill-conditioned to be reordered.
    """
    size = 2 * m
    factors, tau, _, _ = lapack_calls.dgeqrf(h[:, -nu:])
    padded = np.empty((size + nu, size + nu), order="F")
    padded[:, :nu] = factors
    rotation = lapack_calls.dorgqr(padded, tau, overwrite_a=1)[0]
    rows = slice(None) if discrete else slice(None, size)  # of what J has outside of 0
    h, j = rotation[:, nu:].T.dot(h[:, :size]), rotation[rows, nu:].T.dot(j[rows, :size])
    a, b, _, real, imaginary, beta, left, right, _, info = lapack_calls.dgges(
        _never, h, j, lwork=8 * size + 16 + 64 * size, sort_t=0
    )
    if info:
        return None
    quotients = np.divide(real + 1j * imaginary, beta, out=np.full(size, np.inf + 0j), where=beta != 0.0)
    select = np.abs(quotients) < 1.0 if discrete else np.real(quotients) < 0.0
    *_, basis, _, _, _, _, info = lapack_calls.dtgsen(select, a, b, left, right, ijob=0, lwork=4 * size + 16, liwork=1)
    if info == 1:
        raise ValueError("the Riccati equation is too ill-conditioned")
    return basis


def _never(*_: Any) -> None:
    """Select no eigenvalue: the reordering does."""


def _quotient(basis: Array, m: int) -> tuple[Array, Array]:
    """Return (the solution, basis[m:, :m] by basis[:m, :m], not made symmetric; the factors of the latter)."""
    factors, order, _ = lapack_calls.dgetrf(basis[:m, :m])
    rows = np.arange(m)
    for i, k in enumerate(order):
        rows[[i, k]] = rows[[k, i]]
    x, _ = lapack_calls.dtrtrs(factors, basis[m:, :m].T, lower=0, trans=1)
    x, _ = lapack_calls.dtrtrs(factors, x, lower=1, trans=1, unitdiag=1)
    solution = np.empty((m, m))
    solution[:, rows] = x.T
    return solution, factors


def _are_symmetric(bases: Array, m: int) -> npt.NDArray[np.bool_]:
    """Return where no eigenvalue is too close to the limit of stability: then a product of the basis is symmetric."""
    product = np.swapaxes(bases[:, :m, :m], 1, 2) @ bases[:, m:, :m]
    parts = product, product - np.swapaxes(product, 1, 2)
    largest, difference = (np.abs(part).sum(axis=1).max(axis=1) for part in parts)
    return difference <= np.maximum(np.spacing(1000.0), 0.1 * largest)
