"""Gauss collocation of order 16: its coefficients, order, stages, events, and automatic choice."""

from math import cos, sin
from typing import Any, NamedTuple

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.integrators import Status, gauss16, integrate_to, scratch, start, step
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.gauss16 import Gauss16
from crane_sim.numerics.jit import entry_point
from crane_sim.simulation.rollout import simulate
from crane_sim.simulation.status import SimulationError

FORCE = 0.7
START = (1.0, 0.0, 0.0, 1.0)


class Oscillators(NamedTuple):
    """x'' = -x + f sin(2 t) and y'' = -y: state (x, y, x', y')."""

    f: float


class Paired(NamedTuple):
    """The same, where the equations say which entries are rates."""

    f: float


class InArray(NamedTuple):
    """The same with an array as state."""

    f: float


@system.rhs.register(Oscillators)
@system.rhs.register(Paired)
def _oscillators_rhs(p, t, x, u):
    return x[2], x[3], -x[0] + p.f * sin(2.0 * t), -x[1]


@system.rate_entries.register(Paired)
def _paired_rate_entries(p):
    return ((0, 2),)


@system.rhs_into.register(InArray)
def _in_array_rhs_into(p, t, x, u, out, work):
    out[0], out[1], out[2], out[3] = x[2], x[3], -x[0] + p.f * sin(2.0 * t), -x[1]


def exact(t: float, f: float) -> np.ndarray:
    """Return the solution from START."""
    b = 2.0 * f / 3.0
    x, v = (
        cos(t) + b * sin(t) - f / 3.0 * sin(2.0 * t),
        -sin(t) + b * cos(t) - 2.0 * f / 3.0 * cos(2.0 * t),
    )
    return np.array([x, sin(t), v, cos(t)])


@entry_point
def equal_steps(method, p, x, h, count):
    """Return the state after `count` steps of size h from (0, x)."""
    work = scratch(x, p)
    for k in range(count):
        x = step(method, p, k * h, x, (), h, work)
    return x


@entry_point
def integrate(method, p, x, end):
    """Return the integration from (0, x) to `end`."""
    return integrate_to(method, p, (), start(p, 0.0, x, None), end, end)


KINDS = [(Oscillators, START), (Paired, START), (InArray, np.array(START))]


def test_coefficients_are_those_of_gauss() -> None:
    """Nodes and weights are Gauss' quadrature.

    The matrices integrate polynomials up to degree 7 once and twice.
    """
    x, w = np.polynomial.legendre.leggauss(8)
    b, c = np.array(gauss16.B), np.array(gauss16.C)
    assert b == pytest.approx(0.5 * w, abs=1e-15) and c == pytest.approx(0.5 + 0.5 * x, abs=1e-15)
    for k in range(8):
        assert gauss16.A @ c**k == pytest.approx(c ** (k + 1) / (k + 1), abs=1e-15)
        assert gauss16.A_TWICE @ c**k == pytest.approx(
            c ** (k + 2) / ((k + 1) * (k + 2)), abs=1e-15
        )
        assert gauss16.SERIES @ np.polynomial.legendre.legval(
            2.0 * c - 1.0, np.eye(8)[k]
        ) == pytest.approx(np.eye(8)[k], abs=1e-14)


ORDER_CASES = [pytest.param(*KINDS[0], id="tuple"),
               pytest.param(*KINDS[1], id="paired"),
               pytest.param(*KINDS[2], id="array")]  # fmt: skip


@pytest.mark.parametrize(("kind", "x"), ORDER_CASES)
def test_measured_order(kind: Any, x: Any) -> None:
    """Four fifths of the step divide the error by 5/4 to the 16 at least, in lanes or in rows.

    Of paired rates, whose error begins with a term that vanishes for the oscillator, by more.
    """
    method, errors = Gauss16(1e-13, 1e-13), []
    for n in (8, 10):  # without a force, whose double frequency is far from where the order shows
        errors.append(
            np.linalg.norm(
                np.subtract(equal_steps(method, kind(0.0), x, 24.0 / n, n), exact(24.0, 0.0))
            )
        )
    slope = np.log(errors[0] / errors[1]) / np.log(5.0 / 4.0)
    assert slope > 15.5 and (kind is Paired or slope < 16.5)


@pytest.mark.parametrize(("kind", "x"), [KINDS[0], KINDS[2]], ids=["tuple", "array"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-12])
def test_error_follows_the_tolerance(kind: Any, x: Any, rtol: float) -> None:
    """The global error stays within a small multiple of the tolerance; evaluations are counted."""
    integration = integrate(Gauss16(rtol, rtol), kind(FORCE), x, 20.0)
    # local errors add up over 20 s
    assert np.max(np.abs(np.array(integration.x) - exact(20.0, FORCE))) < 20.0 * rtol
    assert integration.status == Status.OK
    # a step's own k1 and whole sweeps over eight stages, whether it is accepted or not; one to
    # choose the first step
    assert (integration.evaluations - integration.steps - 1) % gauss16.STAGES == 0


def test_a_step_far_too_long_is_rejected() -> None:
    """Sweeps that do not settle make the step shorter instead of ending the integration."""
    # without x in it, an error of 0.1 of atol allows steps of a minute
    p, x = Oscillators(0.0), (1e3, 0.0, 0.0, 1e3)
    integration = integrate(Gauss16(1e-3, 1e6), p, x, 100.0)
    assert integration.status == Status.OK and integration.rejected > 0 and integration.steps > 15


def test_limits_are_met_at_the_instant_of_another_method() -> None:
    """A crane that hits a travel limit stops at the time of Dormand and Prince's method."""
    changes, ends = {"trolley.limits": [-0.5, 0.5], "trolley.mass": 1.0, "duration": 1.0}, []
    for method in (Gauss16(), DOP853()):
        with pytest.raises(SimulationError, match="reached its travel limit") as stop:
            simulate(
                crane_sim.load_scene(
                    "overhead_swing", changes | {"integrator": method_group(method)}
                )
            )
        ends.append(float(str(stop.value).split("t = ")[1].split(" s")[0]))
    assert ends[0] == ends[1] > 0.3  # to the six digits of the message


def method_group(method: Any) -> dict[str, Any]:
    """Return the group of a scene file for a method."""
    return {"method": type(method).__name__.lower(), "rtol": method.rtol, "atol": method.atol}


def test_auto_takes_it_for_tight_tolerances() -> None:
    """Method auto takes order 16 for a tight tolerance without samples and a small state."""

    def chosen(scene: str, rtol: float) -> Any:
        return crane_sim.load_scene(scene, {"integrator": {"method": "auto", "rtol": rtol}}).method

    assert chosen("overhead_swing", 1e-12) == Gauss16(1e-12, 1e-14)
    assert chosen("overhead_swing", 1e-6) == DOP853(1e-6, 1e-8)
    assert isinstance(chosen("overhead_chain", 1e-12), DOP853)  # a long state
    assert isinstance(chosen("overhead_energy", 1e-12), DOP853)  # a sampled law
