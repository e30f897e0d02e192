"""Steps up to an instant: one by one, or of an array state in one piece without allocations."""

import numpy as np

from crane_sim.integrators.events import StepEnds, handle_events, may_switch
from crane_sim.integrators.integration import status_of, with_step
from crane_sim.integrators.leapfrog import Leapfrog
from crane_sim.integrators.status import NOT_FINITE, OK, TOO_MANY_STEPS
from crane_sim.integrators.step_control import (
    adaptive_step,
    advance,
    controls_error,
    equal_step,
    max_steps,
)
from crane_sim.numerics.jit import routine
from crane_sim.system import project_in_place, switching


def integrate_to(method, p, u, integration, t, end):
    """Return the integration advanced until it covers time t [s]; no step passes `end` [s].

    A step of a model that switches ends at its first event.
    """
    switches = switching(p)
    if not isinstance(integration.x, np.ndarray) or (
        isinstance(method, Leapfrog) and switches is not None
    ):
        return take_single_steps(switches, method, p, u, integration, t, end)
    if switches is None:
        return advance_array(method, p, u, integration, t, end)
    return advance_to_events(method, switches, p, u, integration, t, end)


def take_single_steps(switches, method, p, u, integration, t, end):
    """Return the result of `integrate_to`, step by step.

    `switches` is None for a model that does not switch.
    """
    limit = integration.steps + max_steps(method)
    while integration.t < t and integration.status == OK:
        integration = handle_events(switches, method, p, u, advance(method, p, u, integration, end))
        if integration.steps >= limit and integration.t < t and integration.status == OK:
            integration = integration._replace(status=TOO_MANY_STEPS)
    return integration


def step_into(method, scratch, p, t, x, u, h, end, out):
    """Write the state one accepted step after (t, x) into `out`.

    Returns:
        (time after the step, size to try next, evaluations, steps rejected, status)
    """
    if controls_error(method):
        _, t, h, n, rejected, status = adaptive_step(method, scratch, p, t, x, u, h, end, out)
        if status == OK:
            project_in_place(p, out)
        return t, h, n, rejected, status
    size, after = equal_step(method.step, t, end)
    if isinstance(method, Leapfrog):  # the size of the step before tells whether there is one
        n, overflows = method.continue_step(p, t, x, u, size, scratch, h == 0.0, out)
        status = OK if overflows == 0 else NOT_FINITE
        return after, 0.0 if after == end else size, n, 0, status
    _, n = method.take_step(p, t, x, u, size, scratch, out)
    project_in_place(p, out)
    return after, size, n, 0, status_of(out)


@routine
def fill_steps(method, scratch, switches, p, t, u, h, until, end, limit, before, x):
    """Advance the state x from time t to a step that covers `until`.

    The state moves to and fro between the arrays x and `before`.

    At most `limit` steps are taken. The last one is that in which a guard may fail, if there is
    one.

    Returns:
        (time before the last step, time, size to try next, evaluations, steps, steps rejected,
        status, whether the state is in `before`, and the state before it in x; whether a guard may
        fail in the last step)
    """
    start, evaluations, steps, rejected, status, swapped, fails = t, 0, 0, 0, OK, False, False
    while t < until and status == OK and not fails:
        start, x, before, swapped = t, before, x, not swapped
        t, h, n, failed, status = step_into(method, scratch, p, t, before, u, h, end, x)
        evaluations, rejected = evaluations + n, rejected + failed
        if status == OK or t > start:
            steps += 1
        if status == OK:
            fails, n = may_switch(switches, method, scratch, p, u, StepEnds(start, before, t, x))
            evaluations += 0 if fails else n  # what handles the event evaluates them again
        if status == OK and steps >= limit and t < until and not fails:
            status = TOO_MANY_STEPS
    return start, t, h, evaluations, steps, rejected, status, swapped, fails


@routine
def advance_array(method, p, u, integration, t, end):
    """Return the integration advanced as by `fill_steps`, of a model that does not switch."""
    return advance_smoothly(None, method, p, u, integration, t, end, max_steps(method))[0]


@routine
def advance_to_events(method, switches, p, u, integration, t, end):
    """Return the integration advanced until it covers time t [s], with the events on the way."""
    limit = integration.steps + max_steps(method)
    while integration.t < t and integration.status == OK:
        integration, fails = advance_smoothly(
            switches, method, p, u, integration, t, end, limit - integration.steps
        )
        if fails:
            integration = handle_events(switches, method, p, u, integration)
        if integration.steps >= limit and integration.t < t and integration.status == OK:
            integration = integration._replace(status=TOO_MANY_STEPS)
    return integration


def advance_smoothly(switches, method, p, u, integration, t, end, limit):
    """Return (the integration advanced as by `fill_steps`, whether its last step may switch).

    It may switch where a guard may fail.
    """
    if integration.t >= t or integration.status != OK:
        return integration, False
    before, x = np.empty_like(integration.x), integration.x.copy()
    start, now, h, evaluations, steps, rejected, status, swapped, fails = fill_steps(
        method,
        integration.scratch,
        switches,
        p,
        integration.t,
        u,
        integration.h,
        t,
        end,
        limit,
        before,
        x,
    )
    if swapped:
        x, before = before, x
    last_step = integration._replace(t=start, x=before)
    return with_step(last_step, now, x, h, evaluations, steps, rejected, status), fails
