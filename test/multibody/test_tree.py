"""The tree of joints and bodies against Lagrange's equations, d'Alembert's balance, Pinocchio, and its own energy."""

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from random_trees import random_state, random_tree, vector
from tree_lagrange import MovingBase, lagrange_efforts, reaction

from crane_sim.multibody.tree import (
    BaseMotion,
    Point,
    Tree,
    Z,
    accelerations,
    base_reaction,
    compute_dynamics,
    efforts_of,
    point_acceleration,
    point_mobility,
    point_velocity,
)

REST = BaseMotion((0.0, 0.0, 9.81))


def random_base(rng: np.random.Generator) -> MovingBase:
    """Return a base with a speed and an acceleration in all six directions."""
    return MovingBase((vector(rng), vector(rng), vector(rng)), (vector(rng), vector(rng), vector(rng)))


def slewing_tree(rng: np.random.Generator, n: int) -> Tree:
    """Return a random tree whose first joint slews, so that components are along axes that it turns."""
    tree = random_tree(rng, n)
    first = tree.joints[0]._replace(axis=Z, slides=False, reverse=False, offset=(0.0, 0.0, 0.7))
    others = [joint._replace(parent=max(joint.parent, 0)) for joint in tree.joints[1:]]
    return tree._replace(joints=(first, *others))


def turned(a: Any, turn: tuple[float, float]) -> np.ndarray:
    """Return a vector of the components' axes in those of the base."""
    s, c = turn
    return np.array([c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]])


@pytest.mark.parametrize(("seed", "make"), [(1, random_tree), (2, random_tree), (3, slewing_tree)])
def test_equations_and_reaction_equal_lagranges(seed: int, make: Any) -> None:
    """On a base that moves in all directions, efforts and reaction are those of positions, to 1e-12 of their size.

    The accelerations of those efforts come out of Lagrange's equations again; force and moment on the base balance
    what moves the bodies (d'Alembert).
    """
    rng = np.random.default_rng(seed)
    tree = make(rng, 4)
    q, v, tau = random_state(rng, 4)
    with mp.workdps(60):
        base = random_base(rng)
        dynamics = compute_dynamics(tree, q, v, base.motion())
        a = accelerations(dynamics, tau)
        np.testing.assert_allclose(lagrange_efforts(tree, base, q, v, a), tau, atol=1e-12 * scale_of(dynamics))
        force, moment = reaction(tree, base, q, v, a)
        wrench = base_reaction(dynamics, a)
    for ours, exact in ((wrench.force, force), (wrench.moment, moment)):
        expected = np.array([float(x) for x in exact])
        np.testing.assert_allclose(turned(ours, dynamics.turn), expected, atol=1e-12 * max(abs(expected)))


def scale_of(dynamics: Any) -> float:
    """Return the size of the terms that cancel in an effort."""
    return max(map(abs, dynamics.bias_efforts)) + max(abs(x) for row in dynamics.mass_matrix for x in row)


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8, 12])
def test_random_trees_equal_pinocchios(n: int) -> None:
    """Mass matrix, bias and accelerations of 20 random trees are Pinocchio's, to 1e-12 of their size."""
    pinocchio = pytest.importorskip("pinocchio")
    from tree_pinocchio import to_pinocchio

    rng = np.random.default_rng(n)
    for _ in range(20):
        tree, (q, v, tau) = random_tree(rng, n), random_state(rng, n)
        model, armature = to_pinocchio(tree)
        data = model.createData()
        dynamics = compute_dynamics(tree, q, v, REST)
        matrix = np.array([[*row, *[0.0] * (n - len(row))] for row in dynamics.mass_matrix])
        matrix = np.tril(matrix) + np.tril(matrix, -1).T
        exact = pinocchio.crba(model, data, np.array(q))
        exact = np.triu(exact) + np.triu(exact, 1).T + np.diag(armature)
        np.testing.assert_allclose(matrix, exact, atol=1e-12 * abs(exact).max())
        bias = pinocchio.nonLinearEffects(model, data, np.array(q), np.array(v))
        np.testing.assert_allclose(dynamics.bias_efforts, bias, atol=1e-12 * (1.0 + abs(bias).max()))
        expected = np.linalg.solve(exact, np.array(tau) - bias)
        tolerance = 1e-12 * np.linalg.cond(exact) * (1.0 + abs(expected).max())
        np.testing.assert_allclose(accelerations(dynamics, tau), expected, atol=tolerance)


@pytest.mark.parametrize("make", [random_tree, slewing_tree])
def test_a_points_force_velocity_and_acceleration_belong_together(make: Any) -> None:
    """A force's power is that of its joint efforts, mobility the answer to it, acceleration the velocity's change."""
    rng = np.random.default_rng(11)
    tree = make(rng, 5)
    q, v, tau = (np.array(x) for x in random_state(rng, 5))
    force = vector(rng)
    dynamics = compute_dynamics(tree, tuple(q), tuple(v), REST)
    levers = efforts_of(tree, dynamics, tree.tip, force)
    velocity = point_velocity(dynamics, tree.tip)
    assert np.dot(levers, v) == pytest.approx(np.dot(force, velocity), rel=1e-13, abs=1e-13)
    a = np.array(accelerations(dynamics, tuple(tau)))
    pulled = np.array(accelerations(dynamics, tuple(tau + levers)))
    with_force, without = (point_acceleration(tree, dynamics, tree.tip, tuple(x)) for x in (pulled, a))
    answer = np.dot(np.subtract(with_force, without), force)
    assert point_mobility(tree, dynamics, tree.tip, force) == pytest.approx(answer, rel=1e-11)

    def velocity_at(t: float) -> np.ndarray:
        moved = compute_dynamics(tree, tuple(q + t * v + 0.5 * t * t * a), tuple(v + t * a), REST)
        return turned(point_velocity(moved, tree.tip), moved.turn)

    h = 1e-5  # central differences of order 2: an error of 1e-10, beside the rounding of 1e-11
    expected = (velocity_at(h) - velocity_at(-h)) / (2.0 * h) + np.array([0.0, 0.0, 9.81])
    np.testing.assert_allclose(turned(without, dynamics.turn), expected, rtol=1e-8, atol=1e-8)


def test_a_joint_that_sticks_leaves_the_equations() -> None:
    """With a joint that sticks the others move as in the tree with that joint welded; its reaction holds it."""
    rng = np.random.default_rng(5)
    tree, (q, v, tau) = random_tree(rng, 4), random_state(rng, 4)
    v = tuple(0.0 if i == 2 else x for i, x in enumerate(v))
    free = (True, True, False, True)
    dynamics = compute_dynamics(tree, q, v, REST, free)
    a = accelerations(dynamics, tau, free)
    assert a[2] == 0.0
    heavy = tree.joints[2]._replace(rotor=1e14)  # a motor so heavy that it hardly moves: by 1e-14 of the others
    welded = tree._replace(joints=(*tree.joints[:2], heavy, tree.joints[3]))
    expected = accelerations(compute_dynamics(welded, q, v, REST), tau)
    np.testing.assert_allclose(a, expected, atol=1e-11 * max(map(abs, a)))


def test_power_of_gravity_and_efforts_is_the_change_of_kinetic_energy() -> None:
    """Along its own accelerations, kinetic energy changes by the power of efforts and gravity; no integrator."""
    rng = np.random.default_rng(9)
    tree, (q, v, tau) = random_tree(rng, 6), random_state(rng, 6)
    dynamics = compute_dynamics(tree, q, v, REST)
    a = np.array(accelerations(dynamics, tau))

    def kinetic(t: float) -> float:
        rates = np.array(v) + t * a
        moved = compute_dynamics(tree, tuple(np.array(q) + t * np.array(v) + 0.5 * t * t * a), tuple(rates), REST)
        matrix = [[*row, *[0.0] * (6 - len(row))] for row in moved.mass_matrix]
        matrix = np.tril(matrix) + np.tril(matrix, -1).T
        return 0.5 * rates @ matrix @ rates

    h = 1e-4  # four-point differences of order 4: an error of 1e-13 of the energy's fifth derivative
    rate = (8.0 * (kinetic(h) - kinetic(-h)) - (kinetic(2 * h) - kinetic(-2 * h))) / (12.0 * h)
    weight = sum(
        body.mass * 9.81 * vertical_speed(tree, i, body.centre, dynamics)
        for i, joint in enumerate(tree.joints)
        for body in joint.bodies
    )
    assert rate == pytest.approx(np.dot(tau, v) - weight, rel=1e-8)


def vertical_speed(tree: Tree, i: int, offset: Any, dynamics: Any) -> float:
    """Return the vertical velocity of a point of link i."""
    return point_velocity(dynamics, Point(i, offset))[2]
