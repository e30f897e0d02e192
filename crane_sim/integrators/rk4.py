"""The classical Runge-Kutta method of order 4 with a fixed step (Kutta 1901)."""

from typing import NamedTuple

import numpy as np

from crane_sim.files.types import Positive
from crane_sim.integrators.integration import Scratch, explicit_step, last_stage, stages
from crane_sim.integrators.runge_kutta import evaluate_first_stage, evaluate_stage, fill_stages, to_dense_tableau
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import add_weighted

A = ((1 / 2,), (None, 1 / 2), (None, None, 1.0))
C = (1 / 2, 1 / 2, 1.0)
B = (1 / 6, 1 / 3, 1 / 3, 1 / 6)
ORDER = 4
_DENSE, _NODES = to_dense_tableau(A), np.array((0.0, *C))


class RK4(NamedTuple):
    """The classical order 4 with a fixed step; one that is unstable for the stiffest motion is refused."""

    step: Positive  # s, shortened so that a whole number fills each control period; without control it may span several

    def safe_step(self, frequency: float) -> float:
        """Return half the largest step [s] that is stable for motions up to `frequency` [rad/s]."""
        return 1.4 / frequency


@generic
def rk4_stages(scratch, k1, p, t, x, u, h):
    """Return the derivatives of all four stages, the first one that of `evaluate_first_stage`."""
    k2 = evaluate_stage(p, t, x, u, h, A[0], C[0], (k1,))
    k3 = evaluate_stage(p, t, x, u, h, A[1], C[1], (k1, k2))
    return k1, k2, k3, evaluate_stage(p, t, x, u, h, A[2], C[2], (k1, k2, k3))


@rk4_stages.register(Scratch)
def _(scratch, k1, p, t, x, u, h):
    fill_stages(scratch, p, t, x, u, h, _DENSE, _NODES)
    return scratch


@explicit_step.register(RK4)
def _(method, p, t, x, u, h, scratch, out):
    return add_weighted(x, h, B, rk4_stages(scratch, evaluate_first_stage(scratch, p, t, x, u), p, t, x, u, h), out)


@stages.register(RK4)
def _(method):
    return 4


@last_stage.register(RK4)
def _(method):
    return 3
