"""Step size control of methods with an error estimate: acceptance of a step, size of the next one."""

from math import isfinite, sqrt

import numpy as np

from crane_sim.integrators.integration import (
    Scratch,
    allocate,
    take_state,
    with_step,
)
from crane_sim.integrators.runge_kutta import evaluate_first_stage
from crane_sim.integrators.status import NOT_FINITE, OK, STEP_TOO_SMALL
from crane_sim.numerics.jit import generic, routine
from crane_sim.numerics.states import add, dimension, scale, squared_error_norm
from crane_sim.system import project, rhs, rhs_into

SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 6.0
"""A step is scaled by SAFETY err^(-1/order), within these bounds."""


MAX_STEPS = 1_000_000
"""Limit to one instant: a diverging law needs ever shorter steps, and a run must end."""


@generic
def step_with_error(method, scratch, k1, p, t, x, u, h, out):
    """Return (the state one step of size h after (t, x), its error relative to the tolerance, evaluations).

    k1 is the derivative at (t, x) as of `evaluate_first_stage`; a rejected step does not change it. An array state is
    written into `out` instead.
    """
    raise NotImplementedError


@generic
def error_order(method):
    """Return the power of h with which the estimated error of a step shrinks, an exponent of the step size control."""
    raise NotImplementedError


@generic
def derivative_norm(scratch, k1, x, rtol, atol):
    """Return the weighted square of the derivative that `evaluate_first_stage` computed at x."""
    return squared_error_norm(k1, x, x, rtol, atol)


@derivative_norm.register(Scratch)
def _(scratch, k1, x, rtol, atol):
    return squared_error_norm(scratch.rows[0], x, x, rtol, atol)


@generic
def second_derivative_norm(scratch, k1, p, t, x, u, h, rtol, atol):
    """Return the weighted square of the change of the derivative in an explicit Euler step of size h."""
    change = add(rhs(p, t + h, add(x, scale(h, k1)), u), scale(-1.0, k1))
    return squared_error_norm(change, x, x, rtol, atol)


@second_derivative_norm.register(Scratch)
def _(scratch, k1, p, t, x, u, h, rtol, atol):
    rows = scratch.rows
    for i in range(len(x)):
        rows[1, i] = x[i] + h * rows[0, i]
    rhs_into(p, t + h, rows[1], u, rows[2], scratch.work)
    for i in range(len(x)):
        rows[2, i] -= rows[0, i]
    return squared_error_norm(rows[2], x, x, rtol, atol)


def select_initial_step(scratch, p, t, x, u, k1, rtol, atol, order):
    """Return a first step that an explicit Euler step shows to be careful (Hairer, Norsett, Wanner, II.4)."""
    n = dimension(x)
    d0 = sqrt(squared_error_norm(x, x, x, rtol, atol) / n)
    d1 = sqrt(derivative_norm(scratch, k1, x, rtol, atol) / n)
    h0 = 1e-6 if min(d0, d1) < 1e-5 else 0.01 * d0 / d1
    d2 = sqrt(second_derivative_norm(scratch, k1, p, t, x, u, h0, rtol, atol) / n) / h0
    steepest = max(d1, d2)
    h1 = max(1e-6, h0 * 1e-3) if steepest < 1e-15 else (0.01 / steepest) ** (1.0 / order)
    return min(100.0 * h0, h1)


@routine
def adaptive_step(method, scratch, p, t, x, u, h, end, out):
    """Try steps, smaller and smaller, until the error of one is within the tolerance; arguments of `step_with_error`.

    Returns:
        (state after the step as of `step_with_error`, its time, size to try next, evaluations, steps rejected, status)
    """
    order, n, rejected, growth = error_order(method), 1, 0, MAX_FACTOR
    k1 = evaluate_first_stage(scratch, p, t, x, u)
    if h == 0.0:
        h, n = select_initial_step(scratch, p, t, x, u, k1, method.rtol, method.atol, order), n + 1
    status = STEP_TOO_SMALL if isfinite(h) else NOT_FINITE
    while t + 0.1 * h > t:
        last = t + 1.000000001 * h >= end
        size = end - t if last else h
        y, error, evaluations = step_with_error(method, scratch, k1, p, t, x, u, size, out)
        n += evaluations
        factor = min(growth, max(MIN_FACTOR, SAFETY * error ** (-1.0 / order))) if error > 0.0 else growth
        if error <= 1.0:
            return y, end if last else t + size, max(size * factor, h if last else 0.0), n, rejected, OK
        h, growth, rejected = size * (factor if isfinite(error) else MIN_FACTOR), 1.0, rejected + 1
        status = STEP_TOO_SMALL if isfinite(error) else NOT_FINITE
    return copy_state(x, out), t, h, n, rejected, status


@generic
def copy_state(x, out):
    """Return the state x as `step_with_error` does: a step that failed leaves the state as it was."""
    return x


@copy_state.register(np.ndarray)
def _(x, out):
    for i in range(len(x)):
        out[i] = x[i]


@routine
def accepted_step(method, p, u, integration, end):
    """Return the integration one step further, tried with smaller steps until its error is within the tolerance."""
    out = allocate(integration.x)
    y, t, h, n, rejected, status = adaptive_step(
        method, integration.scratch, p, integration.t, integration.x, u, integration.h, end, out
    )
    y, steps = take_state(out, y), 0
    if status == OK:
        y, steps = project(p, y), 1
    return with_step(integration, t, y, h, n, steps, rejected, status)
