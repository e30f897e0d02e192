"""Step size control: the loop around the steps of a method with an error estimate, traced once for all equations.

It is given the addresses of a scene's functions and the size of its state. Hairer, Norsett, Wanner, "Solving Ordinary
Differential Equations I", 2nd ed., section II.4.
"""

from math import inf
from typing import Any, NamedTuple

from crane_sim.solvers.dop853 import ORDER, STAGES
from crane_sim.tracing.function import call_address, trace
from crane_sim.tracing.graph import Kind
from crane_sim.tracing.operations import (
    branch,
    from_element,
    maximum,
    minimum,
    power,
    repeat,
    repeat_while,
    select,
    sqrt,
    to_real,
)

SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 6.0
"""A step is scaled by SAFETY err^(-1/order), within these bounds."""
MAX_STEPS = 1e6
"""Limit to one instant: a diverging law needs ever shorter steps, and a run must end."""
OK, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS = 0.0, 1.0, 2.0, 3.0
TIME, SIZE, EVALUATIONS, STEPS, REJECTED, STATUS = range(6)
RECORD = 6
"""Entries of an integration's record (RECORD,): time [s], size of the next step [s] (0: it has yet to be chosen),
evaluations, accepted and rejected steps, status."""


class Problem(NamedTuple):
    """What is integrated, under inputs that are held."""

    derivative: Any  # addresses
    step: Any
    n: Any  # size of the state
    p: Any  # parameters
    u: Any  # (nu,) inputs
    rtol: Any
    atol: Any
    rows: Any  # (ROWS, n) work array


class Trial(NamedTuple):
    """A step under trial."""

    h: Any  # s, its size
    growth: Any  # largest factor of the next size
    evaluations: Any
    rejected: Any
    status: Any
    t: Any  # s, where it ends once it is accepted
    next_size: Any  # s


def integrate(
    derivative: Any, step: Any, n: Any, p: Any, u: Any, rtol: Any, atol: Any, rows: Any, x: Any, record: Any, end: Any
) -> tuple[()]:
    """Move the state x (n,) from the record's time to `end` [s], by steps that end there; see `Problem`.

    An integration that has ended by its status stays as it is.
    """
    problem = Problem(derivative, step, n, p, u, rtol, atol, rows)
    t, h, evaluations, accepted, rejected, begun = (record[i] for i in range(RECORD))
    start = Trial(h, MAX_FACTOR, evaluations, rejected, begun, t, h), accepted, 0.0

    def is_before_end(state: Any) -> Any:
        trial, _, taken = state
        return (trial.t < end) & (trial.status == OK) & (taken < MAX_STEPS)

    def advance(state: Any) -> Any:
        trial, steps, taken = state
        trial = accepted_step(problem, trial, x, end)
        return trial, steps + select(trial.status == OK, 1.0, 0.0), taken + 1.0

    trial, steps, _ = repeat_while(is_before_end, advance, start)
    status = select((trial.t < end) & (trial.status == OK), TOO_MANY_STEPS, trial.status)
    entries = trial.t, trial.next_size, trial.evaluations, steps, trial.rejected, status
    for i, entry in enumerate(entries):
        record[i] = entry
    return ()


def accepted_step(problem: Problem, before: Trial, x: Any, end: Any) -> Trial:
    """Try steps from x, smaller and smaller, until the error of one is within the tolerance; x is then its end."""
    t, n, rows = before.t, problem.n, problem.rows
    call_address(problem.derivative, (problem.p, t, x, problem.u, rows))
    y = from_element(rows, n * (STAGES + 1))
    h, first = branch(before.next_size == 0.0, lambda: _first_size(problem, t, x), lambda: (before.next_size, 1.0))
    status = select(abs(h) < inf, STEP_TOO_SMALL, NOT_FINITE)
    start = Trial(h, MAX_FACTOR, before.evaluations + first, before.rejected, status, t, h)

    def is_rejected(trial: Trial) -> Any:
        return (trial.status != OK) & (t < t + 0.1 * trial.h)

    def attempt(trial: Trial) -> Trial:
        last = end <= t + 1.000000001 * trial.h
        size = select(last, end - t, trial.h)
        arguments = problem.p, t, x, problem.u, size, y, problem.rtol, problem.atol, rows
        error = call_address(problem.step, arguments, (Kind.REAL,))
        return _judge(trial, error, size, t, end, last)

    trial = repeat_while(is_rejected, attempt, start)
    for_each(n, lambda i: x.__setitem__(i, select(trial.status == OK, y[i], x[i])))
    return trial


def _judge(trial: Trial, error: Any, size: Any, t: Any, end: Any, last: Any) -> Trial:
    """Return the trial accepted, or with a smaller step; `last`: the step was shortened to end there."""

    def limited_growth() -> Any:
        return minimum(trial.growth, maximum(MIN_FACTOR, SAFETY * power(error, -1.0 / ORDER)))

    factor = branch(0.0 < error, limited_growth, lambda: trial.growth)
    evaluations, finite = trial.evaluations + (STAGES - 1.0), error < inf
    next_size = maximum(size * factor, select(last, trial.h, 0.0))
    accepted = trial._replace(evaluations=evaluations, status=OK, t=select(last, end, t + size), next_size=next_size)
    rejected = trial._replace(
        h=size * select(finite, factor, MIN_FACTOR),
        growth=1.0,
        evaluations=evaluations,
        rejected=trial.rejected + 1.0,
        status=select(finite, STEP_TOO_SMALL, NOT_FINITE),
    )
    return select(error <= 1.0, accepted, rejected)


def _first_size(problem: Problem, t: Any, x: Any) -> tuple[Any, Any]:
    """Return (a first step that an explicit Euler step shows to be careful [s], evaluations)."""
    n, rows = problem.n, problem.rows
    euler, change = from_element(rows, n), from_element(rows, 2 * n)
    d0, d1 = _norm(problem, x, x), _norm(problem, rows, x)
    h0 = branch(minimum(d0, d1) < 1e-5, lambda: 1e-6, lambda: 0.01 * d0 / d1)
    for_each(n, lambda i: euler.__setitem__(i, x[i] + h0 * rows[i]))
    call_address(problem.derivative, (problem.p, t + h0, euler, problem.u, change))
    for_each(n, lambda i: change.__setitem__(i, change[i] - rows[i]))
    steepest = maximum(d1, _norm(problem, change, x) / h0)
    h1 = branch(steepest < 1e-15, lambda: maximum(1e-6, h0 * 1e-3), lambda: power(0.01 / steepest, 1.0 / ORDER))
    return minimum(100.0 * h0, h1), 2.0


def _norm(problem: Problem, a: Any, x: Any) -> Any:
    """Return the root mean square of a (n,) relative to the tolerance at x."""

    def add(i: Any, total: Any) -> Any:
        ratio = a[i] / (problem.atol + problem.rtol * abs(x[i]))
        return total + ratio * ratio

    return sqrt(repeat(problem.n, add, 0.0) / to_real(problem.n))


def for_each(n: Any, action: Any) -> None:
    """Carry out an action on the indices 0 .. n - 1."""

    def do(i: Any, state: Any) -> Any:
        action(i)
        return state

    repeat(n, do, ())


INTEGRATE = trace(
    integrate,
    (
        *(Kind.FUNCTION, Kind.FUNCTION, Kind.INTEGER, Kind.ARRAY, Kind.ARRAY),
        *(Kind.REAL, Kind.REAL, Kind.ARRAY, Kind.ARRAY, Kind.ARRAY, Kind.REAL),
    ),
)
