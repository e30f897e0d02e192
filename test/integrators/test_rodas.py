"""The Rosenbrock method: its coefficients, order, stiffness, and the linear systems behind it."""

from functools import cache
from itertools import product
from math import sin
from typing import Any, NamedTuple

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.integrators import Status, dense_output, integrate_to, rodas, scratch, start, step
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.rodas import Rodas
from crane_sim.integrators.runge_kutta import to_dense_tableau
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.linear_systems import (
    add_band_product,
    factor_band,
    factor_dense,
    solve_band,
    solve_dense,
)


class Pendulum(NamedTuple):
    """x'' = -sin x + f sin(2 t), and a third component that relaxes towards sin(2 t) at a rate."""

    f: float
    rate: float


@system.rhs_into.register(Pendulum)
def _pendulum_rhs_into(p, t, x, u, out, work):
    out[0], out[1], out[2] = (
        x[1],
        p.f * sin(2.0 * t) - sin(x[0]),
        p.rate * (sin(2.0 * t) - x[2]) + x[0] * x[2],
    )


X0 = np.array([1.0, 0.0, 0.0])


@entry_point
def steps(method, p, x, n, h):
    """Return the state after n steps of size h from t = 0."""
    for i in range(n):
        x = step(method, p, i * h, x, (), h, scratch(x, p))
    return x


@entry_point
def integrate(method, p, x, end):
    """Return the integration from (0, x) to `end`, and the state in the middle of its last step."""
    integration = integrate_to(method, p, (), start(p, 0.0, x, None), end, end)
    return integration, dense_output(
        method, p, (), integration, 0.5 * (integration.t0 + integration.t)
    )


Tree = tuple[Any, ...]


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """Return the rooted trees of an order, each as the sorted tuple of its branches."""
    all_trees = set()
    for sizes in partitions(order - 1, order - 1):
        all_trees |= {tuple(sorted(branches)) for branches in product(*map(trees, sizes))}
    return tuple(sorted(all_trees))


def partitions(total: int, largest: int) -> list[list[int]]:
    """Return the ways to write a total as a sum of falling parts."""
    if total == 0:
        return [[]]
    return [
        [part, *rest]
        for part in range(min(total, largest), 0, -1)
        for rest in partitions(total - part, part)
    ]


def density(tree: Tree) -> int:
    """Return the product of the orders of a tree and of all its subtrees."""
    return order_of(tree) * int(np.prod([density(branch) for branch in tree]))


def order_of(tree: Tree) -> int:
    """Return the number of nodes of a tree."""
    return 1 + sum(map(order_of, tree))


def weight(tree: Tree, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
    """Return the elementary weights of the stages.

    A single branch meets the Jacobian, several do not.
    """
    inner = beta if len(tree) == 1 else alpha
    return np.prod(
        [inner @ weight(branch, alpha, beta) for branch in tree] + [np.ones(len(alpha))], axis=0
    )


def rosenbrock_form() -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients (alpha, gamma) for stages k.

    The method's own, and its weights, are for u = gamma k.
    """
    gamma = np.linalg.inv(np.eye(rodas.STAGES) / rodas.GAMMA - to_dense_tableau(rodas.C))
    return to_dense_tableau(rodas.A) @ gamma, gamma


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_coefficients_satisfy_all_order_conditions(order: int) -> None:
    """The weights satisfy every condition up to order 5, without the last increment up to 4."""
    alpha, gamma = rosenbrock_form()
    b, last = np.array(rodas.B), np.eye(rodas.STAGES)[-1]
    residuals = [
        [
            abs(row @ gamma @ weight(tree, alpha, alpha + gamma) - 1.0 / density(tree))
            for tree in trees(order)
        ]
        for row in (b, b - last)
    ]
    assert len(trees(order)) == (1, 1, 2, 4, 9)[order - 1]
    assert max(residuals[0]) < 1e-13  # the digits given carry 1e-16, magnified by entries up to 100
    assert max(residuals[1]) < 1e-13 if order < 5 else max(residuals[1]) > 1e-3


def test_measured_order() -> None:
    """Halving the step of a nonlinear, time-dependent problem divides the error by 2^5."""
    p = Pendulum(0.7, 1.5)
    exact = integrate(DOP853(1e-13, 1e-14), p, X0, 4.0)[0].x
    errors = [np.linalg.norm(steps(Rodas(), p, X0, n, 4.0 / n) - exact) for n in (80, 160)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_adaptive_error_follows_the_tolerance(rtol: float) -> None:
    """The global error stays within a small multiple of the tolerance.

    It does so at the end and between steps.
    """
    p = Pendulum(0.7, 1.5)
    integration, middle = integrate(Rodas(rtol, rtol), p, X0, 10.0)
    for t, x in ((10.0, integration.x), (0.5 * (integration.t0 + integration.t), middle)):
        # errors per step add up over 10 time units
        assert np.max(np.abs(x - integrate(DOP853(1e-12, 1e-13), p, X0, t)[0].x)) < 20.0 * rtol
    assert integration.status == Status.OK
    assert integration.evaluations == 8 * integration.steps + 7 * integration.rejected + 1


def test_a_stiff_component_costs_nothing() -> None:
    """A rate of 1e8 changes no number of steps, and the error stays within the tolerance."""
    mild, stiff = (
        integrate(Rodas(1e-6, 1e-6), Pendulum(0.7, rate), X0, 10.0)[0] for rate in (1.5, 1e8)
    )
    assert stiff.status == Status.OK and stiff.steps < 2 * mild.steps
    # within 1e-8 of its target, errors of 1e-6 a step
    assert stiff.x[2] == pytest.approx(sin(20.0), abs=1e-5)


def test_a_fast_decay_ends_in_one_step() -> None:
    """The method is L-stable: a step much longer than a decay ends where the decay goes."""
    x = steps(Rodas(), Pendulum(0.0, 1e9), np.array([0.0, 0.0, 1.0]), 1, 0.5)
    # the stability function falls like 1 / (rate h)
    assert x[2] == pytest.approx(sin(1.0), abs=1e-7)


@entry_point
def dense_solution(a, b):
    """Overwrite b with the solution of a full system."""
    solve_dense(a, factor_dense(a), b)


@entry_point
def band_solution(a, x, b):
    """Add the band's product with x to b, then overwrite b with the banded system's solution."""
    work = np.zeros(len(b) + 6)
    add_band_product(a, x, 2.0, b, 3, work)
    factor_band(a)
    solve_band(a, b, 3, work)


def test_linear_systems() -> None:
    """Full systems with zeros on the diagonal and banded ones are solved as by a library."""
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(9, 9)), rng.normal(size=9)
    a[0, 0] = a[4, 4] = 0.0
    expected, x = np.linalg.solve(a, b), b.copy()
    dense_solution(a.copy(), x)
    assert np.allclose(x, expected, rtol=0, atol=1e-12)  # rounding times a condition of some 100
    band, full, right = np.zeros((9, 7)), np.zeros((9, 9)), rng.normal(size=9)
    for i, j in product(range(9), range(9)):
        if abs(i - j) <= 3:
            full[i, j] = band[i, 3 + j - i] = rng.normal() + 8.0 * (i == j)
    expected = np.linalg.solve(full, right + 2.0 * full @ b)
    band_solution(band, b, right)
    assert np.allclose(right, expected, rtol=0, atol=1e-13)  # diagonally dominant: rounding alone


def test_a_model_whose_state_is_no_array_is_rejected() -> None:
    """A scene of a model whose state is not an array is rejected by a single-line error."""
    with pytest.raises(crane_sim.SceneError) as caught:
        crane_sim.load_scene("knuckle_setpoint", {"integrator": {"method": "rodas"}})
    assert "integrator.method = 'rodas'" in str(caught.value) and "\n" not in str(caught.value)
