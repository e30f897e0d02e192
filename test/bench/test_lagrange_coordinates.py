"""Coordinates of the overhead crane: maps, where they fail, rank, condition, linearisation."""

import numpy as np
import pytest

from crane_bench.reproduce.lagrange import chain, coordinates, properties
from crane_bench.reproduce.lagrange.chain import LumpedCrane
from crane_bench.reproduce.lagrange.linearisation import collocate
from crane_bench.reproduce.overhead_erratum import example, payload_only, relative_difference

SIZES = (1, 2, 3, 5)
# relative: sums of some hundred terms of one size in double precision, errors of some 1e-15 each
EXACT = 1e-12


@pytest.mark.parametrize("n", SIZES)
def test_maps_between_coordinates(n: int) -> None:
    """Relative angles, absolute angles and horizontal positions carry the same states.

    Rates and kinetic energy are the same, too.
    """
    crane, q, v = example(n)
    mass, energy = chain.mass_matrix(crane, q), chain.kinetic_energy(crane, q, v)
    assert np.allclose(
        coordinates.relative(coordinates.absolute(q[1 : n + 1])), q[1 : n + 1], rtol=0, atol=EXACT
    )
    jacobian = coordinates.horizontal_jacobian(q)
    assert (
        relative_difference(jacobian, properties.gradient(coordinates.to_horizontal, q).T) < EXACT
    )
    sines = np.sin(coordinates.absolute(q[1 : n + 1]))
    # as (189); elimination of up to 11 rows
    assert np.linalg.det(jacobian) == pytest.approx(np.prod(sines), rel=1e-10)
    for matrix in (coordinates.absolute_map(n), jacobian):
        rates = matrix @ v
        assert 0.5 * rates @ coordinates.transform_mass(mass, matrix) @ rates == pytest.approx(
            energy, rel=1e-8
        )  # / sin²


@pytest.mark.parametrize("n", SIZES)
def test_collocated_linearisation(n: int) -> None:
    """Inputs (176)-(177) accelerate trolley and hoist as wanted; angles follow by (179)."""
    crane, q, v = example(n)
    v[n + 2 :] = 0.0
    reduced, wanted, forces = collocate(crane, q, v), np.array([1.3, -0.7]), np.zeros(2 * n + 1)
    assert properties.smallest_eigenvalue(reduced.mass) > 0.0
    forces[[0, n + 1]] = reduced.forces(wanted)
    found = chain.chain_acceleration(crane, q, v, forces, (1,))
    # loads of 1e2 through matrices of condition 1e4
    assert relative_difference(found[[0, n + 1]], wanted) < 1e-10
    assert relative_difference(reduced.angles(wanted), found[1 : n + 1]) < 1e-10


@pytest.mark.parametrize("n", SIZES)
def test_rank_with_the_payload_only(n: int) -> None:
    """With m_N alone the rank of M is 3 at most, with all masses 2N + 1.

    This is so here and at the vertical.
    """
    crane, q, _ = example(n)
    upright = np.concatenate([q[:1], np.zeros(n), q[n + 1 :]])
    assert properties.rank(chain.mass_matrix(crane, q)) == 2 * n + 1
    for at in (q, upright):
        assert properties.rank(chain.mass_matrix(payload_only(crane), at)) == 3


@pytest.mark.parametrize(
    ("ratio", "absolute", "relative"),
    [(1.0, 2e2, 2e4), (1e4, 4e5, 6e7), (1e6, 4e7, 6e9), (1e8, 4e9, 6e11)],
)
def test_condition_of_the_mass_matrix(ratio: float, absolute: float, relative: float) -> None:
    """Condition numbers of ten hanging links grow with the payload.

    Relative angles are the worse coordinates.
    """
    crane = LumpedCrane(5.0, np.append(np.ones(9), ratio))
    q = np.concatenate([np.zeros(11), np.ones(10)])
    found = properties.conditions(chain.mass_matrix(crane, q), chain.free_coordinates(10))
    assert found == pytest.approx((absolute, relative), rel=0.3)  # numbers of one digit
