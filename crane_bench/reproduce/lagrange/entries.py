"""The report's sums for the mass matrix and the gravity of N links, by entry; right as printed.

Slow, and a derivation of its own beside `crane_bench.reproduce.lagrange.chain`. Nodes and links are
counted from 1, as there.
"""

from math import cos, fsum, sin

import numpy as np

from crane_bench.reproduce.lagrange.chain import LumpedCrane
from crane_bench.reproduce.lagrange.coordinates import Array, absolute, unpack


def mass_matrix(crane: LumpedCrane, q: Array) -> Array:
    """Return M(q) (2N+1, 2N+1) by (19)-(21), (32)-(33), (39) and (62)-(63)."""
    n = len(crane.masses)
    mass = np.zeros((2 * n + 1, 2 * n + 1))
    mass[0, 0] = crane.trolley + fsum(crane.masses)  # (19)
    for row in range(1, n + 1):
        mass[0, row] = mass[row, 0] = angle_trolley(crane, q, row)
        mass[0, n + row] = mass[n + row, 0] = length_trolley(crane, q, row)
        for column in range(1, n + 1):
            mass[row, column] = angle_angle(crane, q, row, column)
            mass[row, n + column] = mass[n + column, row] = angle_length(crane, q, row, column)
            mass[n + row, n + column] = length_length(crane, q, row, column)
    return mass


def angle_trolley(crane: LumpedCrane, q: Array, n: int) -> float:
    """Return the entry of θ_n and x, (20) and (32)."""
    alpha, lengths, nodes = _absolute_links(q)
    return fsum(
        crane.masses[i - 1] * lengths[k] * cos(alpha[k])
        for i in range(n, nodes)
        for k in range(n, i + 1)
    )


def length_trolley(crane: LumpedCrane, q: Array, n: int) -> float:
    """Return the entry of l_n and x, (21)."""
    alpha, _, _ = _absolute_links(q)
    return fsum(crane.masses[n - 1 :]) * sin(alpha[n])


def angle_angle(crane: LumpedCrane, q: Array, n: int, p: int) -> float:
    """Return the entry of θ_n and θ_p, (33)."""
    alpha, lengths, nodes = _absolute_links(q)
    total = 0.0
    for i in range(max(n, p), nodes):
        c = fsum(lengths[k] * cos(alpha[k]) for k in range(n, i + 1))
        s = fsum(lengths[k] * sin(alpha[k]) for k in range(n, i + 1))
        inner = fsum(lengths[k] * (cos(alpha[k]) * c + sin(alpha[k]) * s) for k in range(p, i + 1))
        total += crane.masses[i - 1] * inner
    return total


def angle_length(crane: LumpedCrane, q: Array, n: int, p: int) -> float:
    """Return the entry of θ_n and l_p, (39)."""
    alpha, lengths, nodes = _absolute_links(q)
    total = 0.0
    for i in range(max(n, p), nodes):
        c = fsum(lengths[k] * cos(alpha[k]) for k in range(n, i + 1))
        s = fsum(lengths[k] * sin(alpha[k]) for k in range(n, i + 1))
        total += crane.masses[i - 1] * (sin(alpha[p]) * c - cos(alpha[p]) * s)
    return total


def length_length(crane: LumpedCrane, q: Array, n: int, p: int) -> float:
    """Return the entry of l_n and l_p, (62) and (63)."""
    alpha, _, _ = _absolute_links(q)
    return fsum(crane.masses[max(n, p) - 1 :]) * cos(alpha[n] - alpha[p])


def gravity(crane: LumpedCrane, q: Array) -> Array:
    """Return the gravity forces (2N+1,) of (83) and (84)."""
    alpha, lengths, nodes = _absolute_links(q)
    angles, reach = [], []
    for n in range(1, nodes):
        terms = (
            crane.masses[i - 1] * lengths[k] * sin(alpha[k])
            for i in range(n, nodes)
            for k in range(n, i + 1)
        )
        angles.append(crane.gravity * fsum(terms))
        reach.append(-crane.gravity * fsum(crane.masses[n - 1 :]) * cos(alpha[n]))
    return np.array([0.0, *angles, *reach])


def _absolute_links(q: Array) -> tuple[list[float], list[float], int]:
    """Return (absolute angles, lengths, N + 1), with unused first entries: links count from 1."""
    _, theta, lengths = unpack(q)
    return [0.0, *absolute(theta)], [0.0, *lengths], len(theta) + 1
