"""The classical Runge-Kutta method of order 4 with a fixed step (Kutta 1901)."""

from typing import NamedTuple

from crane_sim.integrators import stages, step
from crane_sim.integrators.runge_kutta import moved, slope
from crane_sim.quantities import Positive
from crane_sim.system import rhs

A = ((1 / 2,), (None, 1 / 2), (None, None, 1.0))
C = (1 / 2, 1 / 2, 1.0)
B = (1 / 6, 1 / 3, 1 / 3, 1 / 6)
ORDER = 4


class RK4(NamedTuple):
    """Settings: the step is shortened so that a whole number of them fills each control period."""

    step: Positive  # s


@step.register(RK4)
def _(method, p, t, x, u, h):
    k1 = rhs(p, t, x, u)
    k2 = slope(p, t, x, u, h, A[0], C[0], (k1,))
    k3 = slope(p, t, x, u, h, A[1], C[1], (k1, k2))
    k4 = slope(p, t, x, u, h, A[2], C[2], (k1, k2, k3))
    return moved(x, h, B, (k1, k2, k3, k4))


@stages.register(RK4)
def _(method):
    return 4
