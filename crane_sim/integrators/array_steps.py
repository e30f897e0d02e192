"""Steps of an array state up to an instant, or to one in which a guard may fail: in one piece, between two buffers.

What `integrate_to` does step by step, without an allocation at each of them.
"""

import numpy as np

from crane_sim.integrators.dop853 import DOP853, RK8
from crane_sim.integrators.dopri5 import DOPRI5
from crane_sim.integrators.events import StepEnds, handle_events, may_switch
from crane_sim.integrators.integration import (
    Integration,
    advance,
    equal_step,
    explicit_step,
    max_steps,
    stages,
    status_of,
)
from crane_sim.integrators.rk4 import RK4
from crane_sim.integrators.rodas import Rodas
from crane_sim.integrators.status import OK, TOO_MANY_STEPS
from crane_sim.integrators.step_control import adaptive_step
from crane_sim.numerics.jit import generic, routine
from crane_sim.numerics.states import replace_field
from crane_sim.system import project_in_place


def take_single_steps(switches, method, p, u, integration, t, end):
    """Return the result of `integrate_to`, step by step; `switches` is None for a model that does not switch."""
    limit = integration.steps + max_steps(method)
    while integration.t < t and integration.status == OK:
        integration = handle_events(switches, method, p, u, advance(method, p, u, integration, end))
        if integration.steps >= limit and integration.t < t and integration.status == OK:
            integration = replace_field(integration, "status", TOO_MANY_STEPS)
    return integration


@generic
def take_switching_steps(x, switches, method, p, u, integration, t, end):
    """Return the result of `integrate_to` for a model that switches, from its state x."""
    return take_single_steps(switches, method, p, u, integration, t, end)


@take_switching_steps.register(np.ndarray)
def _(x, switches, method, p, u, integration, t, end):
    return take_array_steps_to_events(method, switches, p, u, integration, t, end)


@generic
def take_array_steps_to_events(method, switches, p, u, integration, t, end):
    """Return the result of `take_switching_steps` of an array; see `take_array_steps`."""
    return take_single_steps(switches, method, p, u, integration, t, end)


@generic
def take_smooth_steps(x, method, p, u, integration, t, end):
    """Return the result of `integrate_to` for a model that does not switch, from its state x."""
    return take_single_steps(None, method, p, u, integration, t, end)


@take_smooth_steps.register(np.ndarray)
def _(x, method, p, u, integration, t, end):
    return take_array_steps(method, p, u, integration, t, end)


@generic
def take_array_steps(method, p, u, integration, t, end):
    """Return the result of `take_smooth_steps` of an array; a method that answers `step_into` registers here, too."""
    return take_single_steps(None, method, p, u, integration, t, end)


@generic
def step_into(method, scratch, p, t, x, u, h, end, out):
    """Write the state one accepted step after (t, x) into `out`, of a method with error control.

    Returns:
        (time after the step, size to try next, evaluations, steps rejected, status)
    """
    _, t, h, n, rejected, status = adaptive_step(method, scratch, p, t, x, u, h, end, out)
    if status == OK:
        project_in_place(p, out)
    return t, h, n, rejected, status


@step_into.register(RK4)
@step_into.register(RK8)
def _(method, scratch, p, t, x, u, h, end, out):
    h, after = equal_step(method.step, t, end)
    explicit_step(method, p, t, x, u, h, scratch, out)
    project_in_place(p, out)
    return after, h, stages(method), 0, status_of(out)


@routine
def fill_steps(method, scratch, switches, p, t, u, h, until, end, limit, before, x):
    """Advance the state x from time t to a step that covers `until`, to and fro between the arrays x and `before`.

    At most `limit` steps are taken. The last one is that in which a guard may fail, if there is one.

    Returns:
        (time before the last step, time, size to try next, evaluations, steps, steps rejected, status, whether the
        state is in `before`, and the state before it in x; whether a guard may fail in the last step)
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


@take_array_steps.register(RK4)
@take_array_steps.register(RK8)
@take_array_steps.register(DOP853)
@take_array_steps.register(DOPRI5)
@take_array_steps.register(Rodas)
def _(method, p, u, integration, t, end):
    return advance_array(method, p, u, integration, t, end)


@routine
def advance_array(method, p, u, integration, t, end):
    """Return the integration advanced as by `fill_steps`, of a model that does not switch."""
    return advance_smoothly(None, method, p, u, integration, t, end, max_steps(method))[0]


@take_array_steps_to_events.register(RK4)
@take_array_steps_to_events.register(RK8)
@take_array_steps_to_events.register(DOP853)
@take_array_steps_to_events.register(DOPRI5)
@take_array_steps_to_events.register(Rodas)
def _(method, switches, p, u, integration, t, end):
    return advance_to_events(method, switches, p, u, integration, t, end)


@routine
def advance_to_events(method, switches, p, u, integration, t, end):
    """Return the integration advanced until it covers time t [s], with the events on the way."""
    limit = integration.steps + max_steps(method)
    while integration.t < t and integration.status == OK:
        integration, fails = advance_smoothly(switches, method, p, u, integration, t, end, limit - integration.steps)
        if fails:
            integration = handle_events(switches, method, p, u, integration)
        if integration.steps >= limit and integration.t < t and integration.status == OK:
            integration = replace_field(integration, "status", TOO_MANY_STEPS)
    return integration


def advance_smoothly(switches, method, p, u, integration, t, end, limit):
    """Return (the integration advanced as by `fill_steps`, whether a guard may fail in its last step)."""
    if integration.t >= t or integration.status != OK:
        return integration, False
    before, x = np.empty_like(integration.x), integration.x.copy()
    start, now, h, evaluations, steps, rejected, status, swapped, fails = fill_steps(
        method, integration.scratch, switches, p, integration.t, u, integration.h, t, end, limit, before, x
    )
    if swapped:
        x, before = before, x
    return Integration(
        start,
        before,
        now,
        x,
        h,
        integration.evaluations + evaluations,
        integration.steps + steps,
        integration.rejected + rejected,
        status,
        integration.terminal_guard,
        integration.event_log,
        integration.scratch,
    ), fails
