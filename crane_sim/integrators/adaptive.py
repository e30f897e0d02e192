"""Step control of methods that know their error: what makes a step accepted, and how large the next one is tried."""

from math import isfinite, sqrt

from crane_sim.integrators.flow import NOT_FINITE, OK, STALLED, Flow, stages
from crane_sim.integrators.runge_kutta import first, opening
from crane_sim.jit import generic, kernel, routine
from crane_sim.state_algebra import add, dimension, scale, weighted_square
from crane_sim.system import project, rhs

SAFETY, SHRINK, GROW = 0.9, 0.2, 6.0
"""A step is scaled by SAFETY err^(-1/order), within these bounds."""


@generic
def attempt(method, k1, p, t, x, u, h):
    """Return (the state one step of size h after (t, x), its error relative to the tolerance).

    k1 is the derivative at (t, x) as `runge_kutta.opening` returns it; a rejected step leaves it as it is.
    """
    raise NotImplementedError


@generic
def error_order(method):
    """Return the power of h by which the error of a step shrinks."""
    raise NotImplementedError


@kernel
def first_size(p, t, x, u, k1, rtol, atol, order):
    """Return a first step that an explicit Euler step shows to be careful (Hairer, Norsett, Wanner, II.4)."""
    n = dimension(x)
    d0 = sqrt(weighted_square(x, x, x, rtol, atol) / n)
    d1 = sqrt(weighted_square(k1, x, x, rtol, atol) / n)
    h0 = 1e-6 if min(d0, d1) < 1e-5 else 0.01 * d0 / d1
    change = add(rhs(p, t + h0, add(x, scale(h0, k1)), u), scale(-1.0, k1))
    d2 = sqrt(weighted_square(change, x, x, rtol, atol) / n) / h0
    steepest = max(d1, d2)
    h1 = max(1e-6, h0 * 1e-3) if steepest < 1e-15 else (0.01 / steepest) ** (1.0 / order)
    return min(100.0 * h0, h1)


@routine
def accepted_step(method, p, u, flow, end):
    """Return the flow one step further, tried again with smaller steps until its error is within the tolerance."""
    t, x, h, n, rejected, order = flow.t, flow.x, flow.h, flow.evaluations, flow.rejected, error_order(method)
    k1 = opening(flow.scratch, p, t, x, u)
    if h == 0.0:
        h, n = first_size(p, t, x, u, first(k1), method.rtol, method.atol, order), n + 1
    n, y, reached, growth = n + 1, x, t, GROW
    status = STALLED if isfinite(h) else NOT_FINITE
    while t + 0.1 * h > t:
        last = t + 1.000000001 * h >= end
        size = end - t if last else h
        y, error = attempt(method, k1, p, t, x, u, size)
        n += stages(method) - 1
        factor = min(growth, max(SHRINK, SAFETY * error ** (-1.0 / order))) if error > 0.0 else growth
        if error <= 1.0:
            y, reached, status, h = project(p, y), end if last else t + size, OK, max(size * factor, h if last else 0.0)
            break
        h, growth, rejected = size * (factor if isfinite(error) else SHRINK), 1.0, rejected + 1
        status = STALLED if isfinite(error) else NOT_FINITE
    y = y if status == OK else x  # a step that failed leaves the state as it was
    return Flow(t, x, reached, y, h, n, flow.steps + (status == OK), rejected, status, flow.seen, flow.scratch)
