"""What integrators have in common: an integration under way, and what a method answers."""

from math import ceil, isfinite
from typing import Any, NamedTuple

from crane_sim.jit import generic, kernel, routine
from crane_sim.state_algebra import weighted_square
from crane_sim.system import project

OK, STALLED, NOT_FINITE = 0, 1, 2


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


@kernel
def start(t, x, seen):
    """Return the Flow that begins with state x at time t, with an empty record of events."""
    return Flow(t, x, t, x, 0.0, 0, 0, 0, OK, seen)


@generic
def step(method, p, t, x, u, h):
    """Return the state one step of size h after (t, x)."""
    raise NotImplementedError


@generic
def stages(method):
    """Return the number of evaluations in one step."""
    raise NotImplementedError


@generic
def advance(method, p, u, flow, end):
    """Return the flow one accepted step further, not past `end`. A fixed method divides the way there evenly."""
    remaining = end - flow.t
    n = max(1.0, ceil(remaining / method.step * (1.0 - 1e-12)))
    h = remaining / n
    x = project(p, step(method, p, flow.t, flow.x, u, h))
    t = end if n == 1.0 else flow.t + h
    finite = isfinite(weighted_square(x, x, x, 0.0, 1.0))
    evaluations, taken = flow.evaluations + stages(method), flow.steps + 1
    return Flow(flow.t, flow.x, t, x, h, evaluations, taken, flow.rejected, OK if finite else NOT_FINITE, flow.seen)


@generic
def horizon(method, end):
    """Return how far steps may go when nothing jumps at `end`: fixed steps keep to the grid."""
    return end


@routine
def state_at(method, p, u, flow, t):
    """Return the state at a time t within the last step, by a step of its own: the flow stays as it is."""
    if t == flow.t:
        return flow.x
    return project(p, step(method, p, flow.t0, flow.x0, u, t - flow.t0))
