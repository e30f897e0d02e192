"""Dormand and Prince's method of order 8, with error control by orders 5 and 3, or with a fixed step.

Coefficients: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 2nd ed., program DOP853.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive
from crane_sim.integrators.dop853_tableau import E3, E5, A, B, C
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

ORDER, STAGES = 8, 12
_DENSE, _NODES = to_dense_tableau(A), np.array((0.0, *C))


class DOP853(NamedTuple):
    """Dormand and Prince's order 8; error control by orders 5 and 3, against atol + rtol max(|x|, |y|), step x to y."""

    rtol: Positive = 1e-11  # -, relative tolerance
    atol: NonNegative = 1e-13  # state's unit, absolute tolerance


class RK8(NamedTuple):
    """Dormand and Prince's order 8 with a fixed step; one that is unstable for the stiffest motion is refused."""

    step: Positive  # s, shortened so that a whole number fills each control period; without control it may span several

    def safe_step(self, frequency: float) -> float:
        """Return half the largest step [s] that is stable for motions up to `frequency` [rad/s]."""
        return 2.9 / frequency


@generic
def dop853_stages(scratch, k1, p, t, x, u, h):
    """Return the derivatives of all twelve stages, the first one that of `evaluate_first_stage`."""
    k2 = evaluate_stage(p, t, x, u, h, A[0], C[0], (k1,))
    k3 = evaluate_stage(p, t, x, u, h, A[1], C[1], (k1, k2))
    k4 = evaluate_stage(p, t, x, u, h, A[2], C[2], (k1, k2, k3))
    k5 = evaluate_stage(p, t, x, u, h, A[3], C[3], (k1, k2, k3, k4))
    k6 = evaluate_stage(p, t, x, u, h, A[4], C[4], (k1, k2, k3, k4, k5))
    k7 = evaluate_stage(p, t, x, u, h, A[5], C[5], (k1, k2, k3, k4, k5, k6))
    k8 = evaluate_stage(p, t, x, u, h, A[6], C[6], (k1, k2, k3, k4, k5, k6, k7))
    k9 = evaluate_stage(p, t, x, u, h, A[7], C[7], (k1, k2, k3, k4, k5, k6, k7, k8))
    k10 = evaluate_stage(p, t, x, u, h, A[8], C[8], (k1, k2, k3, k4, k5, k6, k7, k8, k9))
    k11 = evaluate_stage(p, t, x, u, h, A[9], C[9], (k1, k2, k3, k4, k5, k6, k7, k8, k9, k10))
    k12 = evaluate_stage(p, t, x, u, h, A[10], C[10], (k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11))
    return k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11, k12


@dop853_stages.register(Scratch)
def _(scratch, k1, p, t, x, u, h):
    fill_stages(scratch, p, t, x, u, h, _DENSE, _NODES)
    return scratch


def _combined_error(ks, x, y, h, rtol, atol):
    """Return the error of a step relative to the tolerance, |e5|² / sqrt((|e5|² + |e3|² / 100) n) as in DOP853."""
    e5 = error_square(h, E5, ks, x, y, rtol, atol)
    e3 = error_square(h, E3, ks, x, y, rtol, atol)
    return 0.0 if e5 == 0.0 else e5 / sqrt((e5 + 0.01 * e3) * dimension(x))  # a NaN is propagated


@step_with_error.register(DOP853)
def _(method, scratch, k1, p, t, x, u, h, out):
    ks = dop853_stages(scratch, k1, p, t, x, u, h)
    y = add_weighted(x, h, B, ks, out)
    return y, _combined_error(ks, x, take_state(out, y), h, method.rtol, method.atol), STAGES - 1


@max_steps.register(DOP853)
def _(method):
    return MAX_STEPS


@error_order.register(DOP853)
def _(method):
    return ORDER


@advance.register(DOP853)
def _(method, p, u, integration, end):
    return accepted_step(method, p, u, integration, end)


@latest_step_end.register(DOP853)
def _(method, k, steps, period):
    return inf


def _take_step(p, t, x, u, h, scratch, out):
    return add_weighted(x, h, B, dop853_stages(scratch, evaluate_first_stage(scratch, p, t, x, u), p, t, x, u, h), out)


@explicit_step.register(DOP853)
def _(method, p, t, x, u, h, scratch, out):
    return _take_step(p, t, x, u, h, scratch, out)


@explicit_step.register(RK8)
def _(method, p, t, x, u, h, scratch, out):
    return _take_step(p, t, x, u, h, scratch, out)


@stages.register(DOP853)
@stages.register(RK8)
def _(method):
    return STAGES


@last_stage.register(DOP853)
@last_stage.register(RK8)
def _(method):
    return STAGES - 1
