"""Events: a step ends where the first guard fails, the state is switched there, and integration goes on.

A guard is a function guard(p, t, x, u, out) that writes the smallest guard of the state, its number and how many
evaluations of the equations it took; the mode holds while it is not negative. A reset map reset(p, t, x, u, number,
out) switches the state x and writes the number of the event to log and whether the equations go on (1 or 0).

Guards are evaluated at `SAMPLES` equidistant instants of a step, the last one its end; before that at states of
Hermite's cubic through the derivatives of the first and last stage, and where one is negative, again at the state of a
step that ends there. So a guard that turns positive again within the step is found where it stays negative for
1 / `SAMPLES` of it. The instant is found by false position and halving, of such steps.
"""

from typing import Any, NamedTuple

from crane_sim.solvers.dop853 import STAGES
from crane_sim.solvers.step_control import (
    MAX_FACTOR,
    MAX_STEPS,
    OK,
    TOO_MANY_STEPS,
    Problem,
    Trial,
    accepted_step,
    for_each,
)
from crane_sim.tracing.function import call_address, trace
from crane_sim.tracing.graph import Kind
from crane_sim.tracing.operations import branch, from_element, repeat_while, select, to_integer, to_real

SAMPLES = 4
"""Instants of a step at which guards are evaluated."""
MAX_SWITCHES = 50.0
"""Switches at one instant; more of them are chattering."""
MAX_ITERATIONS = 60.0
"""Evaluations of a guard for one event; halving alone would need about 50."""
TERMINATED, CHATTERING = 4.0, 5.0
EVENTS, GUARD = 6, 7
RECORD = 8
"""Entries of a record: those of `step_control`, number of events, number of the guard that ended the run or -1."""
BUFFERS = 3
"""Rows (BUFFERS, n) that events need: the state before a step, the derivative at its end, a state within it."""


class Switches(NamedTuple):
    """What switches: addresses of guard and reset map, and where events are logged."""

    guard: Any
    reset: Any
    log: Any  # (capacity, 2) time [s] and number of each event
    capacity: Any  # rows of the log; later events are only counted


class Step(NamedTuple):
    """The last step: from state x0 at t0 to state x at t."""

    problem: Problem
    switches: Switches
    t0: Any
    x0: Any
    t: Any
    x: Any
    rate: Any  # (n,) derivative at the end, of the last stage
    between: Any  # (n,) for states within the step
    out: Any  # (3,) for what guards write


class Probe(NamedTuple):
    """The smallest guard at one instant."""

    value: Any
    number: Any
    evaluations: Any  # that it took


class Search(NamedTuple):
    """Where in a step the first guard fails: after `low`, not after `high`; equal: in no place."""

    low: Any  # s
    high: Any  # s
    evaluations: Any


class Run(NamedTuple):
    """An integration with events under way."""

    trial: Trial  # of the last step
    steps: Any  # accepted
    events: Any
    guard: Any  # number of the guard that ended it, -1 for none
    taken: Any  # steps since the last instant that was asked for


def integrate_switching(
    derivative: Any, step: Any, guard: Any, reset: Any, n: Any, p: Any, u: Any, rtol: Any, atol: Any, rows: Any,
    buffers: Any, out: Any, log: Any, capacity: Any, x: Any, record: Any, end: Any,
) -> tuple[()]:  # fmt: skip
    """Move the state x (n,) from the record's time to `end` [s], or to an event that ends the run.

    Guards that fail at the record's time, where inputs may have jumped, switch first. An integration that has ended
    stays as it is.
    """
    problem = Problem(derivative, step, n, p, u, rtol, atol, rows)
    switches = Switches(guard, reset, log, capacity)
    t, h, evaluations, steps, rejected, status, events, number = (record[i] for i in range(RECORD))
    begun = Run(Trial(h, MAX_FACTOR, evaluations, rejected, status, t, h), steps, events, number, 0.0)

    def goes_on(run: Run) -> Any:
        return (run.trial.t < end) & (run.trial.status == OK) & (run.taken < MAX_STEPS)

    def advance(run: Run) -> Run:
        return _advance(problem, switches, buffers, out, x, run, end)

    run = repeat_while(goes_on, advance, _apply_resets(problem, switches, out, x, begun))
    trial = run.trial
    status = select((trial.t < end) & (trial.status == OK), TOO_MANY_STEPS, trial.status)
    entries = trial.t, trial.next_size, trial.evaluations, run.steps, trial.rejected, status, run.events, run.guard
    for i, entry in enumerate(entries):
        record[i] = entry
    return ()


def _advance(problem: Problem, switches: Switches, buffers: Any, out: Any, x: Any, run: Run, end: Any) -> Run:
    """Take a step, cut it back to its first event, and switch there."""
    n, t0 = problem.n, run.trial.t
    rate, between = from_element(buffers, n), from_element(buffers, 2 * n)
    for_each(n, lambda i: buffers.__setitem__(i, x[i]))
    trial = accepted_step(problem, run.trial, x, end)
    last = from_element(problem.rows, (STAGES - 1) * n)
    for_each(n, lambda i: rate.__setitem__(i, last[i]))
    taken = run._replace(trial=trial, steps=run.steps + select(trial.status == OK, 1.0, 0.0), taken=run.taken + 1.0)
    step = Step(problem, switches, t0, buffers, trial.t, x, rate, between, out)

    def cut_back() -> Run:
        search = bracket(step, trial.evaluations)
        counted = taken._replace(trial=trial._replace(evaluations=search.evaluations))
        return branch(
            search.low < search.high, lambda: _switch_at(step, find_root(step, search), taken), lambda: counted
        )

    return branch(trial.status == OK, cut_back, lambda: taken)


def _switch_at(step: Step, root: Search, run: Run) -> Run:
    """Return the run cut back to the instant of an event, and switched."""
    probe = guard_at(step, root.high)
    for_each(step.problem.n, lambda i: step.x.__setitem__(i, step.between[i]))
    trial = run.trial._replace(t=root.high, evaluations=root.evaluations + probe.evaluations)
    return _apply_resets(step.problem, step.switches, step.out, step.x, run._replace(trial=trial))


def _apply_resets(problem: Problem, switches: Switches, out: Any, x: Any, run: Run) -> Run:
    """Return the run after all switches at its present time: it then chooses the size of its next step anew."""

    def look(run: Run) -> tuple[Run, Any, Any]:
        call_address(switches.guard, (problem.p, run.trial.t, x, problem.u, out))
        trial = run.trial._replace(evaluations=run.trial.evaluations + out[2])
        return run._replace(trial=trial), out[0], out[1]

    def fails(state: Any) -> Any:
        (run, value, _), _ = state
        return (value < 0.0) & (run.trial.status == OK)

    def switch(state: Any) -> Any:
        (run, _, number), count = state
        call_address(switches.reset, (problem.p, run.trial.t, x, problem.u, number, out))
        _log(switches, run.events, run.trial.t, out[0])
        status = select(count >= MAX_SWITCHES, CHATTERING, select(out[1] == 0.0, TERMINATED, OK))
        guard = select(status == TERMINATED, number, run.guard)
        trial = run.trial._replace(next_size=0.0, status=status)
        return look(run._replace(trial=trial, events=run.events + 1.0, guard=guard)), count + 1.0

    (run, _, _), _ = repeat_while(fails, switch, (look(run), 0.0))
    return run


def _log(switches: Switches, count: Any, t: Any, event: Any) -> None:
    def write() -> tuple[()]:
        row = from_element(switches.log, 2 * to_integer(count))
        row[0], row[1] = t, event
        return ()

    branch(count < to_real(switches.capacity), write, lambda: ())


def bracket(step: Step, evaluations: Any) -> Search:
    """Return the sample instants between which a guard first fails; `evaluations`: counted so far."""
    span = step.t - step.t0

    def is_sought(state: Any) -> Any:
        j, found, _ = state
        return (found == 0.0) & (j < float(SAMPLES))

    def look(state: Any) -> Any:
        j, _, evaluations = state
        probe = interpolated_guard(step, j / SAMPLES)
        counted = evaluations + probe.evaluations

        def confirm() -> tuple[Any, Any]:
            exact = guard_at(step, step.t0 + span * j / SAMPLES)
            return select(exact.value < 0.0, 1.0, 0.0), counted + exact.evaluations

        found, counted = branch(probe.value < 0.0, confirm, lambda: (0.0, counted))
        return select(found == 1.0, j, j + 1.0), found, counted

    j, found, evaluations = repeat_while(is_sought, look, (1.0, 0.0, evaluations))
    last = evaluate_guard(step, step.t, step.x)
    nowhere = (found == 0.0) & (0.0 <= last.value)
    high = select(found == 1.0, step.t0 + span * j / SAMPLES, step.t)
    low = select(nowhere, high, step.t0 + span * (j - 1.0) / SAMPLES)
    return Search(low, high, evaluations + last.evaluations)


def find_root(step: Step, search: Search) -> Search:
    """Return the search narrowed down until no number is between: false position, every third time halving."""
    low, high = guard_at(step, search.low), guard_at(step, search.high)
    evaluations = search.evaluations + low.evaluations + high.evaluations

    def is_open(state: Any) -> Any:
        search, _, _, count = state
        middle = 0.5 * (search.low + search.high)
        return (count < MAX_ITERATIONS) & (search.low < middle) & (middle < search.high)

    def narrow(state: Any) -> Any:
        search, g_low, g_high, count = state
        t = _probe_time(search, g_low, g_high, count)
        probe = guard_at(step, t)
        evaluations = search.evaluations + probe.evaluations
        before = Search(search.low, t, evaluations), 0.5 * g_low, probe.value, count + 1.0
        after = Search(t, search.high, evaluations), probe.value, 0.5 * g_high, count + 1.0
        return select(probe.value < 0.0, before, after)

    return repeat_while(is_open, narrow, (search._replace(evaluations=evaluations), low.value, high.value, 2.0))[0]


def _probe_time(search: Search, g_low: Any, g_high: Any, count: Any) -> Any:
    """Return the instant to look at next, strictly within the search."""
    middle = 0.5 * (search.low + search.high)
    is_third = count == 3.0 * to_real(to_integer(count / 3.0))

    def interpolate() -> Any:
        t = search.low + (search.high - search.low) * g_low / (g_low - g_high)
        return select((search.low < t) & (t < search.high), t, middle)

    def by_value() -> Any:
        return branch(0.0 < g_low, interpolate, lambda: middle)

    return branch(is_third, lambda: middle, by_value)


def evaluate_guard(step: Step, t: Any, x: Any) -> Probe:
    """Return the smallest guard of state x at time t."""
    call_address(step.switches.guard, (step.problem.p, t, x, step.problem.u, step.out))
    return Probe(step.out[0], step.out[1], step.out[2])


def interpolated_guard(step: Step, part: Any) -> Probe:
    """Return the guard at a part of the step, of Hermite's cubic."""
    rows, h = step.problem.rows, step.t - step.t0

    def interpolate(i: Any) -> None:
        increment = step.x[i] - step.x0[i]
        correction = (part - 1.0) * h * rows[i] + part * h * step.rate[i] + (1.0 - 2.0 * part) * increment
        step.between[i] = step.x0[i] + part * increment + part * (part - 1.0) * correction

    for_each(step.problem.n, interpolate)
    return evaluate_guard(step, step.t0 + part * h, step.between)


def guard_at(step: Step, t: Any) -> Probe:
    """Return the guard at time t of the step, at the state of a step that ends there, which `between` then has."""
    problem = step.problem
    arguments = problem.p, step.t0, step.x0, problem.u, t - step.t0, step.between
    call_address(problem.step, (*arguments, problem.rtol, problem.atol, problem.rows), (Kind.REAL,))
    probe = evaluate_guard(step, t, step.between)
    return probe._replace(evaluations=probe.evaluations + (STAGES - 1.0))


INTEGRATE_SWITCHING = trace(
    integrate_switching,
    (
        *(Kind.FUNCTION, Kind.FUNCTION, Kind.FUNCTION, Kind.FUNCTION, Kind.INTEGER, Kind.ARRAY, Kind.ARRAY),
        *(Kind.REAL, Kind.REAL, Kind.ARRAY, Kind.ARRAY, Kind.ARRAY, Kind.ARRAY, Kind.INTEGER),
        *(Kind.ARRAY, Kind.ARRAY, Kind.REAL),
    ),
)
