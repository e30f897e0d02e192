"""The coordinates of a planar chain of N links, maps between them, and where each one fails.

| coordinates                                         | in the report | fail where                                     |
|-----------------------------------------------------|---------------|------------------------------------------------|
| relative angles θ                                   | section 3     | nowhere, but M is the worst conditioned        |
| absolute angles α_k = θ_1 + .. + θ_k                | 6.2.1         | nowhere                                        |
| (x, θ, x_1 .. x_N): lengths by horizontal positions | 6.2.3         | a link is vertical, sin α_k = 0                |
| (x, x_1 .. x_N): fixed lengths, no angles           | end of 6.2.3  | a link is horizontal; it hides up against down |

The report's horizontal positions are those for small angles; here they are exact.
"""  # noqa: E501

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def absolute(theta: Array) -> Array:
    """Return absolute angles or rates (N,) of relative ones, equation (155)."""
    return np.cumsum(theta)


def relative(alpha: Array) -> Array:
    """Return relative angles or rates (N,) of absolute ones, equation (156)."""
    return np.diff(alpha, prepend=0.0)


def absolute_map(n: int) -> Array:
    """Return the matrix T (2n+1, 2n+1) from relative to absolute angles, equation (155).

    It applies to q and its rates.
    """
    matrix = np.eye(2 * n + 1)
    matrix[1 : n + 1, 1 : n + 1] = np.tri(n)
    return matrix


def unpack(q: Array) -> tuple[Any, Array, Array]:
    """Return (first entry, relative angles (N,), lengths (N,)) of q, or of its rates."""
    n = len(q) // 2
    return q[0], q[1 : n + 1], q[n + 1 :]


def transform_mass(mass: Array, jacobian: Array) -> Array:
    """Return the mass matrix in the coordinates y, given ∂y/∂q, equations (157) and (191).

    Raises:
        numpy.linalg.LinAlgError: the coordinates y fail here.
    """
    inverse = np.linalg.inv(jacobian)
    return inverse.T @ mass @ inverse


def to_horizontal(q: Array) -> Array:
    """Return q_x = (x, θ, x_1 .. x_N) of section 6.2.3: nodes' horizontal positions, no lengths."""
    x, theta, lengths = unpack(q)
    return np.concatenate([[x], theta, x + np.cumsum(lengths * np.sin(absolute(theta)))])


def horizontal_jacobian(q: Array) -> Array:
    """Return ∂q_x/∂q (2N+1, 2N+1), equation (187) without its small angles.

    Its determinant is Π sin α_k, as (189).

    Rates follow as q̇_x = ∂q_x/∂q q̇, and back by solving for q̇ where no link is vertical.
    """
    _, theta, lengths = unpack(q)
    alpha, n = absolute(theta), len(theta)
    jacobian = np.eye(2 * n + 1, dtype=q.dtype)
    jacobian[n + 1 :, 0] = 1.0
    jacobian[n + 1 :, 1 : n + 1] = (np.tri(n) * lengths * np.cos(alpha)) @ np.tri(n)  # (188)
    jacobian[n + 1 :, n + 1 :] = np.tri(n) * np.sin(alpha)  # (189)
    return jacobian
