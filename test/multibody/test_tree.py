"""Supports as trees of joints against Lagrange's equations, d'Alembert, Pinocchio, energy."""

from typing import Any, NamedTuple

import mpmath as mp
import numpy as np
import pytest
from random_trees import RandomStructure, random_state, random_tree, vector
from tree_lagrange import GRAVITY, MovingBase, lagrange_efforts, reaction

from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.support import (
    Posture,
    Support,
    SupportState,
    compute_posture,
    tip_acceleration,
)
from crane_sim.models.supports.support_dynamics import (
    Dynamics,
    accelerations,
    base_efforts,
    base_reaction,
    compute_dynamics,
    constraint_effort,
    kinetic_energy,
    net_efforts,
    responses,
    tip_efforts,
)
from crane_sim.multibody import linear
from crane_sim.multibody.tree import Point, Tree, Z, point_velocity, to_base_axes

DRY = Friction(1.0, 2.0)


class Solved(NamedTuple):
    """A support in motion."""

    posture: Posture
    dynamics: Dynamics
    net: tuple[float, ...]
    accelerations: tuple[float, ...]


def support_of(tree: Tree, motors: Any) -> Support:
    """Return a support that is this tree."""
    return Support(RandomStructure(tree), tuple(motors))


def solve(support: Support, q: Any, v: Any, tau: Any, base: Any = None) -> Solved:
    """Return the support in a state under efforts tau; joints with friction stick."""
    held = sum(1 for part in support.frictions or () if part is not None)
    posture = compute_posture(support, SupportState(tuple(q), tuple(v), (), (0.0,) * held))
    dynamics = compute_dynamics(support, posture)
    net = net_efforts(dynamics, GRAVITY, linear.add(tuple(tau), base_efforts(posture, base)))
    return Solved(posture, dynamics, net, accelerations(dynamics, net, ()))


def full(matrix: Any) -> np.ndarray:
    """Return a symmetric matrix from its lower triangle."""
    n = len(matrix)
    lower = np.array([[*row, *[0.0] * (n - len(row))] for row in matrix], dtype=float)
    return np.tril(lower) + np.tril(lower, -1).T


def motors_of(rng: np.random.Generator, n: int) -> tuple[float, ...]:
    """Return reflected inertias of n motors."""
    return tuple(rng.uniform(0.0, 0.3, n).tolist())


def random_base(rng: np.random.Generator) -> MovingBase:
    """Return a base with a speed and an acceleration in all six directions."""
    return MovingBase(
        (vector(rng), vector(rng), vector(rng)), (vector(rng), vector(rng), vector(rng))
    )


def slewing_tree(rng: np.random.Generator, n: int) -> Tree:
    """Return a random tree whose first joint slews.

    So components are along axes that it turns.
    """
    tree = random_tree(rng, n)
    first = tree.joints[0]._replace(axis=Z, slides=False, reverse=False, offset=(0.0, 0.0, 0.7))
    others = [joint._replace(parent=max(joint.parent, 0)) for joint in tree.joints[1:]]
    return tree._replace(joints=(first, *others))


@pytest.mark.parametrize(("seed", "make"), [(1, random_tree), (2, random_tree), (3, slewing_tree)])
def test_equations_and_reaction_equal_lagranges(seed: int, make: Any) -> None:
    """On a base that moves in all directions, efforts and reaction follow from positions.

    They agree to 1e-12 of their size.

    The accelerations of those efforts come out of Lagrange's equations again; force and moment on
    the base balance what moves the bodies (d'Alembert).
    """
    rng = np.random.default_rng(seed)
    tree, motors = make(rng, 4), motors_of(rng, 4)
    q, v, tau = random_state(rng, 4)
    with mp.workdps(60):
        base = random_base(rng)
        motion = base.motion()
        solved = solve(support_of(tree, motors), q, v, tau, motion)
        a = solved.accelerations
        size = max(map(abs, solved.net)) + abs(full(solved.dynamics.matrix)).max()
        np.testing.assert_allclose(
            lagrange_efforts(tree, base, q, v, a, motors), tau, atol=1e-12 * size
        )
        force, moment = reaction(tree, base, q, v, a)
        wrench = base_reaction(solved.posture, solved.dynamics, GRAVITY, motion, a)
    for ours, exact in ((wrench.force, force), (wrench.moment, moment)):
        expected = np.array([float(x) for x in exact])
        got = np.array(to_base_axes(solved.posture.kinematics.turn, ours))
        np.testing.assert_allclose(got, expected, atol=1e-12 * max(abs(expected)))


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8, 12])
def test_random_trees_equal_pinocchios(n: int) -> None:
    """Mass matrix, bias and accelerations of 20 random trees are Pinocchio's.

    They agree to 1e-12 of their size.
    """
    pinocchio = pytest.importorskip("pinocchio")
    from tree_pinocchio import to_pinocchio

    rng = np.random.default_rng(n)
    for _ in range(20):
        tree, motors, (q, v, tau) = random_tree(rng, n), motors_of(rng, n), random_state(rng, n)
        model = to_pinocchio(tree)
        data = model.createData()
        solved = solve(support_of(tree, motors), q, v, tau)
        exact = pinocchio.crba(model, data, np.array(q))
        exact = np.triu(exact) + np.triu(exact, 1).T + np.diag(motors)
        np.testing.assert_allclose(
            full(solved.dynamics.matrix), exact, atol=1e-12 * abs(exact).max()
        )
        bias = pinocchio.nonLinearEffects(model, data, np.array(q), np.array(v))
        np.testing.assert_allclose(
            np.subtract(tau, solved.net), bias, atol=1e-12 * (1.0 + abs(bias).max())
        )
        expected = np.linalg.solve(exact, np.array(tau) - bias)
        tolerance = 1e-12 * np.linalg.cond(exact) * (1.0 + abs(expected).max())
        np.testing.assert_allclose(solved.accelerations, expected, atol=tolerance)


@pytest.mark.parametrize("make", [random_tree, slewing_tree])
def test_the_tips_force_velocity_and_acceleration_belong_together(make: Any) -> None:
    """A force's power is that of its joint efforts, mobility the answer to it.

    Acceleration is the velocity's change.
    """
    rng = np.random.default_rng(11)
    support = support_of(make(rng, 5), motors_of(rng, 5))
    q, v, tau = (np.array(x) for x in random_state(rng, 5))
    force, solved = vector(rng), solve(support, q, v, tau)
    levers = tip_efforts(solved.posture, force)
    assert np.dot(levers, v) == pytest.approx(
        np.dot(force, solved.posture.tip_velocity), rel=1e-13, abs=1e-13
    )
    pulled = solve(support, q, v, tau + levers)
    with_force, without = (
        np.array(tip_acceleration(each.posture, each.accelerations)) for each in (pulled, solved)
    )
    answer = np.dot(with_force - without, to_base_axes(solved.posture.kinematics.turn, force))
    ours = linear.inner(levers, responses(solved.dynamics, levers))
    assert ours == pytest.approx(answer, rel=1e-11)
    a = np.array(solved.accelerations)

    def velocity_at(t: float) -> np.ndarray:
        posture = solve(support, q + t * v + 0.5 * t * t * a, v + t * a, tau).posture
        return np.array(to_base_axes(posture.kinematics.turn, posture.tip_velocity))

    h = 1e-5  # central differences of order 2: an error of 1e-10, beside the rounding of 1e-11
    expected = (velocity_at(h) - velocity_at(-h)) / (2.0 * h)
    np.testing.assert_allclose(without, expected, rtol=1e-8, atol=1e-8)


def test_a_joint_that_sticks_leaves_the_equations() -> None:
    """With a joint that sticks the others move as with it welded; its reaction holds it."""
    rng = np.random.default_rng(5)
    support, (q, v, tau) = support_of(random_tree(rng, 4), motors_of(rng, 4)), random_state(rng, 4)
    v = tuple(0.0 if i == 2 else x for i, x in enumerate(v))
    held = solve(support._replace(frictions=(None, None, DRY, None)), q, v, tau)
    assert held.accelerations[2] == 0.0
    motors = support.motors or ()
    # it hardly moves: by 1e-14 of the others
    welded = support._replace(motors=(*motors[:2], 1e14, motors[3]))
    expected = solve(welded, q, v, tau).accelerations
    np.testing.assert_allclose(
        held.accelerations, expected, atol=1e-11 * max(map(abs, held.accelerations))
    )
    effort = constraint_effort(held.dynamics, held.net, held.accelerations, 2)
    freed = solve(support, q, v, np.array(tau) - effort * np.eye(4)[2]).accelerations
    np.testing.assert_allclose(freed, held.accelerations, atol=1e-12 * max(map(abs, freed)))


def test_power_of_gravity_and_efforts_is_the_change_of_kinetic_energy() -> None:
    """Along its own accelerations kinetic energy changes by the power of efforts and gravity.

    There is no integrator.
    """
    rng = np.random.default_rng(9)
    tree, (q, v, tau) = random_tree(rng, 6), random_state(rng, 6)
    support = support_of(tree, motors_of(rng, 6))
    solved = solve(support, q, v, tau)
    a = np.array(solved.accelerations)

    def kinetic(t: float) -> float:
        place = np.array(q) + t * np.array(v) + 0.5 * t * t * a
        moved = solve(support, place, np.array(v) + t * a, tau)
        return kinetic_energy(moved.posture, moved.dynamics)

    # four-point differences of order 4: an error of 1e-13 of the energy's fifth derivative
    h = 1e-4
    rate = (8.0 * (kinetic(h) - kinetic(-h)) - (kinetic(2 * h) - kinetic(-2 * h))) / (12.0 * h)
    weight = sum(
        body.mass * GRAVITY * point_velocity(solved.posture.kinematics, Point(i, body.centre))[2]
        for i, joint in enumerate(tree.joints)
        for body in joint.bodies
    )
    assert rate == pytest.approx(np.dot(tau, v) - weight, rel=1e-8)
