"""Integrators: coefficients, measured order, error control, stiffness and long horizons."""

from math import cos, nan, pi, sin
from typing import Any, NamedTuple

import numpy as np
import pytest

from crane_sim import system
from crane_sim.integrators import (
    Status,
    dense_output,
    dop853,
    dopri5,
    integrate_to,
    rk4,
    scratch,
    start,
    step,
)
from crane_sim.integrators.dop853 import DOP853, RK8
from crane_sim.integrators.dopri5 import DOPRI5
from crane_sim.integrators.gauss import Gauss
from crane_sim.integrators.gauss16 import Gauss16
from crane_sim.integrators.rk4 import RK4
from crane_sim.numerics.jit import entry_point


class Oscillator(NamedTuple):
    """x'' = -x + f sin(2 t), whose solution is known; f makes the equation depend on time."""

    f: float


class Decay(NamedTuple):
    """x' = rate x: stiff for a large negative rate."""

    rate: float


class FiniteTimeBlowUp(NamedTuple):
    """x' = x^2, infinite at t = 1 from x = 1."""

    unused: float = 0.0


@system.rhs.register(Oscillator)
def _oscillator_rhs(p, t, x, u):
    return x[1], -x[0] + p.f * sin(2.0 * t)


@system.rhs.register(Decay)
def _decay_rhs(p, t, x, u):
    return (p.rate * x[0],)


@system.rhs.register(FiniteTimeBlowUp)
def _finite_time_blow_up_rhs(p, t, x, u):
    return (x[0] * x[0],)


def exact(t: float, f: float) -> tuple[float, float]:
    """Return the oscillator's solution from x = 1, x' = 0."""
    b = 2.0 * f / 3.0
    return cos(t) + b * sin(t) - f / 3.0 * sin(2.0 * t), -sin(t) + b * cos(t) - 2.0 * f / 3.0 * cos(
        2.0 * t
    )


@entry_point
def integrate(method, p, x, end):
    """Return the integration from (0, x) to `end`."""
    return integrate_to(method, p, (), start(p, 0.0, x, None), end, end)


@entry_point
def one_step(method, p, x, t, h):
    """Return one step of size h."""
    return step(method, p, t, x, (), h, scratch(x, p))


@entry_point
def look_back(method, p, x, end, t):
    """Return (state at a time within the last step, integration)."""
    integration = integrate_to(method, p, (), start(p, 0.0, x, None), end, 1e9)
    return dense_output(method, p, (), integration, t), integration


def dense(rows: Any, n: int) -> np.ndarray:
    """Return tableau rows with zeros for None, as a lower triangular (n, n) matrix."""
    a = np.zeros((n, n))
    for i, row in enumerate(rows, start=1):
        a[i, : len(row)] = [0.0 if x is None else x for x in row]
    return a


@pytest.mark.parametrize(
    ("tableau", "order"), [(rk4, 4), (dop853, 8), (dopri5, 5)], ids=["rk4", "dop853", "dopri5"]
)
def test_coefficients_satisfy_the_order_conditions(tableau: Any, order: int) -> None:
    """Weights integrate polynomials up to the order, and rows sum to their nodes.

    The order conditions of tall trees hold.
    """
    n = len(tableau.B)
    a, c = dense(tableau.A, n), np.array([0.0, *tableau.C])
    b = np.array([0.0 if x is None else x for x in tableau.B])
    # the published digits carry 1e-16, magnified by entries up to 40
    assert np.allclose(a.sum(axis=1), c, rtol=0, atol=1e-13)
    for k in range(1, order + 1):
        assert b @ c ** (k - 1) == pytest.approx(1.0 / k, abs=1e-14)
    tall, factorial = np.ones(n), 1.0
    for k in range(1, order + 1):
        factorial *= k
        assert b @ tall == pytest.approx(1.0 / factorial, abs=1e-13)
        tall = a @ tall


@pytest.mark.parametrize(
    "weights", [dop853.E5, dop853.E3, dopri5.E], ids=["order 5", "order 3", "dopri5"]
)
def test_error_weights_cancel_on_a_constant(weights: Any) -> None:
    """Error estimates are zero where all slopes are equal: differences of two quadratures."""
    assert sum(x for x in weights if x is not None) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize(
    ("method", "order", "sizes"),
    [(RK4, 4, (0.1, 0.05)), (RK8, 8, (0.25, 0.125)), (Gauss, 6, (0.25, 0.125))],
    ids=["rk4", "rk8", "gauss"],
)
def test_measured_order(method: Any, order: int, sizes: tuple[float, float]) -> None:
    """Halving the step of a time-dependent problem divides the error by 2 to the order."""
    p, end = Oscillator(0.7), 10.0
    errors = [
        np.linalg.norm(np.subtract(integrate(method(h), p, (1.0, 0.0), end).x, exact(end, p.f)))
        for h in sizes
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_a_fixed_step_fills_the_way_evenly() -> None:
    """A step that does not divide the period is shortened, and the end is met exactly."""
    integration = integrate(RK4(0.3), Oscillator(0.0), (1.0, 0.0), 1.0)
    assert (integration.t, integration.steps, integration.evaluations) == (1.0, 4, 16)


@pytest.mark.parametrize("method", [DOP853, DOPRI5])
@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-10])
def test_adaptive_error_follows_the_tolerance(method: Any, rtol: float) -> None:
    """The global error stays within a small multiple of the specified tolerance."""
    integration = integrate(method(rtol, rtol), Oscillator(0.7), (1.0, 0.0), 20.0)
    # local errors add up over about 20 time units; error per step is controlled, and the estimate
    # is cautious
    assert np.max(np.abs(np.subtract(integration.x, exact(20.0, 0.7)))) < 20.0 * rtol
    assert integration.status == Status.OK


def test_evaluations_are_counted() -> None:
    """An accepted step costs 12 evaluations, a rejected one 11 more, the first step's size 1."""
    integration = integrate(DOP853(1e-8, 1e-8), Oscillator(0.7), (1.0, 0.0), 20.0)
    assert integration.evaluations == 12 * integration.steps + 11 * integration.rejected + 1


def test_a_stiff_problem_is_slow_but_right() -> None:
    """Error control keeps an explicit method stable on a fast decay."""
    integration = integrate(DOP853(1e-6, 1e-9), Decay(-1e4), (1.0,), 1.0)
    # the stability bound of the method on the negative axis is about 6: at least 1e4 / 6 steps
    assert (
        integration.status == Status.OK
        and abs(integration.x[0]) < 1e-6
        and integration.steps + integration.rejected > 1000
    )


def test_long_horizon() -> None:
    """An oscillator's energy drifts by less than rounding over 100 000 steps of order 8."""
    integration = integrate(
        RK8(2.0 * pi / 60.0), Oscillator(0.0), (1.0, 0.0), 100_000 * 2.0 * pi / 60.0
    )
    # order 8 at h = 0.1 loses h^8 1e-7 a step at worst; 1e5 roundings of 1e-16 add up to 1e-11 at
    # most
    assert integration.x[0] ** 2 + integration.x[1] ** 2 == pytest.approx(1.0, abs=1e-10)


def test_reading_between_steps_changes_nothing() -> None:
    """A state read within a step is as accurate as the steps, and the integration unchanged."""
    p, method = Oscillator(0.7), DOP853(1e-10, 1e-12)
    x, integration = look_back(method, p, (1.0, 0.0), 9.0, 9.0)
    assert integration.t > 9.0  # steps follow the solution, not the instants of reading
    assert np.allclose(x, exact(9.0, p.f), rtol=0, atol=2e-9)
    assert look_back(method, p, (1.0, 0.0), 9.0, integration.t)[0] == integration.x


@pytest.mark.parametrize(
    "method", [DOP853(1e-8, 1e-8), RK4(0.01), Gauss16()], ids=["dop853", "rk4", "gauss16"]
)
def test_a_solution_that_ends_is_reported(method: Any) -> None:
    """Integration across a singularity stops near it with a status."""
    integration = integrate(method, FiniteTimeBlowUp(), (1.0,), 2.0)
    assert integration.status != Status.OK and integration.t < 1.5


@pytest.mark.parametrize(
    "method",
    [RK4(0.1), RK8(0.1), DOP853(1e-9, 1e-12), DOPRI5(), Gauss(0.1), Gauss16()],
    ids=lambda m: type(m).__name__,
)
def test_rest_stays_rest(method: Any) -> None:
    """Every method leaves a state at rest exactly where it is."""
    assert one_step(method, Decay(0.0), (2.0,), 0.0, 0.1) == (2.0,)


class Broken(NamedTuple):
    """x' = 1 until t = 0.5, not a number from then on."""

    unused: float = 0.0


@system.rhs.register(Broken)
def _broken_rhs(p, t, x, u):
    return (1.0 if t < 0.5 else nan,)


def test_an_adaptive_step_is_no_good_when_it_is_not_a_number() -> None:
    """Derivatives that turn into NaN in mid-run stop the adaptive method where they do."""
    integration = integrate(DOP853(1e-9, 1e-12), Broken(), (0.0,), 1.0)
    assert (
        integration.status == Status.NOT_FINITE
        and integration.t <= 0.5
        and integration.x[0] == pytest.approx(integration.t)
    )
