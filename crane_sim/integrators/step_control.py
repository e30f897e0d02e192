"""Sizes of steps: equal ones up to an instant, or those that keep errors within the tolerance."""

from math import ceil, inf, isfinite, sqrt

import numpy as np

from crane_sim.integrators.integration import allocate, status_of, with_step
from crane_sim.integrators.runge_kutta import evaluate_first_stage
from crane_sim.integrators.status import NOT_FINITE, OK, STEP_TOO_SMALL
from crane_sim.numerics.jit import routine
from crane_sim.numerics.states import add, dimension, scale, squared_error_norm
from crane_sim.system import project, rhs

SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 6.0
"""A step is scaled by SAFETY err^(-1/order), within these bounds."""
MAX_STEPS = 1_000_000
"""Limit to one instant: a diverging law needs ever shorter steps, and a run must end."""


def controls_error(method):
    """Return whether a method is `ErrorControlled`: others take fixed steps."""
    return hasattr(method, "rtol")


def max_steps(method):
    """Return the maximum number of steps to one instant; unlimited for fixed steps."""
    return MAX_STEPS if controls_error(method) else 2**62


def equal_step(largest, t, end):
    """Return (size, time after it) of the next step up to `end`.

    Steps are of equal size, at most `largest`.
    """
    n = max(1.0, ceil((end - t) / largest * (1.0 - 1e-12)))
    h = (end - t) / n
    return h, end if n == 1.0 else t + h


def periods_per_step(method, period):
    """Return how many periods [s], at least one, a fixed step spans if nothing jumps in between."""
    return max(1, int(method.step / period * (1.0 + 1e-12)))


def latest_step_end(method, k, steps, period):
    """Return the instant [s] that no step in period k of `steps` may pass if nothing jumps there.

    Fixed steps end where as many periods end as they span.
    """
    if controls_error(method):
        return inf
    span = periods_per_step(method, period)
    return max(k + 1, min((k // span + 1) * span, steps)) * period


def advance(method, p, u, integration, end):
    """Return the integration one accepted step further, not past `end`.

    Fixed methods take equal steps up to there.
    """
    if controls_error(method):
        return accepted_step(method, p, u, integration, end)
    (h, t), x = equal_step(method.step, integration.t, end), integration.x
    x, evaluations = method.take_step(p, integration.t, x, u, h, integration.scratch, allocate(x))
    x = project(p, x)
    return with_step(integration, t, x, h, evaluations, 1, 0, status_of(x))


def select_initial_step(scratch, p, t, x, u, k1, rtol, atol, order):
    """Return a careful first step, from an explicit Euler step (Hairer, Norsett, Wanner, II.4)."""
    n = dimension(x)
    d0 = sqrt(squared_error_norm(x, x, x, rtol, atol) / n)
    d1 = sqrt(squared_error_norm(k1, x, x, rtol, atol) / n)
    h0 = 1e-6 if min(d0, d1) < 1e-5 else 0.01 * d0 / d1
    d2 = sqrt(second_derivative_norm(scratch, k1, p, t, x, u, h0, rtol, atol) / n) / h0
    steepest = max(d1, d2)
    h1 = max(1e-6, h0 * 1e-3) if steepest < 1e-15 else (0.01 / steepest) ** (1.0 / order)
    return min(100.0 * h0, h1)


def second_derivative_norm(scratch, k1, p, t, x, u, h, rtol, atol):
    """Return the weighted square of the derivative's change in an explicit Euler step of size h."""
    change = add(rhs(p, t + h, add(x, scale(h, k1)), u), scale(-1.0, k1))
    return squared_error_norm(change, x, x, rtol, atol)


@routine
def adaptive_step(method, scratch, p, t, x, u, h, end, out):
    """Try smaller and smaller steps until the error of one is within the tolerance.

    The arguments are those of `step_with_error`.

    Returns:
        (state after the step as of `step_with_error`, its time, size to try next, evaluations,
        steps rejected, status)
    """
    n, rejected, growth = 1, 0, MAX_FACTOR
    k1 = evaluate_first_stage(scratch, p, t, x, u)
    if h == 0.0:
        h, n = (
            select_initial_step(scratch, p, t, x, u, k1, method.rtol, method.atol, method.order),
            n + 1,
        )
    status = STEP_TOO_SMALL if isfinite(h) else NOT_FINITE
    while t + 0.1 * h > t:
        last = t + 1.000000001 * h >= end
        size = end - t if last else h
        y, error, evaluations = method.step_with_error(scratch, k1, p, t, x, u, size, out)
        n += evaluations
        factor = (
            min(growth, max(MIN_FACTOR, SAFETY * error ** (-1.0 / method.order)))
            if error > 0.0
            else growth
        )
        if error <= 1.0:
            return (
                y,
                end if last else t + size,
                max(size * factor, h if last else 0.0),
                n,
                rejected,
                OK,
            )
        h, growth, rejected = size * (factor if isfinite(error) else MIN_FACTOR), 1.0, rejected + 1
        status = STEP_TOO_SMALL if isfinite(error) else NOT_FINITE
    return copy_state(x, out), t, h, n, rejected, status


def copy_state(x, out):
    """Return the state x; an array as `out`, which is filled with it."""
    if not isinstance(x, np.ndarray):
        return x
    out[:] = x
    return out


@routine
def accepted_step(method, p, u, integration, end):
    """Return the integration one step further, with a step whose error is within tolerance.

    Smaller steps are tried until it is.
    """
    x, scratch = integration.x, integration.scratch
    y, t, h, n, rejected, status = adaptive_step(
        method, scratch, p, integration.t, x, u, integration.h, end, allocate(x)
    )
    steps = 0
    if status == OK:
        y, steps = project(p, y), 1
    return with_step(integration, t, y, h, n, steps, rejected, status)
