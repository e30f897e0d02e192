"""The overhead crane in the report's coordinates: second derivation, properties, misprints."""

from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import crane_sim
from crane_bench.reproduce import overhead_force_errata, overhead_matrix_errata
from crane_bench.reproduce.lagrange import chain, closed, coordinates, entries, properties
from crane_bench.reproduce.lagrange.chain import LumpedCrane
from crane_bench.reproduce.overhead_erratum import Erratum, example, relative_difference

SIZES = (1, 2, 3, 5)
ERRATA = [*overhead_matrix_errata.errata(), *overhead_force_errata.errata()]
# relative: sums of some hundred terms of one size in double precision, errors of some 1e-15 each
EXACT = 1e-12


def random_crane(n: int, seed: int) -> tuple[LumpedCrane, np.ndarray, np.ndarray]:
    """Return a crane with everything in it, and q and q̇ anywhere."""
    rng = np.random.default_rng(seed)
    q = np.concatenate([rng.normal(0, 1, 1), rng.uniform(-3.0, 3.0, n), rng.uniform(0.4, 2.0, n)])
    crane = LumpedCrane(5.0, rng.uniform(0.2, 4.0, n), 9.7, rng.uniform(0, 5, n))
    return crane, q, rng.normal(0, 1, 2 * n + 1)


def nodes(q: Any) -> list[tuple[Any, Any]]:
    """Return positions of trolley and nodes, each link hung below the node above it."""
    n, angle = len(q) // 2, 0
    positions = [(q[0], mpmath.mpf(0))]
    for theta, length in zip(q[1 : n + 1], q[n + 1 :], strict=True):
        angle += theta
        x, z = positions[-1]
        positions.append((x + length * mpmath.sin(angle), z - length * mpmath.cos(angle)))
    return positions


def lagrangian(p: LumpedCrane, q: Any, v: Any) -> Any:
    """Return T - U from positions, and from velocities that are differences of positions."""
    n, h = len(p.masses), mpmath.mpf("1e-15")
    ahead, behind = (
        nodes([a + sign * h * b for a, b in zip(q, v, strict=True)]) for sign in (1, -1)
    )
    total = mpmath.mpf(0)
    for mass, (xa, za), (xb, zb) in zip((p.trolley, *p.masses), ahead, behind, strict=True):
        total += mass * ((xa - xb) ** 2 + (za - zb) ** 2) / (8 * h * h)
    for mass, (_, z) in zip(p.masses, nodes(q)[1:], strict=True):
        total -= mass * mpmath.mpf(p.gravity) * z
    for k in range(n):
        total -= p.joint_stiffness[k] * q[1 + k] ** 2 / 2  # type: ignore[index]
    return total


def forces_by_differences(p: LumpedCrane, q: Any, v: Any, a: Any) -> np.ndarray:
    """Return d/dt ∂L/∂q̇ - ∂L/∂q (2N+1,), equation (1), at accelerations a, in 60 digits."""
    with mpmath.workdps(60):
        h = mpmath.mpf("1e-12")
        q, v, a = ([mpmath.mpf(float(value)) for value in values] for values in (q, v, a))
        later, earlier = (
            (
                [x + s * h * y + h * h * z / 2 for x, y, z in zip(q, v, a, strict=True)],
                [y + s * h * z for y, z in zip(v, a, strict=True)],
            )
            for s in (1, -1)
        )
        forces = []
        for i in range(len(q)):

            def moved(values: Any, by: Any, i: int = i) -> Any:
                return [value + by * (j == i) for j, value in enumerate(values)]

            def momentum(at: Any, rates: Any) -> Any:
                return (
                    lagrangian(p, at, moved(rates, h)) - lagrangian(p, at, moved(rates, -h))
                ) / (2 * h)

            slope = (lagrangian(p, moved(q, h), v) - lagrangian(p, moved(q, -h), v)) / (2 * h)
            forces.append(float((momentum(*later) - momentum(*earlier)) / (2 * h) - slope))
        return np.array(forces)


@pytest.mark.parametrize("n", SIZES)
def test_dynamics_equal_lagranges_equations_of_the_energies(n: int) -> None:
    """M q̈ + C q̇ + g is what differences of the Lagrangian give, joints included."""
    for seed in range(2):
        crane, q, v = random_crane(n, seed)
        a = np.random.default_rng(seed + 7).normal(0, 1, 2 * n + 1)
        computed = chain.mass_matrix(crane, q) @ a + chain.bias(crane, q, v)
        assert relative_difference(computed, forces_by_differences(crane, q, v, a)) < EXACT


@pytest.mark.parametrize("n", SIZES)
def test_entries_of_the_report(n: int) -> None:
    """Entries (19)-(63) and gravity (83)-(84) are right as printed, for any number of links."""
    crane, q, _ = random_crane(n, 3)
    bare = LumpedCrane(crane.trolley, crane.masses)
    assert relative_difference(entries.mass_matrix(bare, q), chain.mass_matrix(bare, q)) < EXACT
    assert relative_difference(entries.gravity(bare, q), chain.potential_force(bare, q)) < EXACT


def test_closed_forms() -> None:
    """The matrix (138)-(142) and the equations (194) are right as printed."""
    crane, q, _ = random_crane(2, 1)
    assert (
        relative_difference(closed.mass_matrix_two(crane, q), chain.mass_matrix(crane, q)) < EXACT
    )
    crane, q, v = random_crane(1, 1)
    bare, a = LumpedCrane(crane.trolley, crane.masses), np.array([0.3, -1.1, 0.8])
    expected = chain.mass_matrix(bare, q) @ a + chain.bias(bare, q, v)
    # forces of up to 100 N
    assert np.max(np.abs(closed.forces_one(bare, q, v, a) - expected)) < EXACT * 100.0


@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_properties_of_the_matrices(n: int, seed: int) -> None:
    """M is symmetric and positive definite, Ṁ - 2C skew-symmetric.

    That holds everywhere, and C is that of Christoffel's symbols.
    """
    crane, q, v = random_crane(n, seed)
    mass = chain.mass_matrix(crane, q)
    assert properties.asymmetry(mass) < EXACT
    assert properties.smallest_eigenvalue(mass) > 0.0
    assert (
        properties.skewness_error(properties.mass_rate(crane, q, v), chain.coriolis(crane, q, v))
        < EXACT
    )
    assert (
        relative_difference(properties.christoffel(crane, q) @ v, chain.coriolis(crane, q, v))
        < EXACT
    )
    assert chain.kinetic_energy(crane, q, v) == pytest.approx(0.5 * v @ mass @ v, rel=EXACT)


@pytest.mark.parametrize("hoisted", [False, True], ids=["rigid", "hoisted"])
def test_accelerations_agree_with_the_simulator(hoisted: bool) -> None:
    """The simulator's tension form and this dense form give the same motion.

    Angles are made relative first.
    """
    crane = LumpedCrane(5.0, np.array([1.0, 2.0, 5.0]))
    _, q, v = example(3)
    v[5:] = 0.0
    hoist = {"hoist": {"drive": "force", "inertia": 2.0}} if hoisted else {}
    v[4] *= hoisted
    document = {
        "crane": "overhead",
        "duration": 1.0,
        "trolley": {"drive": "force", "mass": crane.trolley},
        "cable": {"lengths": list(q[4:]), "node_masses": list(crane.masses)},
        "initial": {"angles": [0.0, 0.0, 0.0]},
    }
    at, rates = ([x[0], *x[4 : 4 + hoisted], *coordinates.absolute(x[1:4])] for x in (q, v))
    accelerations = crane_sim.acceleration(document | hoist, at, rates, [7.0, -80.0][: 1 + hoisted])
    drawn = accelerations[1] if hoisted else 0.0
    a = np.concatenate(
        [accelerations[:1], coordinates.relative(accelerations[1 + hoisted :]), [drawn, 0.0, 0.0]]
    )
    # the drum takes its share of the hoist's
    forces = np.array([7.0, 0.0, 0.0, 0.0, -80.0 - 2.0 * drawn, 0.0, 0.0])
    computed = chain.chain_acceleration(crane, q, v, forces, (1,) if hoisted else ())
    # the dense matrix loses its condition number, some 1e3
    assert relative_difference(computed, a) < 1e-11


@pytest.mark.parametrize("erratum", ERRATA, ids=lambda erratum: erratum.where.replace(" ", "_"))
def test_errata(erratum: Erratum) -> None:
    """Printed misprints differ from first principles, and the corrected forms do not."""
    assert relative_difference(erratum.printed, erratum.truth) > 1e-3
    assert relative_difference(erratum.corrected, erratum.truth) < erratum.tolerance
