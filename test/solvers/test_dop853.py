"""The traced method of order 8 and its step control: order, tolerance, failures, and the bits of plain Python."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from crane_sim import system
from crane_sim.integrators import integrate_to, start
from crane_sim.integrators.dop853 import DOP853
from crane_sim.solvers.dop853 import ROWS, trace_step
from crane_sim.solvers.step_control import (
    EVALUATIONS,
    INTEGRATE,
    NOT_FINITE,
    OK,
    RECORD,
    REJECTED,
    STATUS,
    STEP_TOO_SMALL,
    STEPS,
    TIME,
    integrate,
)
from crane_sim.tracing.elementary import sincos
from crane_sim.tracing.function import trace
from crane_sim.tracing.graph import Kind
from crane_sim.tracing.machine_code import Library
from crane_sim.tracing.operations import power

KINDS = Kind.ARRAY, Kind.REAL, Kind.ARRAY, Kind.ARRAY, Kind.ARRAY


def pendulum(p: Any, t: Any, x: Any, u: Any, out: Any) -> tuple[()]:
    """A pendulum of the frequency p[0] [rad/s] under an acceleration u[0] [rad/s²]."""
    out[0] = x[1]
    out[1] = u[0] - p[0] * p[0] * sincos(x[0])[0]
    return ()


def oscillator(p: Any, t: Any, x: Any, u: Any, out: Any) -> tuple[()]:
    """An oscillator of the frequency 1 rad/s."""
    out[0], out[1] = x[1], -x[0]
    return ()


def blow_up(p: Any, t: Any, x: Any, u: Any, out: Any) -> tuple[()]:
    """X' = x², infinite at t = 1 from x = 1; x1' = p0 x1^(1/2), not a number once x1 is negative."""
    out[0], out[1] = x[0] * x[0], p[0] * power(x[1], 0.5)
    return ()


class Run(NamedTuple):
    """An integration's end."""

    x: np.ndarray
    record: np.ndarray


def run(equations: Any, x0: tuple[float, ...], ends: tuple[float, ...], tolerance: float, compiled: bool) -> Run:
    """Integrate to some instants, one after the other."""
    n, derivative = len(x0), trace(equations, KINDS, "derivative")
    step = trace_step(derivative, n)
    p, u, x, record, rows = np.array([1.3]), np.array([0.2]), np.array(x0), np.zeros(RECORD), np.zeros(ROWS * n)
    scene, driver = Library(derivative, step), Library(INTEGRATE).function(INTEGRATE)
    for end in ends:
        if compiled:
            functions = scene.address(derivative), scene.address(step)
            driver(*functions, n, *(a.ctypes.data for a in (p, u)), tolerance, 1e-3 * tolerance,
                   *(a.ctypes.data for a in (rows, x, record)), end)  # fmt: skip
        else:
            integrate(equations, step.python, n, p, u, tolerance, 1e-3 * tolerance, rows, x, record, end)
    return Run(x, record)


def test_compiled_integration_has_the_bits_of_python() -> None:
    """Steps, errors, sizes and counts: the machine code does what the same functions do on Python's floats."""
    ends = (0.01, 0.5, 0.5, 3.0)
    ours, python = (run(pendulum, (1.0, -0.4), ends, 1e-9, compiled) for compiled in (True, False))
    assert ours.x.tobytes() == python.x.tobytes()
    assert ours.record.tobytes() == python.record.tobytes()
    assert ours.record[TIME] == 3.0 and ours.record[STEPS] > 3


def test_a_step_is_of_order_eight() -> None:
    """The error of one step falls with h⁹: by 2⁹ within 4 % where h is halved."""
    step = trace_step(trace(oscillator, KINDS, "derivative"), 2)
    errors = []
    for h in (0.8, 0.4):
        x, y, rows = np.array([1.0, 0.0]), np.zeros(2), np.zeros(ROWS * 2)
        oscillator(None, 0.0, x, None, rows)
        step.python(None, 0.0, x, None, h, y, 1e-9, 1e-9, rows)
        errors.append(np.hypot(y[0] - np.cos(h), y[1] + np.sin(h)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(9.0, abs=0.06)


class Oscillator(NamedTuple):
    """The same equations as `oscillator`, as a model."""


@system.rhs.register(Oscillator)
def _(p, t, x, u):
    return x[1], -x[0]


@pytest.mark.interpreted
def test_it_takes_the_steps_of_the_models_integrator() -> None:
    """State, sizes and counts have the bits of `integrators.integrate_to` on the same equations, instant by instant."""
    ends, tolerance = (0.03, 0.5, 4.0), 1e-9
    method, integration = DOP853(tolerance, 1e-3 * tolerance), start(Oscillator(), 0.0, (1.0, -0.4), None)
    for k, end in enumerate(ends, 1):
        integration = integrate_to(method, Oscillator(), (), integration, end, end)
        ours = run(oscillator, (1.0, -0.4), ends[:k], tolerance, False)
        assert ours.x.tolist() == list(integration.x)
        counts = integration.evaluations, integration.steps, integration.rejected
        assert ours.record.tolist() == [integration.t, integration.h, *counts, OK]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_the_error_stays_near_the_tolerance(tolerance: float) -> None:
    """After ten periods the error is within 100 tolerances: each of some hundred steps adds at most about one."""
    t = 20.0 * np.pi
    result = run(oscillator, (1.0, 0.0), (t,), tolerance, True)
    assert result.record[STATUS] == OK
    assert np.hypot(result.x[0] - 1.0, result.x[1]) < 100.0 * tolerance
    assert result.record[EVALUATIONS] == 2.0 + result.record[STEPS] * 12.0 + result.record[REJECTED] * 11.0 - 1.0


@pytest.mark.parametrize("compiled", [True, False], ids=["compiled", "python"])
def test_a_solution_that_ends_is_reported(compiled: bool) -> None:
    """Steps that shrink to nothing, and equations that are no number, end with a status; the state is finite."""
    result = run(blow_up, (1.0, 1.0), (2.0,), 1e-9, compiled)
    assert result.record[STATUS] == STEP_TOO_SMALL and 0.99 < result.record[TIME] < 1.01 and np.isfinite(result.x).all()
    result = run(blow_up, (0.0, -1.0), (2.0,), 1e-9, compiled)
    assert result.record[STATUS] == NOT_FINITE and result.record[TIME] == 0.0
    assert result.x.tolist() == [0.0, -1.0]
