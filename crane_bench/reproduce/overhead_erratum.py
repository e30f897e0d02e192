"""A misprint of the overhead-crane report (hal-03674652 v1), and cranes to evaluate it on."""

from math import inf
from typing import NamedTuple

import numpy as np

from crane_bench.reproduce.lagrange.chain import LumpedCrane
from crane_bench.reproduce.lagrange.coordinates import Array

ROUNDING = 1e-11
"""Relative, of matrices up to 21 x 21 with condition numbers up to some 1e4."""


class Erratum(NamedTuple):
    """One misprint, evaluated three ways at a state; arrays of any shape, scalars included."""

    where: str
    correction: str
    printed: Array
    corrected: Array
    truth: Array  # from energies, positions and their complex steps, or from the matrices that
    # follow from them
    tolerance: float  # of corrected against truth, relative


def erratum(
    where: str,
    correction: str,
    printed: object,
    corrected: object,
    truth: object,
    tolerance: float = ROUNDING,
) -> Erratum:
    """Return the misprint with its values as arrays."""
    values = [np.array(value, dtype=float) for value in (printed, corrected, truth)]
    return Erratum(where, correction, values[0], values[1], values[2], tolerance)


def relative_difference(value: Array, expected: Array) -> float:
    """Return the largest difference over the largest expected entry; shapes differ: infinite."""
    if value.shape != expected.shape:
        return inf
    return float(np.max(np.abs(value - expected)) / np.max(np.abs(expected)))


def example(n: int) -> tuple[LumpedCrane, Array, Array]:
    """Return an asymmetric crane with n links of free lengths, q and q̇ (2n+1,).

    Nothing in it is small, equal or symmetric.
    """
    rng = np.random.default_rng(n)
    q = np.concatenate([[0.3], rng.uniform(0.2, 0.9, n), rng.uniform(0.5, 2.0, n)])
    return LumpedCrane(4.0, rng.uniform(0.5, 3.0, n)), q, rng.uniform(0.3, 1.5, 2 * n + 1)


def payload_only(crane: LumpedCrane) -> LumpedCrane:
    """Return the crane whose only node with mass is the payload.

    This is the report's limit of a large payload.
    """
    return crane._replace(masses=np.append(np.zeros(len(crane.masses) - 1), crane.masses[-1]))


def sums_from(values: Array) -> Array:
    """Return the sums of values n .. N, for each n."""
    return np.cumsum(values[::-1])[::-1]
