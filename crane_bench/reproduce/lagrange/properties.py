"""Properties of the report's matrices: symmetry, definiteness, skew-symmetry, rank, condition.

Derivatives are complex steps: Im f(q + i h d) / h has no difference of close numbers and is exact
to rounding.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from crane_bench.reproduce.lagrange.chain import LumpedCrane, mass_matrix
from crane_bench.reproduce.lagrange.coordinates import Array, absolute_map, transform_mass

_STEP = 1e-100  # its square is nothing beside 1


def derivative_along(function: Callable[[Array], Any], q: Array, direction: Array) -> Any:
    """Return the derivative of an analytic function of q along a direction."""
    return np.imag(function(q + 1j * _STEP * direction)) / _STEP


def gradient(function: Callable[[Array], Any], q: Array) -> Array:
    """Return the derivatives of an analytic function by each entry of q, in the first axis."""
    return np.array([derivative_along(function, q, direction) for direction in np.eye(len(q))])


def asymmetry(matrix: Array) -> float:
    """Return the largest entry of M - Mᵀ relative to the largest of M: 0 in (2) and (13)."""
    return float(np.max(np.abs(matrix - matrix.T)) / np.max(np.abs(matrix)))


def smallest_eigenvalue(matrix: Array) -> float:
    """Return the least eigenvalue of a symmetric matrix.

    It is positive where M is positive definite, as below (2).
    """
    return float(np.linalg.eigvalsh(matrix)[0])


def mass_rate(crane: LumpedCrane, q: Array, v: Array) -> Array:
    """Return Ṁ (2N+1, 2N+1), the time derivative of the mass matrix along a motion with rates v."""
    return derivative_along(lambda at: mass_matrix(crane, at), q, v)


def skewness_error(rate: Array, c: Array) -> float:
    """Return the largest entry of Ṁ - C - Cᵀ over that of Ṁ: 0 by Property 1, equation (3)."""
    return float(np.max(np.abs(rate - c - c.T)) / np.max(np.abs(rate)))


def christoffel(crane: LumpedCrane, q: Array) -> Array:
    """Return Γ_ijk (2N+1, 2N+1, 2N+1) of Remark 1, by differentiating M: C_ij = Σ_k Γ_ijk v_k."""
    d = gradient(lambda at: mass_matrix(crane, at), q)  # [k, i, j]: derivative of m_ij by q_k
    return 0.5 * (np.einsum("kij->ijk", d) + np.einsum("jik->ijk", d) - np.einsum("ikj->ijk", d))


def rank(matrix: Array) -> int:
    """Return the rank of a mass matrix: 2N+1 where all nodes have mass (Lemma 1)."""
    return int(np.linalg.matrix_rank(matrix, hermitian=True))


def conditions(mass: Array, free: Array) -> tuple[float, float]:
    """Return M's condition numbers in (absolute, relative) angles, fixed lengths dropped.

    M is (2N+1, 2N+1).

    The coordinates that stay are `free`, as `free_coordinates` gives them (Lemma 1.8, equation
    (157)).
    """
    kept = np.ix_(free, free)
    upright = transform_mass(mass, absolute_map(len(mass) // 2))
    return float(np.linalg.cond(upright[kept])), float(np.linalg.cond(mass[kept]))
