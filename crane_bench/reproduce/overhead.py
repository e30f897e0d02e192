"""Claims of the overhead-crane report (hal-03674652 v1), measured: properties, then misprints."""

from collections.abc import Iterator
from math import isinf
from typing import NamedTuple

import numpy as np

from crane_bench.reproduce import overhead_force_errata, overhead_matrix_errata
from crane_bench.reproduce.lagrange import chain, closed, entries, properties
from crane_bench.reproduce.lagrange.linearisation import collocate
from crane_bench.reproduce.overhead_erratum import ROUNDING, Erratum, example, relative_difference
from crane_bench.tables import Shown

SIZES = (1, 2, 3, 5, 10)


class ClaimRow(NamedTuple):
    """One claim of a paper beside what is measured here."""

    claim: str  # with its equation number
    printed: Shown  # in the paper
    ours: Shown
    difference: float | None  # largest, relative to ours or to the scale of the matrix; None
    # without a meaning
    verdict: str


def make_claim(
    claim: str, printed: Shown, ours: Shown, holds: bool, difference: float | None = None
) -> ClaimRow:
    """Return the row of a claim that holds or does not."""
    return ClaimRow(claim, printed, ours, difference, "holds" if holds else "does not hold")


def name_overhead_rows() -> list[str]:
    """Return the claims of all rows; they are matrices, and quickly measured."""
    return [row.claim for row in measure_overhead_claims()]


def measure_overhead_claims() -> list[ClaimRow]:
    """Return all rows: properties, printed forms, ranks, conditions, linearisation, misprints."""
    misprints = map(
        erratum_row, (*overhead_matrix_errata.errata(), *overhead_force_errata.errata())
    )
    return [*_matrix_properties(), *_printed_forms(), *_conditions(), *_linearisation(), *misprints]


def _matrix_properties() -> Iterator[ClaimRow]:
    """Yield symmetry, definiteness and skew-symmetry: the worst over N = 1 .. 10."""
    cases = [example(n) for n in SIZES]
    masses = [chain.mass_matrix(crane, q) for crane, q, _ in cases]
    asymmetry = max(map(properties.asymmetry, masses))
    yield make_claim("(13): M = Mᵀ", 0.0, asymmetry, asymmetry < ROUNDING, asymmetry)
    smallest = min(map(properties.smallest_eigenvalue, masses))
    yield make_claim(
        "below (2): M positive definite, smallest eigenvalue", "> 0", smallest, smallest > 0.0
    )
    skewness = max(
        properties.skewness_error(properties.mass_rate(*at), chain.coriolis(*at)) for at in cases
    )
    yield make_claim("(3): Ṁ - 2C skew-symmetric", 0.0, skewness, skewness < ROUNDING, skewness)
    symbols = max(
        relative_difference(properties.christoffel(p, q) @ v, chain.coriolis(p, q, v))
        for p, q, v in cases[:-1]
    )
    yield make_claim(
        "Remark 1: C by Christoffel symbols", 0.0, symbols, symbols < ROUNDING, symbols
    )
    ranks = all(properties.rank(mass) == len(mass) for mass in masses)
    yield make_claim(
        "below (2), all m_i > 0: rank M", "2N + 1", "2N + 1" if ranks else "less", ranks
    )


def _printed_forms() -> Iterator[ClaimRow]:
    """Yield the forms that are right as printed."""
    worst = max(
        relative_difference(entries.mass_matrix(p, q), chain.mass_matrix(p, q))
        for p, q, _ in map(example, SIZES)
    )
    yield make_claim(
        "(19)-(21), (32)-(33), (39), (62)-(63): entries of M", 0.0, worst, worst < ROUNDING, worst
    )
    worst = max(
        relative_difference(entries.gravity(p, q), chain.potential_force(p, q))
        for p, q, _ in map(example, SIZES)
    )
    yield make_claim("(83)-(84): gravity", 0.0, worst, worst < ROUNDING, worst)
    crane, q, _ = example(2)
    two = relative_difference(closed.mass_matrix_two(crane, q), chain.mass_matrix(crane, q))
    yield make_claim("(138)-(142): M, N = 2", 0.0, two, two < ROUNDING, two)
    crane, q, v = example(1)
    forces = chain.mass_matrix(crane, q) @ v + chain.bias(crane, q, v)
    one = relative_difference(closed.forces_one(crane, q, v, v), forces)
    yield make_claim("(194): equations of motion, N = 1", 0.0, one, one < ROUNDING, one)


def _conditions() -> Iterator[ClaimRow]:
    """Yield condition numbers of M as the payload grows.

    The crane has ten links of 1 m, nodes of 1 kg, and no hoist.
    """
    angles = np.random.default_rng(0).uniform(-0.5, 0.5, 10)
    q, free = (
        np.concatenate([[0.0], np.diff(angles, prepend=0.0), np.ones(10)]),
        chain.free_coordinates(10),
    )
    previous = (1.0, 1.0)  # no matrix has less
    for ratio in (1.0, 1e4, 1e6, 1e8):
        crane = chain.LumpedCrane(5.0, np.append(np.ones(9), ratio))
        conditions = properties.conditions(chain.mass_matrix(crane, q), free)
        for name, ours, lighter in zip(("absolute", "relative"), conditions, previous, strict=True):
            claim = f"Lemma 1.8: cond M, N = 10, m_N / m_i = {ratio:.0e}, {name} angles"
            yield make_claim(claim, "grows with m_N", ours, ours > 10.0 * lighter)
        previous = conditions


def _linearisation() -> Iterator[ClaimRow]:
    """Yield accelerations by the inputs of (176)-(177), of a crane with five links and a hoist."""
    crane, q, v = example(5)
    v[7:] = 0.0  # l_2 .. l_5 are fixed
    reduced, demanded = collocate(crane, q, v), np.array([1.3, -0.7])
    smallest = properties.smallest_eigenvalue(reduced.mass)
    yield make_claim(
        "Lemma 3: 𝓜 of (178) positive definite, smallest eigenvalue",
        "> 0",
        smallest,
        smallest > 0.0,
    )
    forces = np.zeros(11)
    forces[[0, 6]] = reduced.forces(demanded)
    accelerations = chain.chain_acceleration(crane, q, v, forces, (1,))
    difference = relative_difference(accelerations[[0, 6]], demanded)
    yield make_claim(
        "(176)-(177): ẍ and l̈_1 as wanted, collocated",
        0.0,
        difference,
        difference < ROUNDING,
        difference,
    )
    difference = relative_difference(reduced.angles(demanded), accelerations[1:6])
    yield make_claim(
        "(179): angles that follow", 0.0, difference, difference < ROUNDING, difference
    )


def erratum_row(erratum: Erratum) -> ClaimRow:
    """Return the row of a misprint, with its correction if that is what first principles give."""
    where, correction, printed, corrected, truth, tolerance = erratum
    difference = relative_difference(printed, truth)
    if relative_difference(corrected, truth) > tolerance:
        verdict = "unexplained"
    else:
        verdict = "holds" if difference <= tolerance else f"erratum: {correction}"
    if isinf(difference):
        return ClaimRow(where, f"shape {printed.shape}", f"shape {truth.shape}", None, verdict)
    entry = np.argmax(np.abs(printed - truth))
    return ClaimRow(
        where, float(printed.flat[entry]), float(truth.flat[entry]), difference, verdict
    )
