"""Misprints of the overhead-crane report in its mass matrices.

They are in (145), (174), Lemma 1, Remarks 9, 13 and 14.
"""

from collections.abc import Iterator
from math import cos

import numpy as np

from crane_bench.reproduce.lagrange import chain, properties
from crane_bench.reproduce.overhead_erratum import (
    Erratum,
    erratum,
    example,
    payload_only,
    sums_from,
)


def errata() -> Iterator[Erratum]:
    """Yield the misprints in the report's order."""
    yield from light_hook_entry()
    yield from length_masses()
    yield from massless_ranks()
    yield from hoisted_entries()


def light_hook_entry() -> Iterator[Erratum]:
    """Yield entry m32 of (145), two links with m_1 = 0, which has the trolley's mass."""
    crane, q, _ = example(2)
    light, (_, _, t2, l1, l2) = payload_only(crane), q
    m, m2 = light.trolley, light.masses[1]
    coupled, truth = m2 * l1 * l2 * cos(t2), chain.mass_matrix(light, q)[2, 1]
    yield erratum("(145), m32", "m_2 l_2²", coupled + m * l2**2, coupled + m2 * l2**2, truth)


def length_masses() -> Iterator[Erratum]:
    """Yield the diagonal of the block of lengths, Lemma 1.3."""
    crane, q, _ = example(3)
    truth = np.diag(chain.mass_matrix(crane, q))[4:]
    yield erratum(
        "Lemma 1.3", "Σ_{j=n}^N m_j", np.cumsum(crane.masses), sums_from(crane.masses), truth
    )


def massless_ranks() -> Iterator[Erratum]:
    """Yield ranks without masses between trolley and payload: Lemma 1.8, Remarks 9, 13, 14.

    As printed, rank is lost around the vertical; these links are far from it. The trolley and one
    point have 1 + 2 coordinates, so that no more than 3 combinations of rates have kinetic energy,
    2 of them with the trolley at rest.
    """
    for n in (2, 3):
        crane, q, _ = example(n)
        mass = chain.mass_matrix(payload_only(crane), q)
        where = f"Lemma 1.8, off the vertical, only m_N > 0, N = {n}: rank M"
        yield erratum(where, "at most 3 everywhere", 2 * n + 1, 3, properties.rank(mass))
    yield erratum(
        where + "_ll", "at most 2 everywhere", n, 2, properties.rank(mass[n + 1 :, n + 1 :])
    )


def hoisted_entries() -> Iterator[Erratum]:
    """Yield entries of (174), the mass matrix of two links of which the first is hoisted."""
    crane, q, _ = example(2)
    m1, m2 = crane.masses
    _, t1, t2, l1, l2 = q
    mass = chain.mass_matrix(crane, q)
    straight, bent = m1 * l1**2 + m2 * (l1**2 + l2**2), 2.0 * l1 * l2 * cos(t2)
    yield erratum(
        "(174), m22",
        "2 m_2 l_1 l_2 cos θ_2",
        straight + m1 * bent,
        straight + m2 * bent,
        mass[1, 1],
    )
    printed, corrected = (m2 * l2 * (l2 + l1 * cos(angle)) for angle in (t1, t2))
    yield erratum("(174), m23", "m_2 l_1 l_2 cos θ_2", printed, corrected, mass[1, 2])
