"""Events of traced equations: their instants, switches, ends of runs, and the bits of plain Python."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from crane_sim import system
from crane_sim.integrators import integrate_to, make_event_log, start
from crane_sim.integrators.dop853 import DOP853
from crane_sim.solvers.dop853 import ROWS, trace_step
from crane_sim.solvers.events import (
    BUFFERS,
    CHATTERING,
    EVENTS,
    GUARD,
    INTEGRATE_SWITCHING,
    RECORD,
    SAMPLES,
    TERMINATED,
    integrate_switching,
)
from crane_sim.solvers.step_control import EVALUATIONS, OK, SIZE, STATUS, STEPS, TIME
from crane_sim.tracing.function import Function, trace
from crane_sim.tracing.graph import Kind
from crane_sim.tracing.machine_code import Library
from crane_sim.tracing.operations import maximum, minimum, select

DERIVATIVE = Kind.ARRAY, Kind.REAL, Kind.ARRAY, Kind.ARRAY, Kind.ARRAY
RESET = Kind.ARRAY, Kind.REAL, Kind.ARRAY, Kind.ARRAY, Kind.REAL, Kind.ARRAY
CAPACITY, N = 10, 2
GRAVITY, BOUNCE, CEILING = range(3)  # parameters: m/s², of velocity at the floor, m


def fall(p: Any, t: Any, x: Any, u: Any, out: Any) -> tuple[()]:
    """A ball in the air."""
    out[0], out[1] = x[1], u[0] - p[GRAVITY]
    return ()


def guard(p: Any, t: Any, x: Any, u: Any, out: Any) -> tuple[()]:
    """Guard 0 fails below the floor on the way down, guard 1 above the ceiling."""
    floor, ceiling = maximum(x[0], x[1]), p[CEILING] - x[0]
    out[0], out[1], out[2] = minimum(floor, ceiling), select(ceiling < floor, 1.0, 0.0), 0.0
    return ()


def reset(p: Any, t: Any, x: Any, u: Any, number: Any, out: Any) -> tuple[()]:
    """Return from the floor upwards; the ceiling ends the run. Events are numbered from 10."""
    x[1] = select(number == 0.0, -p[BOUNCE] * x[1], x[1])
    out[0], out[1] = 10.0 + number, select(number == 0.0, 1.0, 0.0)
    return ()


class Run(NamedTuple):
    """Where an integration ends."""

    x: np.ndarray
    record: np.ndarray
    events: np.ndarray  # rows (time, number)


@cache
def library() -> tuple[tuple[Function, ...], Library, Library]:
    """Return the functions of the ball, and they and the driver compiled."""
    derivative, look, switch = trace(fall, DERIVATIVE), trace(guard, DERIVATIVE), trace(reset, RESET)
    functions = derivative, trace_step(derivative, N), look, switch
    return functions, Library(*functions), Library(INTEGRATE_SWITCHING)


def run(start: tuple[float, float], ends: tuple[float, ...], p: tuple[float, ...], compiled: bool = True) -> Run:
    """Integrate a ball to some instants."""
    functions, scene, driver = library()
    rows, buffers, out, log = np.zeros(ROWS * N), np.zeros(BUFFERS * N), np.zeros(3), np.zeros(2 * CAPACITY)
    parameters, u, x, record = np.array(p), np.zeros(1), np.array(start), np.zeros(RECORD)
    record[GUARD] = -1.0
    for end in ends:
        arrays = (rows, buffers, out, log), (x, record)
        if compiled:
            addresses = (scene.address(function) for function in functions)
            (first, second), pointers = arrays, [a.ctypes.data for a in (parameters, u)]
            driver.function(INTEGRATE_SWITCHING)(
                *addresses, N, *pointers, 1e-9, 1e-12, *(a.ctypes.data for a in first), CAPACITY,
                *(a.ctypes.data for a in second), end
            )  # fmt: skip
        else:
            integrate_switching(
                *(f.python for f in functions), N, parameters, u, 1e-9, 1e-12, *arrays[0], CAPACITY, *arrays[1], end
            )
    return Run(x, record, log.reshape(CAPACITY, 2)[: int(min(record[EVENTS], CAPACITY))])


def test_a_ball_bounces_when_it_reaches_the_floor() -> None:
    """Six bounces come at the instants of the closed form, to 1e-12 s; the state between is a parabola's."""
    p = (10.0, 0.5, 100.0)
    result = run((5.0, 0.0), (2.95,), p)
    instants = [1.0, 2.0, 2.5, 2.75, 2.875, 2.9375]
    np.testing.assert_allclose(result.events, [[t, 10.0] for t in instants], atol=1e-12)
    assert result.record[STATUS] == OK
    half = run((5.0, 0.0), (2.2,), p)
    np.testing.assert_allclose(half.x, [2.5 * 0.2 - 5.0 * 0.2**2, 2.5 - 10.0 * 0.2], atol=1e-12)


def test_a_guard_can_end_a_run() -> None:
    """The ceiling ends the run there, with its guard's number; no later instant moves the state."""
    result = run((0.0, 10.0), (0.9, 5.0), (10.0, 0.5, 4.8))
    reached = 1.0 - np.sqrt(1.0 - 2.0 * 4.8 / 10.0)
    assert result.record[STATUS] == TERMINATED and result.record[GUARD] == 1.0
    assert result.record[TIME] == pytest.approx(reached, abs=1e-14)
    assert result.events.tolist() == [[result.record[TIME], 11.0]]


@pytest.mark.parametrize("above", [0.51, 0.0])
def test_a_short_stay_beyond_a_guard_is_found(above: float) -> None:
    """A guard that is negative for just over 1 / SAMPLES of a step, and not at its ends, ends the run on time.

    One that is only touched, by 1e-12 m, does not.
    """
    step, top = 2.0, 1.1
    half = above * step / SAMPLES
    ceiling = 0.5 * top**2 - 0.5 * half**2 + (0.0 if above else 1e-12)
    record = np.zeros(RECORD)
    record[SIZE] = step
    result = run_one_step((0.0, top), step, (1.0, 0.0, ceiling), record)
    assert (result.record[STATUS] == TERMINATED) == (above > 0.0)
    assert result.record[TIME] == pytest.approx(top - half if above else step, abs=1e-13)


def run_one_step(start: tuple[float, float], step_size: float, p: tuple[float, ...], record: np.ndarray) -> Run:
    """Integrate over one step of this size, in plain Python."""
    functions = [function.python for function in library()[0]]
    rows, buffers, out, log = np.zeros(ROWS * N), np.zeros(BUFFERS * N), np.zeros(3), np.zeros(2 * CAPACITY)
    x, parameters, u = np.array(start), np.array(p), np.zeros(1)
    arrays = (rows, buffers, out, log)
    tolerances = 1e-3, 1e-3  # the method is exact for a parabola: its step is as long as it is told
    integrate_switching(*functions, N, parameters, u, *tolerances, *arrays, CAPACITY, x, record,
                        step_size)  # fmt: skip
    return Run(x, record, log.reshape(CAPACITY, 2))


def test_chattering_ends_with_a_status() -> None:
    """A switch that leaves its guard failing ends the run after a bounded number of switches, which are counted."""
    result = run((-1.0, -1.0), (1.0,), (10.0, -1.0, 100.0))
    assert result.record[STATUS] == CHATTERING and result.record[TIME] == 0.0
    assert result.record[EVENTS] == 51.0 and len(result.events) == CAPACITY


class Ball(NamedTuple):
    """The ball as a model."""

    gravity: float
    bounce: float
    ceiling: float


@system.rhs.register(Ball)
def _(p, t, x, u):
    return x[1], -p.gravity


@system.switching.register(Ball)
def _(p):
    return system.Switching()


@system.guard.register(Ball)
def _(p, t, x, u, work):
    floor, ceiling = max(x[0], x[1]), p.ceiling - x[0]
    return min(floor, ceiling), int(ceiling < floor), 0


@system.apply_reset_map.register(Ball)
def _(p, t, x, u, number):
    return (x[0], -p.bounce * x[1] if number == 0 else x[1]), 10 + number, number == 0


@pytest.mark.interpreted
def test_events_have_the_bits_of_the_models_integrator() -> None:
    """Instants, state, size of the next step and counts are those of `integrators.integrate_to`."""
    p, ends = Ball(9.81, 0.6, 6.0), (0.2, 1.7, 2.6)
    integration = start(p, 0.0, (4.0, -0.3), make_event_log(system.switching(p)))
    for end in ends:
        integration = integrate_to(DOP853(1e-9, 1e-12), p, (), integration, end, end)
    ours = run((4.0, -0.3), ends, tuple(p), compiled=False)
    log = integration.event_log
    assert ours.events.tolist() == log.rows[: log.total].tolist() and log.total >= 2
    assert ours.x.tolist() == list(integration.x)
    assert ours.record[[TIME, SIZE, STEPS]].tolist() == [integration.t, integration.h, integration.steps]


def test_compiled_events_have_the_bits_of_python() -> None:
    """Instants, states, counts and the log are those of the same functions on Python's floats."""
    arguments = (4.0, -0.3), (0.2, 1.7, 2.6), (9.81, 0.6, 6.0)
    ours, python = run(*arguments), run(*arguments, compiled=False)
    assert ours.x.tobytes() == python.x.tobytes() and ours.record.tobytes() == python.record.tobytes()
    assert ours.events.tobytes() == python.events.tobytes() and ours.record[EVENTS] >= 2
    assert ours.record[EVALUATIONS] > 12 * ours.record[STEPS]
