"""A method of integration, the state of an integration, and one step."""

from math import inf, isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np

from crane_sim.integrators.status import NOT_FINITE, OK
from crane_sim.numerics.jit import routine, simd_range
from crane_sim.numerics.states import leaves
from crane_sim.system import project, workspace


class Method(Protocol):
    """A method of integration: a NamedTuple of its settings, one file each.

    One with a fixed step has a field `step` [s], its size, and `safe_step(frequency)`, the largest
    one to be trusted for motions up to a frequency [rad/s]. The others are `ErrorControlled`.
    """

    stages: int
    """Evaluations in one step."""
    last_stage: int
    """Row of the scratch with the derivative at the end of a step, 0 for a method that does not
    evaluate it there."""

    def take_step(
        self, p: Any, t: Any, x: Any, u: Any, h: Any, scratch: Any, out: Any
    ) -> tuple[Any, Any]:
        """Return (the state one step of size h after (t, x), evaluations).

        A state that is an array is `out`, which is filled.
        """
        ...


class ErrorControlled(Method, Protocol):
    """A method that chooses the size of its steps."""

    rtol: float
    atol: float
    order: int
    """Power of h with which the estimated error of a step shrinks."""

    def step_with_error(
        self, scratch: Any, k1: Any, p: Any, t: Any, x: Any, u: Any, h: Any, out: Any
    ) -> tuple[Any, Any, Any]:
        """Return (the state as `take_step` does, its error relative to the tolerance, evaluations).

        k1 is the derivative at (t, x) as of `evaluate_first_stage`; a rejected step does not change
        it.
        """
        ...


MAX_STAGES = 12


class Scratch(NamedTuple):
    """Work arrays of steps of a state (n,), allocated once a run, undefined between steps."""

    rows: Any  # (MAX_STAGES + 5, n): of the stages, the state at a stage, three that `events`
    # needs, one of `leapfrog`
    work: Any  # the model's workspace


def scratch(x, p) -> Any:
    """Return the work arrays for steps of a state like x: None where x is a tuple."""
    return (
        Scratch(np.empty((MAX_STAGES + 5, len(x))), workspace(p))
        if isinstance(x, np.ndarray)
        else None
    )


NO_GUARD = -1


class Integration(NamedTuple):
    """An integration under way: the solution is x at t, a step after x0 at t0."""

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
    """Return the integration of model p from state x at time t on, with an empty log of events."""
    return Integration(t, x, t, x, 0.0, event_log=event_log, scratch=scratch(x, p))


def with_step(integration, t, x, h, evaluations, steps, rejected, status):
    """Return the integration one step further, at (t, x), with more work counted.

    h is the size of the next step.
    """
    return integration._replace(
        t0=integration.t,
        x0=integration.x,
        t=t,
        x=x,
        h=h,
        evaluations=integration.evaluations + evaluations,
        steps=integration.steps + steps,
        rejected=integration.rejected + rejected,
        status=status,
    )


def add_evaluations(integration, evaluations):
    """Return the integration with more evaluations counted."""
    return integration._replace(evaluations=integration.evaluations + evaluations)


def status_of(x):
    """Return the status of an integration in state x."""
    return OK if is_finite(x) else NOT_FINITE


def is_finite(x):
    """Return whether every number of the state, squared, is finite."""
    if not isinstance(x, np.ndarray):
        total = 0.0
        for entry in leaves(x):
            total += entry * entry
        return isfinite(total)
    overflows = 0  # counted, not left at the first one: a loop without a jump becomes vectors
    for i in simd_range(len(x)):
        overflows += 0 if x[i] * x[i] < inf else 1
    return overflows == 0


def allocate(x):
    """Return the array that a step from x fills, None where x is a tuple."""
    return np.empty_like(x) if isinstance(x, np.ndarray) else None


def step(method, p, t, x, u, h, scratch):
    """Return the state one step of size h after (t, x), projected onto the model's constraints."""
    return project(p, method.take_step(p, t, x, u, h, scratch, allocate(x))[0])


@routine
def dense_output(method, p, u, integration, t):
    """Return the state at a time t within the last step, by another step from (t0, x0)."""
    if t == integration.t:
        return integration.x
    return step(
        method, p, integration.t0, integration.x0, u, t - integration.t0, integration.scratch
    )
