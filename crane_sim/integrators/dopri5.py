"""Dormand and Prince's method of order 5 with an embedded order 4.

Coefficients: Dormand, Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6
(1980), RK5(4)7M.
"""

from math import sqrt
from typing import NamedTuple

from crane_sim.files.types import NonNegative, Positive
from crane_sim.integrators.runge_kutta import evaluate_stages, make_tableau, take_explicit_step
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


class DOPRI5(NamedTuple):
    """Dormand and Prince's method of order 5 with error control.

    It controls the rms of error / (atol + rtol max(|x|, |y|)) for a step from x to y.
    """

    rtol: Positive = 1e-8  # -, relative tolerance
    atol: NonNegative = 1e-10  # state's unit, absolute tolerance
    tableau = make_tableau(A, B, C)
    order, stages, last_stage = ORDER, STAGES, STAGES - 1
    take_step = take_explicit_step

    def step_with_error(self, scratch, k1, p, t, x, u, h, out):
        """Return (state, error, evaluations), see `ErrorControlled`."""
        ks = evaluate_stages(self, scratch, k1, p, t, x, u, h)
        y = add_weighted(x, h, B, ks, out)
        error = sqrt(error_square(h, E, ks, x, y, self.rtol, self.atol) / dimension(x))
        return y, error, STAGES - 1
