"""What integrators have in common: an integration under way, and what a method answers."""

from math import ceil, isfinite
from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.jit import generic, kernel, lean_generic, routine
from crane_sim.numerics.states import squared_error_norm
from crane_sim.system import project, workspace

OK, STALLED, NOT_FINITE, ENDLESS = 0, 1, 2, 4
MOST_STAGES = 12


class Scratch(NamedTuple):
    """Where steps of an array state (n,) keep what they compute: made once for a run, worth nothing between steps."""

    rows: Any  # (MOST_STAGES + 4, n): of the stages, then the state at a stage, then what `looks` needs
    work: Any  # the model's workspace


@generic
def scratch(x, p):
    """Return what steps of a state like x keep their intermediate results in: nothing where x is a tuple."""
    return None


@scratch.register(np.ndarray)
def _(x, p):
    return Scratch(np.empty((MOST_STAGES + 4, len(x))), workspace(p))


class Integration(NamedTuple):
    """An integration under way: the solution is x at t; the last step came from (t0, x0)."""

    t0: float
    x0: Any
    t: float
    x: Any
    h: float  # s, what an adaptive method would try next; 0: it has yet to choose
    evaluations: int = 0  # of the right-hand side
    steps: int = 0  # accepted
    rejected: int = 0
    status: int = OK
    seen: Any = None  # events, of a model that switches
    scratch: Any = None


@kernel
def start(p, t, x, seen):
    """Return the Flow of model p that begins with state x at time t, with an empty record of events."""
    return Integration(t, x, t, x, 0.0, 0, 0, 0, OK, seen, scratch(x, p))


@generic
def allocate(x):
    """Return what a step from x writes its result into: a new array where x is one."""
    return x


@allocate.register(np.ndarray)
def _(x):
    return np.empty_like(x)


@generic
def take_state(out, x):
    """Return the new state: what `out` was filled with where that is an array, else x."""
    return x


@take_state.register(np.ndarray)
def _(out, x):
    return out


@lean_generic
def result_of(out, x):
    """Return what `take_state` does, to lean pieces."""
    return x


@result_of.register(np.ndarray)
def _(out, x):
    return out


@lean_generic
def explicit_step(method, p, t, x, u, h, scratch, out):
    """Return the state one step of size h after (t, x), of an explicit method; an array is written into `out`."""
    raise NotImplementedError


@generic
def step(method, p, t, x, u, h, scratch):
    """Return the state one step of size h after (t, x), put back on what the model holds exactly."""
    out = allocate(x)
    return project(p, take_state(out, explicit_step(method, p, t, x, u, h, scratch, out)))


@lean_generic
def stages(method):
    """Return the number of evaluations in one step."""
    raise NotImplementedError


@lean_generic
def max_steps(method):
    """Return how many steps may lead to one instant. Those of a fixed size are as many as the scene asks for."""
    return 2**62


@kernel
def equal_step(largest, t, end):
    """Return (size, time after it) of the next of the steps of equal size, not above `largest`, that fill the way."""
    n = max(1.0, ceil((end - t) / largest * (1.0 - 1e-12)))
    h = (end - t) / n
    return h, end if n == 1.0 else t + h


@kernel
def with_step(flow, t, x, h, evaluations):
    """Return the flow after a fixed step of size h to state x at time t."""
    status = OK if isfinite(squared_error_norm(x, x, x, 0.0, 1.0)) else NOT_FINITE
    n = flow.evaluations + evaluations
    return Integration(flow.t, flow.x, t, x, h, n, flow.steps + 1, flow.rejected, status, flow.seen, flow.scratch)


@kernel
def with_status(flow, status):
    """Return the flow as it stands, with why it cannot go on."""
    t0, x0, t, x, h, evaluations, steps, rejected, _, seen, work = flow
    return Integration(t0, x0, t, x, h, evaluations, steps, rejected, status, seen, work)


@generic
def advance(method, p, u, flow, end):
    """Return the flow one accepted step further, not past `end`. A fixed method divides the way there evenly."""
    h, t = equal_step(method.step, flow.t, end)
    return with_step(flow, t, step(method, p, flow.t, flow.x, u, h, flow.scratch), h, stages(method))


@generic
def step_bound(method, end):
    """Return how far steps may go when nothing jumps at `end`: fixed steps keep to the grid."""
    return end


@routine
def dense_output(method, p, u, flow, t):
    """Return the state at a time t within the last step, by a step of its own: the flow stays as it is."""
    if t == flow.t:
        return flow.x
    return step(method, p, flow.t0, flow.x0, u, t - flow.t0, flow.scratch)
