"""Event location: guards say when the equations switch; a step ends where the first one fails.

A guard is a function of time and state that stays non-negative while the present mode is valid.
Modes are part of the state (their derivative is zero), so every method integrates one mode's smooth
equations through a whole step; the part of the step beyond the event is discarded, the model
switches its state, and the integration restarts there.

Guards are sampled at equidistant instants of a step, at states interpolated between its ends.

The interpolation is Hermite's cubic. Where guards need positions and time alone, as the model
specifies (`system.Switching`), it needs only the velocities, which are in the states at both ends.
An array's derivatives there are those of the first and the last stage, of methods with a stage at
the end: it is as accurate as the cubic. So the equations are evaluated for the interpolation only
where the method has no such stage, and for states in registers.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.integrators.integration import (
    MAX_STAGES,
    NO_GUARD,
    add_evaluations,
    dense_output,
)
from crane_sim.integrators.status import OK, TERMINATED, TOO_MANY_SWITCHES
from crane_sim.integrators.step_control import advance
from crane_sim.numerics.jit import routine
from crane_sim.numerics.states import add, add_scaled, scale
from crane_sim.system import (
    EventStepControl,
    KinkStepControl,
    apply_reset_map,
    guard,
    kink_guard,
    rhs,
    rhs_into,
    switching,
)

FIRST, SECOND, BETWEEN = MAX_STAGES + 1, MAX_STAGES + 2, MAX_STAGES + 3  # rows of a scratch


GUARD_SAMPLES = 4
"""Instants of a step at which the guards are evaluated; the last one is its end."""


class StepEnds(NamedTuple):
    """A step from state x0 at time t0 [s] to state x at t."""

    t0: float
    x0: Any
    t: float
    x: Any


def hermite_slopes(scratch, method, p, u, ends, positions):
    """Return (derivatives at both ends of the last step, evaluations); of arrays as rows.

    The derivatives are all, or only those of the positions.

    These are the rows from `MAX_STAGES` + 1 on; the third one is to be filled with a state between.
    """
    if scratch is not None:
        return scratch.rows, fill_ends(method.last_stage, scratch, p, u, ends, positions)
    if positions > 0:
        return (
            constant_velocity_rates(ends.x0, positions),
            constant_velocity_rates(ends.x, positions),
        ), 0
    return (rhs(p, ends.t0, ends.x0, u), rhs(p, ends.t, ends.x, u)), 2


def fill_ends(stage, scratch, p, u, ends, positions):
    """Write the two derivatives of `hermite_slopes` into a scratch; return how many evaluations.

    `stage` is the row of the stage at the end, 0 where there is none.
    """
    rows, work = scratch.rows, scratch.work
    if positions > 0:
        for i in range(len(ends.x)):
            is_position = i < positions
            rows[FIRST, i] = ends.x0[positions + i] if is_position else 0.0
            rows[SECOND, i] = ends.x[positions + i] if is_position else 0.0
        return 0
    if stage > 0:
        rows[FIRST] = rows[0]
        rows[SECOND] = rows[stage]
        return 0
    rhs_into(p, ends.t0, ends.x0, u, rows[FIRST], work)
    rhs_into(p, ends.t, ends.x, u, rows[SECOND], work)
    return 2


def constant_velocity_rates(x, positions):
    """Return the derivative of a state whose velocities do not change.

    It is a flat tuple of `positions` positions and their velocities; or two such tuples, each half
    positions.
    """
    if not isinstance(x[0], tuple):
        return tuple(
            [x[positions + i] if i < positions else zero for i, zero in enumerate(scale(0.0, x))]
        )
    halves = [constant_velocity_rates(part, len(part) // 2) for part in x[:2]]
    return *halves, *scale(0.0, x)[2:]


def guard_within(p, u, ends, t, x, work):
    """Return the guard in state x at time t of a step, or that of a kink passed, if smaller.

    See `system.kink_guard`.
    """
    value, number, n = guard(p, t, x, u, work)
    return kink_guard(p, value, ends.t0, ends.x0, t, x), number, n


def guard_between(x, p, u, ends, slopes, s, work):
    """Return the guard at the part s of the last step to x, by cubic Hermite interpolation."""
    h = ends.t - ends.t0
    if not isinstance(x, np.ndarray):
        increment, (f0, f1) = add_scaled(x, -1.0, ends.x0), slopes
        correction = add(scale((s - 1.0) * h, f0), scale(s * h, f1))
        correction = add_scaled(correction, 1.0 - 2.0 * s, increment)
        between = add(add_scaled(ends.x0, s, increment), scale(s * (s - 1.0), correction))
        return guard_within(p, u, ends, ends.t0 + s * h, between, work)
    for i in range(len(x)):
        increment = x[i] - ends.x0[i]
        correction = (
            (s - 1.0) * h * slopes[FIRST, i]
            + s * h * slopes[SECOND, i]
            + (1.0 - 2.0 * s) * increment
        )
        slopes[BETWEEN, i] = ends.x0[i] + s * increment + s * (s - 1.0) * correction
    return guard_within(p, u, ends, ends.t0 + s * h, slopes[BETWEEN], work)


@routine
def first_sign_change(p, u, ends, slopes, work, begin):
    """Return (first sample from `begin` on whose guard is negative, evaluations).

    The sample is GUARD_SAMPLES + 1 if there is none.
    """
    n = 0
    for j in range(begin, GUARD_SAMPLES):
        value, _, more = guard_between(ends.x, p, u, ends, slopes, j / GUARD_SAMPLES, work)
        n += more
        if value < 0.0:
            return j, n
    value, _, more = guard_within(p, u, ends, ends.t, ends.x, work)
    return GUARD_SAMPLES if value < 0.0 else GUARD_SAMPLES + 1, n + more


def may_switch(switches, method, scratch, p, u, ends):
    """Return (whether a guard of an array fails at a sample of the step, evaluations).

    Before the end of the step guards are evaluated at interpolated states.

    Derivatives at the ends are written into the rows of `hermite_slopes`.
    """
    if switches is None:
        return False, 0
    n = fill_ends(method.last_stage, scratch, p, u, ends, switches.positions)
    j, more = first_sign_change(p, u, ends, scratch.rows, scratch.work, 1)
    return j <= GUARD_SAMPLES, n + more


MAX_SWITCHES = 50  # at one instant; more of them are chattering


MAX_ITERATIONS = 60  # for one event; halving alone would need about 50


class EventLog(NamedTuple):
    """Events of an integration; once the rows are full, events are only counted."""

    total: int
    rows: Any  # (capacity, 2): time [s], number of the event


def work_of(scratch):
    """Return the model's workspace, None where it needs none."""
    return None if scratch is None else scratch.work


def make_event_log(switches) -> Any:
    """Return an empty log of events; None for a model that does not switch."""
    return None if switches is None else EventLog(0, np.zeros((switches.capacity, 2)))


def apply_pending_events(switches, p, u, integration):
    """Return the integration switched by every guard that fails now, since efforts may jump."""
    return integration if switches is None else apply_reset_maps(p, u, integration)


def handle_events(switches, method, p, u, integration):
    """Return the integration cut back to the first event of its last step and switched, if any."""
    if switches is None or integration.status != OK:
        return integration
    low, high, n = bracket(method, p, u, integration)
    integration = add_evaluations(integration, n)
    return (
        integration
        if low == high
        else end_at_event(switches.step_control, method, p, u, integration, low, high)
    )


def log_event(log, t, event):
    """Return the log with one more event."""
    if log.total < len(log.rows):
        log.rows[log.total, 0], log.rows[log.total, 1] = t, event
    return EventLog(log.total + 1, log.rows)


def events_until(log, t):
    """Return the log without events after time t [s]; None for a model that does not switch."""
    if log is None:
        return None
    kept = n = min(log.total, len(log.rows))
    while n > 0 and log.rows[n - 1, 0] > t:
        n -= 1
    # those that are only counted are later than those kept
    return log if n == kept else EventLog(n, log.rows)


def restart(integration, t, x):
    """Return the integration restarted in state x at a time t [s] that it has passed.

    Events after t are discarded.

    It keeps its counters: that work was done.
    """
    log = events_until(integration.event_log, t)
    return integration._replace(
        t0=t, x0=x, t=t, x=x, h=0.0, status=OK, terminal_guard=NO_GUARD, event_log=log
    )


def with_event(integration, x, event):
    """Return the integration with an event at its present time, which puts it into state x."""
    return integration._replace(
        x=x, h=0.0, event_log=log_event(integration.event_log, integration.t, event)
    )


def terminate(integration, which):
    """Return the integration terminated by guard number `which`."""
    return integration._replace(status=TERMINATED, terminal_guard=which)


@routine
def apply_reset_maps(p, u, integration):
    """Return the integration after all switches at its present time."""
    work, switches = work_of(integration.scratch), 0
    value, which, n = guard(p, integration.t, integration.x, u, work)
    while value < 0.0 and integration.status == OK:
        x, event, continues = apply_reset_map(p, integration.t, integration.x, u, which)
        integration, switches = with_event(integration, x, event), switches + 1
        if switches > MAX_SWITCHES:
            integration = integration._replace(status=TOO_MANY_SWITCHES)
        elif not continues:
            integration = terminate(integration, which)
        value, which, more = guard(p, integration.t, integration.x, u, work)
        n += more
    return add_evaluations(integration, n)


def sample_time(integration, j):
    """Return the time of sample j of the last step."""
    return (
        integration.t
        if j == GUARD_SAMPLES
        else integration.t0 + (integration.t - integration.t0) * j / GUARD_SAMPLES
    )


def guard_at(method, p, u, integration, t, work):
    """Return (the smallest guard at time t of the last step, by dense output, evaluations)."""
    x = dense_output(method, p, u, integration, t)
    value, _, n = guard(p, t, x, u, work)
    value = kink_guard(p, value, integration.t0, integration.x0, t, x)
    return value, n if t == integration.t else n + method.stages


def bracket(method, p, u, integration):
    """Return (low, high, evaluations): the first guard fails between these times.

    They are times of the last step; equal ones say that no guard fails.

    Guards are evaluated at GUARD_SAMPLES equidistant instants, the last one the end of the step;
    before that at interpolated states, and where one is negative, again at the state of the dense
    output. So a guard that turns positive again within the step is found if it is negative at one
    of these instants, which is certain where it stays negative for 1 / GUARD_SAMPLES of the step.
    """
    work, positions = work_of(integration.scratch), switching(p).positions
    ends = StepEnds(integration.t0, integration.x0, integration.t, integration.x)
    slopes, n = hermite_slopes(integration.scratch, method, p, u, ends, positions)
    j, more = first_sign_change(p, u, ends, slopes, work, 1)
    n += more
    while j < GUARD_SAMPLES:
        value, more = guard_at(method, p, u, integration, sample_time(integration, j), work)
        n += more
        if value < 0.0:
            break
        j, more = first_sign_change(p, u, ends, slopes, work, j + 1)
        n += more
    if j > GUARD_SAMPLES:
        return integration.t, integration.t, n
    return sample_time(integration, j - 1), sample_time(integration, j), n


@routine
def find_root(method, p, u, integration, low, high):
    """Return (the first time after `low` when a guard is found to fail, evaluations).

    The root is found by false position and halving.
    """
    work = work_of(integration.scratch)
    g_low, n = guard_at(method, p, u, integration, low, work)
    g_high, more = guard_at(method, p, u, integration, high, work)
    for probe in range(2, MAX_ITERATIONS):
        n += more
        t = 0.5 * (low + high)
        if probe % 3 and g_low > 0.0:
            t = low + (high - low) * g_low / (g_low - g_high)
        if not low < t < high:
            t = 0.5 * (low + high)
        if not low < t < high:
            return high, n
        g, more = guard_at(method, p, u, integration, t, work)
        if g < 0.0:
            high, g_high, g_low = t, g, 0.5 * g_low
        else:
            low, g_low, g_high = t, g, 0.5 * g_high
    return high, n + more


@routine
def truncate_at_event(method, p, u, integration, low, high):
    """Return the integration cut back to its first event, in (`low`, `high`), and switched."""
    t, n = find_root(method, p, u, integration, low, high)
    x = dense_output(method, p, u, integration, t)
    integration = add_evaluations(integration._replace(t=t, x=x), n + method.stages)
    return apply_reset_maps(p, u, integration)


def at_begin(integration, h):
    """Return the integration at the start of its last step, to be tried again with size h."""
    return integration._replace(
        t=integration.t0, x=integration.x0, steps=integration.steps - 1, h=h
    )


def end_at_event(step_control, method, p, u, integration, low, high):
    """Return the integration that ends at its first event, in (`low`, `high`), and switched."""
    if isinstance(step_control, KinkStepControl):
        return end_at_kink_or_event(step_control.of_events, method, p, u, integration, low, high)
    if isinstance(step_control, EventStepControl):
        return repeat_step_to_event(method, p, u, integration, low, high)
    return truncate_at_event(method, p, u, integration, low, high)


@routine
def repeat_step_to_event(method, p, u, integration, low, high):
    """Return the result of `truncate_at_event`, with steps up to the event within the tolerance.

    A step that goes beyond an event can miss what the equations do just before it: its stages are
    few. One that ends there has a stage in it. Where that one is rejected, shorter ones are taken,
    and the first event of each is sought.
    """
    while low < high:
        t, n = find_root(method, p, u, integration, low, high)
        integration = add_evaluations(integration, n)
        integration = advance(method, p, u, at_begin(integration, t - integration.t0), t)
        if integration.status != OK:
            return integration
        if integration.t == t:
            return apply_reset_maps(p, u, integration)
        low, high, n = bracket(method, p, u, integration)
        integration = add_evaluations(integration, n)
    return integration


@routine
def end_at_kink_or_event(step_control, method, p, u, integration, low, high):
    """Return the integration that ends at a kink, by steps up to it, or at an event.

    An event is handled as by `end_at_event`.

    What a step finds beyond a kink is that of equations on both sides, so it is repeated; at an
    event only by choice.
    """
    t, n = find_root(method, p, u, integration, low, high)
    value, _, more = guard(
        p, t, dense_output(method, p, u, integration, t), u, work_of(integration.scratch)
    )
    integration = add_evaluations(integration, n + more + method.stages)
    if value < 0.0:  # an event
        return end_at_event(step_control, method, p, u, integration, low, high)
    return repeat_step_to_event(method, p, u, integration, low, high)
