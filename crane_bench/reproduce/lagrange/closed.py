"""The report's closed forms for two links and for one; right as printed in their last lines.

They are for point masses without joints and springs; other parameters of the crane are not looked
at.
"""

from math import cos, sin

import numpy as np

from crane_bench.reproduce.lagrange.chain import LumpedCrane
from crane_bench.reproduce.lagrange.coordinates import Array


def mass_matrix_two(crane: LumpedCrane, q: Array) -> Array:
    """Return M(q) (5, 5) of two links, equations (138)-(142)."""
    m, (m1, m2) = crane.trolley, crane.masses
    _, theta1, theta2, l1, l2 = q
    s1, c1, s12, c12 = sin(theta1), cos(theta1), sin(theta1 + theta2), cos(theta1 + theta2)
    s2, c2 = sin(theta2), cos(theta2)
    m12 = m1 * l1 * c1 + m2 * (l1 * c1 + l2 * c12)
    m22 = m1 * l1**2 + m2 * l1**2 + m2 * l2**2 + 2.0 * m2 * l1 * l2 * c2
    m23 = m2 * l1 * l2 * c2 + m2 * l2**2
    return np.array(
        [
            [m + m1 + m2, m12, m2 * l2 * c12, (m1 + m2) * s1, m2 * s12],
            [m12, m22, m23, -m2 * l2 * s2, m2 * l1 * s2],
            [m2 * l2 * c12, m23, m2 * l2**2, -m2 * l2 * s2, 0.0],
            [(m1 + m2) * s1, -m2 * l2 * s2, -m2 * l2 * s2, m1 + m2, m2 * c2],
            [m2 * s12, m2 * l1 * s2, 0.0, m2 * c2, m2],
        ]
    )


def forces_one(crane: LumpedCrane, q: Array, v: Array, a: Array) -> Array:
    """Return (F, 0, F_1) that give one link the accelerations a (3,): the left sides of (194)."""
    m, (m1,), g = crane.trolley, crane.masses, crane.gravity
    (_, theta, length), (_, rate, paid), (ax, turned, drawn) = q, v, a
    s, c = sin(theta), cos(theta)
    swing = length * c * turned + s * drawn + 2.0 * paid * rate * c - length * rate**2 * s
    return np.array(
        [
            (m + m1) * ax + m1 * swing,
            m1 * length * (c * ax + length * turned + 2.0 * paid * rate + g * s),
            m1 * (s * ax + drawn - g * c - length * rate**2),
        ]
    )
