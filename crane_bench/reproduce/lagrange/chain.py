"""Mass matrix, Coriolis matrix and potential forces of a trolley with N links of varying length.

The nodes A_0 (the trolley) .. A_N are Cartesian points, so that with A = ∂(positions)/∂q from (9)

    M = Σ m_i A_iᵀ A_i,    C = Σ m_i A_iᵀ Ȧ_i,

and this C is the one of the Christoffel symbols of Remark 1: for points p_m in a flat space they
are Γ_ijk = Σ m_m ∂p_m/∂q_i · ∂²p_m/∂q_j∂q_k. Written out, M has the entries (19)-(21), (32)-(33),
(39), (62)-(63).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from crane_bench.reproduce.lagrange.coordinates import Array, absolute, absolute_map, unpack


class LumpedCrane(NamedTuple):
    """A trolley and the nodes below it; the last one is the payload."""

    trolley: float  # m, kg
    masses: Array  # m_i, (N,), kg
    gravity: float = 9.81  # m/s²
    joint_stiffness: Array | float = 0.0  # κ, (N,), N·m/rad: springs between links, section 4.3,
    # equation (87)


def directions(q: Array) -> tuple[Array, Array]:
    """Return unit vectors (N, 2) in (x, z): down each link, and across it to growing angles."""
    alpha = absolute(unpack(q)[1])
    s, c = np.sin(alpha), np.cos(alpha)
    return np.stack([s, -c], axis=1), np.stack([c, s], axis=1)


def node_positions(q: Array) -> Array:
    """Return positions (N+1, 2) of the nodes A_0 .. A_N in (x, z); their velocities are (9)."""
    x, _, lengths = unpack(q)
    along, _ = directions(q)
    return np.array([x, 0.0]) + np.cumsum(
        np.concatenate([[[0.0, 0.0]], lengths[:, None] * along]), axis=0
    )


def _relative_coordinates(trolley: float, angles: Array, lengths: Array) -> Array:
    """Return the array (N+1, 2, 2N+1) in relative angles, from each link's contributions.

    A link contributes to the nodes below it.
    """
    n = len(angles)
    below = np.tri(n + 1, n, -1)  # node i hangs below links 1 .. i
    columns = np.zeros((n + 1, 2, 2 * n + 1), dtype=angles.dtype)
    columns[:, 0, 0] = trolley
    columns[:, :, 1 : n + 1] = np.einsum("ik,ka->iak", below, angles)
    columns[:, :, n + 1 :] = np.einsum("ik,ka->iak", below, lengths)
    return columns @ absolute_map(n)


def node_jacobian(q: Array) -> Array:
    """Return the derivatives (N+1, 2, 2N+1) of node positions with respect to q, from (9)."""
    along, across = directions(q)
    return _relative_coordinates(1.0, unpack(q)[2][:, None] * across, along)


def node_jacobian_rate(q: Array, v: Array) -> Array:
    """Return the time derivative (N+1, 2, 2N+1) of `node_jacobian` at rates v."""
    along, across = directions(q)
    rate, paid = absolute(unpack(v)[1])[:, None], unpack(v)[2][:, None]
    return _relative_coordinates(
        0.0, paid * across - unpack(q)[2][:, None] * rate * along, rate * across
    )


def mass_matrix(crane: LumpedCrane, q: Array) -> Array:
    """Return M(q) (2N+1, 2N+1), equation (13): entries (19)-(21), (32)-(33), (39), (62)-(63)."""
    jacobian = node_jacobian(q)
    return np.einsum("i,iap,iaq->pq", _node_masses(crane), jacobian, jacobian)


def coriolis(crane: LumpedCrane, q: Array, v: Array) -> Array:
    """Return C(q, v) (2N+1, 2N+1) of the Christoffel symbols of Remark 1."""
    return np.einsum(
        "i,iap,iaq->pq", _node_masses(crane), node_jacobian(q), node_jacobian_rate(q, v)
    )


def kinetic_energy(crane: LumpedCrane, q: Array, v: Array) -> Any:
    """Return the kinetic energy [J]: (4), (11)."""
    speed, lengths = v[0], unpack(q)[2]
    rate, paid = absolute(unpack(v)[1]), unpack(v)[2]
    along, across = directions(q)
    horizontal = speed + np.cumsum(lengths * rate * across[:, 0] + paid * along[:, 0])
    vertical = np.cumsum(lengths * rate * across[:, 1] + paid * along[:, 1])
    nodes = crane.trolley * speed**2 + np.sum(crane.masses * (horizontal**2 + vertical**2))
    return 0.5 * nodes


def potential_energy(crane: LumpedCrane, q: Array) -> Any:
    """Return the potential energy [J]: gravity (82), joints before (87)."""
    elastic = np.sum(crane.joint_stiffness * unpack(q)[1] ** 2)
    return crane.gravity * np.sum(crane.masses * node_positions(q)[1:, 1]) + 0.5 * elastic


def potential_force(crane: LumpedCrane, q: Array) -> Array:
    """Return g(q) = ∂U/∂q (2N+1,): gravity (83)-(84), joints (87)."""
    weights, theta = (
        crane.gravity * np.einsum("i,ip->p", crane.masses, node_jacobian(q)[1:, 1]),
        unpack(q)[1],
    )
    return weights + np.concatenate([[0.0], crane.joint_stiffness * theta, np.zeros_like(theta)])


def bias(crane: LumpedCrane, q: Array, v: Array) -> Array:
    """Return C v + g (2N+1,): all of (93) but M q̈ and the inputs."""
    return coriolis(crane, q, v) @ v + potential_force(crane, q)


def free_coordinates(n: int, lengths: Sequence[int] = ()) -> Array:
    """Return the indices in q of trolley, angles, and links (from 1) of free length.

    Fixing a length drops its row and its column (Remark 16). All are free in (93); (1,) is the
    crane of 6.2.2, whose hoist is the first link; () is the rigid crane.
    """
    return np.array([*range(n + 1), *(n + k for k in lengths)])


def chain_acceleration(
    crane: LumpedCrane, q: Array, v: Array, forces: Array, lengths: Sequence[int] = ()
) -> Array:
    """Return q̈ (2N+1,) under generalised forces (2N+1,), with all unnamed links' lengths fixed.

    The force on a length is the one that lengthens the link: the tension is its negative. Rates of
    fixed lengths must be zero in v.

    Raises:
        ValueError: a fixed length changes.
        numpy.linalg.LinAlgError: M is singular, as with massless nodes and all lengths free.
    """
    free = free_coordinates(len(crane.masses), lengths)
    fixed = np.setdiff1d(np.arange(len(q)), free)
    if np.any(v[fixed]):
        raise ValueError(f"rates {v[fixed]} of fixed lengths: must be zero")
    total = np.zeros(len(q))
    load = (forces - bias(crane, q, v))[free]
    total[free] = np.linalg.solve(mass_matrix(crane, q)[np.ix_(free, free)], load)
    return total


def _node_masses(crane: LumpedCrane) -> Array:
    return np.concatenate([[crane.trolley], crane.masses])
