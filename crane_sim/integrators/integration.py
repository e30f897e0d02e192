"""State of an integration, and the generic functions that a method answers."""

from math import ceil, inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from crane_sim.integrators.status import NOT_FINITE, OK
from crane_sim.numerics.jit import generic, routine, simd_range
from crane_sim.numerics.states import replace_field, squared_error_norm
from crane_sim.system import project, workspace

MAX_STAGES = 12


class Scratch(NamedTuple):
    """Work arrays of steps of an array state (n,), allocated once for a run, undefined between steps."""

    rows: Any  # (MAX_STAGES + 5, n): of the stages, the state at a stage, three that `events` needs, one of `leapfrog`
    work: Any  # the model's workspace


@generic
def scratch(x, p):
    """Return the work arrays for steps of a state like x: None where x is a tuple."""
    return None


@scratch.register(np.ndarray)
def _(x, p):
    return Scratch(np.empty((MAX_STAGES + 5, len(x))), workspace(p))


NO_GUARD = -1


class Integration(NamedTuple):
    """An integration under way: the solution is x at t, a step after x0 at t0.

    The counters are fields of their own: to Python, a tuple of them would cost a tenth of `Plant.advance`.
    """

    t0: float
    x0: Any
    t: float
    x: Any
    h: float  # s, size that an adaptive method tries next; 0: it has yet to choose
    evaluations: int = 0  # of the right-hand side
    steps: int = 0  # accepted
    rejected: int = 0  # steps
    status: int = OK  # of Status
    terminal_guard: int = NO_GUARD  # index of the guard that terminated it
    event_log: Any = None  # of a model that switches
    scratch: Any = None


def start(p, t, x, event_log):
    """Return the integration of model p that begins with state x at time t, with an empty log of events."""
    return Integration(t, x, t, x, 0.0, 0, 0, 0, OK, NO_GUARD, event_log, scratch(x, p))


def with_step(integration, t, x, h, evaluations, steps, rejected, status):
    """Return the integration one step further, at (t, x), with more work counted; h is the size of the next step."""
    return Integration(
        integration.t,
        integration.x,
        t,
        x,
        h,
        integration.evaluations + evaluations,
        integration.steps + steps,
        integration.rejected + rejected,
        status,
        integration.terminal_guard,
        integration.event_log,
        integration.scratch,
    )


def add_evaluations(integration, evaluations):
    """Return the integration with more evaluations counted."""
    return replace_field(integration, "evaluations", integration.evaluations + evaluations)


def status_of(x):
    """Return the status of an integration in state x."""
    return OK if is_finite(x) else NOT_FINITE


@generic
def is_finite(x):
    """Return whether every number of the state, squared, is finite."""
    return isfinite(squared_error_norm(x, x, x, 0.0, 1.0))


@is_finite.register(np.ndarray)
def _(x):
    overflows = 0  # counted, not left at the first one: a loop without a jump becomes vectors
    for i in simd_range(len(x)):
        overflows += 0 if x[i] * x[i] < inf else 1
    return overflows == 0


@generic
def allocate(x):
    """Return the output buffer of a step from x: a new array where x is one."""
    return x


@allocate.register(np.ndarray)
def _(x):
    return np.empty_like(x)


@generic
def take_state(out, x):
    """Return the new state: `out` where that is an array, else x."""
    return x


@take_state.register(np.ndarray)
def _(out, x):
    return out


@generic
def explicit_step(method, p, t, x, u, h, scratch, out):
    """Return the state one step of size h after (t, x), of an explicit method; an array is written into `out`."""
    raise NotImplementedError


@generic
def step(method, p, t, x, u, h, scratch):
    """Return the state one step of size h after (t, x), projected onto the model's constraints."""
    out = allocate(x)
    return project(p, take_state(out, explicit_step(method, p, t, x, u, h, scratch, out)))


@generic
def stages(method):
    """Return the number of evaluations in one step."""
    raise NotImplementedError


@generic
def last_stage(method):
    """Return the row of the scratch with the stage at the end of a step, 0 for a method that has no such stage."""
    return 0


@generic
def max_steps(method):
    """Return the maximum number of steps to one instant; unlimited for fixed steps."""
    return 2**62


def equal_step(largest, t, end):
    """Return (size, time after it) of the next of the steps of equal size, at most `largest`, up to `end`."""
    n = max(1.0, ceil((end - t) / largest * (1.0 - 1e-12)))
    h = (end - t) / n
    return h, end if n == 1.0 else t + h


def with_fixed_step(integration, t, x, h, evaluations):
    """Return the integration after a fixed step of size h to state x at time t."""
    return with_step(integration, t, x, h, evaluations, 1, 0, status_of(x))


@generic
def advance(method, p, u, integration, end):
    """Return the integration one accepted step further, not past `end`; fixed methods take equal steps up to there."""
    h, t = equal_step(method.step, integration.t, end)
    return with_fixed_step(
        integration, t, step(method, p, integration.t, integration.x, u, h, integration.scratch), h, stages(method)
    )


def periods_per_step(method, period):
    """Return how many periods [s] a fixed step spans where nothing jumps between them, at least one."""
    return max(1, int(method.step / period * (1.0 + 1e-12)))


@generic
def latest_step_end(method, k, steps, period):
    """Return the instant [s] that no step in period k of `steps` may pass when nothing jumps at its end.

    Fixed steps end where as many periods end as they span.
    """
    span = periods_per_step(method, period)
    return max(k + 1, min((k // span + 1) * span, steps)) * period


@routine
def dense_output(method, p, u, integration, t):
    """Return the state at a time t within the last step, by another step from (t0, x0)."""
    if t == integration.t:
        return integration.x
    return step(method, p, integration.t0, integration.x0, u, t - integration.t0, integration.scratch)
