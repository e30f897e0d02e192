"""What integrators have in common: an integration under way, and what a method answers."""

from math import ceil, isfinite
from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.jit import generic, kernel, lean_generic, routine
from crane_sim.numerics.states import weighted_square
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


class Flow(NamedTuple):
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
    return Flow(t, x, t, x, 0.0, 0, 0, 0, OK, seen, scratch(x, p))


@generic
def blank(x):
    """Return what a step from x writes its result into: a new array where x is one."""
    return x


@blank.register(np.ndarray)
def _(x):
    return np.empty_like(x)


@generic
def received(out, x):
    """Return the new state: what `out` was filled with where that is an array, else x."""
    return x


@received.register(np.ndarray)
def _(out, x):
    return out


@lean_generic
def found(out, x):
    """Return what `received` does, to lean pieces."""
    return x


@found.register(np.ndarray)
def _(out, x):
    return out


@lean_generic
def stride(method, p, t, x, u, h, scratch, out):
    """Return the state one step of size h after (t, x), of an explicit method; an array is written into `out`."""
    raise NotImplementedError


@generic
def step(method, p, t, x, u, h, scratch):
    """Return the state one step of size h after (t, x), put back on what the model holds exactly."""
    out = blank(x)
    return project(p, received(out, stride(method, p, t, x, u, h, scratch, out)))


@lean_generic
def stages(method):
    """Return the number of evaluations in one step."""
    raise NotImplementedError


@lean_generic
def patience(method):
    """Return how many steps may lead to one instant. Those of a fixed size are as many as the scene asks for."""
    return 2**62


@kernel
def even_step(largest, t, end):
    """Return (size, time after it) of the next of the steps of equal size, not above `largest`, that fill the way."""
    n = max(1.0, ceil((end - t) / largest * (1.0 - 1e-12)))
    h = (end - t) / n
    return h, end if n == 1.0 else t + h


@kernel
def stepped(flow, t, x, h, evaluations):
    """Return the flow after a fixed step of size h to state x at time t."""
    status = OK if isfinite(weighted_square(x, x, x, 0.0, 1.0)) else NOT_FINITE
    n = flow.evaluations + evaluations
    return Flow(flow.t, flow.x, t, x, h, n, flow.steps + 1, flow.rejected, status, flow.seen, flow.scratch)


@kernel
def stopped(flow, status):
    """Return the flow as it stands, with why it cannot go on."""
    t0, x0, t, x, h, evaluations, steps, rejected, _, seen, work = flow
    return Flow(t0, x0, t, x, h, evaluations, steps, rejected, status, seen, work)


@generic
def advance(method, p, u, flow, end):
    """Return the flow one accepted step further, not past `end`. A fixed method divides the way there evenly."""
    h, t = even_step(method.step, flow.t, end)
    return stepped(flow, t, step(method, p, flow.t, flow.x, u, h, flow.scratch), h, stages(method))


@generic
def horizon(method, end):
    """Return how far steps may go when nothing jumps at `end`: fixed steps keep to the grid."""
    return end


@routine
def state_at(method, p, u, flow, t):
    """Return the state at a time t within the last step, by a step of its own: the flow stays as it is."""
    if t == flow.t:
        return flow.x
    return step(method, p, flow.t0, flow.x0, u, t - flow.t0, flow.scratch)
