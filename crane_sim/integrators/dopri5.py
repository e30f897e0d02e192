"""Dormand and Prince's method of order 5 with an embedded order 4.

Coefficients: Dormand, Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980), RK5(4)7M.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive
from crane_sim.integrators.integration import (
    Scratch,
    advance,
    explicit_step,
    last_stage,
    latest_step_end,
    max_steps,
    stages,
    take_state,
)
from crane_sim.integrators.runge_kutta import evaluate_first_stage, evaluate_stage, fill_stages, to_dense_tableau
from crane_sim.integrators.step_control import MAX_STEPS, accepted_step, error_order, step_with_error
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import add_weighted, dimension, error_square

B = (35 / 384, None, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, None)
A = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    B[:6],
)
C = (1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
E = (71 / 57600, None, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
"""Weights of the error: order 5 less order 4."""
ORDER, STAGES = 5, 7
_DENSE, _NODES = to_dense_tableau(A), np.array((0.0, *C))


class DOPRI5(NamedTuple):
    """Dormand and Prince's order 5; error control by the rms of error / (atol + rtol max(|x|, |y|)), step x to y."""

    rtol: Positive = 1e-8  # -, relative tolerance
    atol: NonNegative = 1e-10  # state's unit, absolute tolerance


@generic
def dopri5_stages(scratch, k1, p, t, x, u, h):
    """Return the derivatives of all seven stages, the first one that of `evaluate_first_stage`."""
    k2 = evaluate_stage(p, t, x, u, h, A[0], C[0], (k1,))
    k3 = evaluate_stage(p, t, x, u, h, A[1], C[1], (k1, k2))
    k4 = evaluate_stage(p, t, x, u, h, A[2], C[2], (k1, k2, k3))
    k5 = evaluate_stage(p, t, x, u, h, A[3], C[3], (k1, k2, k3, k4))
    k6 = evaluate_stage(p, t, x, u, h, A[4], C[4], (k1, k2, k3, k4, k5))
    return k1, k2, k3, k4, k5, k6, evaluate_stage(p, t, x, u, h, A[5], C[5], (k1, k2, k3, k4, k5, k6))


@dopri5_stages.register(Scratch)
def _(scratch, k1, p, t, x, u, h):
    fill_stages(scratch, p, t, x, u, h, _DENSE, _NODES)
    return scratch


@step_with_error.register(DOPRI5)
def _(method, scratch, k1, p, t, x, u, h, out):
    ks = dopri5_stages(scratch, k1, p, t, x, u, h)
    y = add_weighted(x, h, B, ks, out)
    error = sqrt(error_square(h, E, ks, x, take_state(out, y), method.rtol, method.atol) / dimension(x))
    return y, error, STAGES - 1


@max_steps.register(DOPRI5)
def _(method):
    return MAX_STEPS


@error_order.register(DOPRI5)
def _(method):
    return ORDER


@advance.register(DOPRI5)
def _(method, p, u, integration, end):
    return accepted_step(method, p, u, integration, end)


@latest_step_end.register(DOPRI5)
def _(method, k, steps, period):
    return inf


@explicit_step.register(DOPRI5)
def _(method, p, t, x, u, h, scratch, out):
    return add_weighted(x, h, B, dopri5_stages(scratch, evaluate_first_stage(scratch, p, t, x, u), p, t, x, u, h), out)


@stages.register(DOPRI5)
def _(method):
    return STAGES


@last_stage.register(DOPRI5)
def _(method):
    return STAGES - 1
