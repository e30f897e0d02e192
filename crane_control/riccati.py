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
    m = b.shape[1]
    scale = _balance(h, j, m)[:, :m]
    bases = _stable_bases(h, j, m, discrete)
    found = np.array([basis is not None for basis in bases])
    whole = np.array([np.eye(2 * m) if basis is None else basis for basis in bases])
    quotients, upper = _quotients(whole, m)
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


def _stable_bases(h: Array, j: Array, m: int, discrete: bool) -> list[Array | None]:
    """Return bases (2 m, 2 m) whose first m columns span the stable subspaces of pencils; None where none was found.

    Raises:
        ValueError: a pencil is too ill-conditioned to be reordered.
    """
    size, work = 2 * m, 8 * 2 * m + 16 + 64 * 2 * m
    forms = [_schur_form(*_compress(*pencil, size, discrete), work) for pencil in zip(h, j, strict=True)]
    real, imaginary, beta = (np.array([form[k] for form in forms]) for k in (3, 4, 5))
    quotients = np.divide(real + 1j * imaginary, beta, out=np.full(beta.shape, np.inf + 0j), where=beta != 0.0)
    select = np.abs(quotients) < 1.0 if discrete else np.real(quotients) < 0.0
    return [
        None if info else _reorder(chosen, a, b, right, 4 * size + 16)
        for chosen, (a, b, _, _, _, _, _, right, _, info) in zip(select, forms, strict=True)
    ]


def _compress(h: Array, j: Array, size: int, discrete: bool) -> tuple[Array, Array]:
    """Return a pencil without the columns of the efforts, and the rows that they span."""
    nu = len(h) - size
    factors, tau, _, _ = lapack_calls.dgeqrf(h[:, -nu:])
    padded = np.empty((size + nu, size + nu), order="F")
    padded[:, :nu] = factors
    rotation = lapack_calls.dorgqr(padded, tau, overwrite_a=1)[0]
    rows = slice(None) if discrete else slice(None, size)  # of what J has outside of 0
    return rotation[:, nu:].T.dot(h[:, :size]), rotation[rows, nu:].T.dot(j[rows, :size])


def _schur_form(h: Array, j: Array, work: int) -> tuple[Any, ...]:
    """Return the generalised Schur form of a pencil, as `dgges` does, without the vectors from the left."""
    return lapack_calls.dgges(_never, h, j, jobvsl=0, lwork=work, sort_t=0)


def _reorder(select: Array, a: Array, b: Array, right: Array, work: int) -> Array:
    """Return the vectors of a Schur form (a, b) from the right, those of the selected eigenvalues first."""
    unused = np.empty((len(a), len(a)), order="F")
    found = lapack_calls.dtgsen(select, a, b, unused, right, ijob=0, wantq=0, lwork=work, liwork=1)
    if found[-1] == 1:
        raise ValueError("the Riccati equation is too ill-conditioned")
    return found[6]


def _never(*_: Any) -> None:
    """Select no eigenvalue: the reordering does."""


def _quotients(bases: Array, m: int) -> tuple[Array, Array]:
    """Return (the solutions, basis[m:, :m] by basis[:m, :m], not made symmetric; the factors of the latter)."""
    parts = [lapack_calls.dgetrf(basis[:m, :m]) for basis in bases]
    columns = [_solve_transposed(factors, basis[m:, :m]) for (factors, _, _), basis in zip(parts, bases, strict=True)]
    rows, numbers = np.tile(np.arange(m), (len(bases), 1)), np.arange(len(bases))
    for i, k in enumerate(np.array([order for _, order, _ in parts]).T):
        rows[numbers, i], rows[numbers, k] = rows[numbers, k], rows[numbers, i].copy()
    solutions = np.empty((len(bases), m, m))
    solutions[numbers[:, None, None], np.arange(m)[:, None], rows[:, None]] = np.swapaxes(np.array(columns), 1, 2)
    return solutions, np.array([factors for factors, _, _ in parts])


def _solve_transposed(factors: Array, right: Array) -> Array:
    """Return the solutions of the transposed equations, of the rows of `right`, from triangular factors."""
    x, _ = lapack_calls.dtrtrs(factors, right.T, lower=0, trans=1)
    return lapack_calls.dtrtrs(factors, x, lower=1, trans=1, unitdiag=1)[0]


def _are_symmetric(bases: Array, m: int) -> npt.NDArray[np.bool_]:
    """Return where no eigenvalue is too close to the limit of stability: then a product of the basis is symmetric."""
    product = np.swapaxes(bases[:, :m, :m], 1, 2) @ bases[:, m:, :m]
    parts = product, product - np.swapaxes(product, 1, 2)
    largest, difference = (np.abs(part).sum(axis=1).max(axis=1) for part in parts)
    return difference <= np.maximum(np.spacing(1000.0), 0.1 * largest)
