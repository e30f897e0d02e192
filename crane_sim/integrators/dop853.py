"""Dormand and Prince's method of order 8, with error control (orders 5 and 3) or a fixed step.

Coefficients: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 2nd ed., program
DOP853.
"""

from math import sqrt
from typing import NamedTuple

from crane_sim.files.types import NonNegative, Positive
from crane_sim.integrators.dop853_tableau import E3, E5, A, B, C
from crane_sim.integrators.runge_kutta import evaluate_stages, make_tableau, take_explicit_step
from crane_sim.numerics.states import add_weighted, dimension, error_square

ORDER, STAGES = 8, 12
TABLEAU = make_tableau(A, B, C)


class DOP853(NamedTuple):
    """Dormand and Prince's method of order 8 with error control by orders 5 and 3.

    The error of a step from x to y counts relative to atol + rtol max(|x|, |y|).
    """

    rtol: Positive = 1e-11  # -, relative tolerance
    atol: NonNegative = 1e-13  # state's unit, absolute tolerance
    tableau = TABLEAU
    order, stages, last_stage = ORDER, STAGES, STAGES - 1
    take_step = take_explicit_step

    def step_with_error(self, scratch, k1, p, t, x, u, h, out):
        """Return (state, error, evaluations), see `ErrorControlled`.

        The error is |e5|² / sqrt((|e5|² + |e3|² / 100) n), as in DOP853.
        """
        ks = evaluate_stages(self, scratch, k1, p, t, x, u, h)
        y = add_weighted(x, h, B, ks, out)
        e5 = error_square(h, E5, ks, x, y, self.rtol, self.atol)
        e3 = error_square(h, E3, ks, x, y, self.rtol, self.atol)
        # a NaN is propagated
        error = 0.0 if e5 == 0.0 else e5 / sqrt((e5 + 0.01 * e3) * dimension(x))
        return y, error, STAGES - 1


class RK8(NamedTuple):
    """Dormand and Prince's method of order 8 with a fixed step.

    A step that is unstable for the stiffest motion is refused.
    """

    step: Positive  # s, shortened so that a whole number fills each control period; without control
    # it may span several
    tableau = TABLEAU
    stages, last_stage = STAGES, STAGES - 1
    take_step = take_explicit_step

    def safe_step(self, frequency: float) -> float:
        """Return half the largest step [s] that is stable for motions up to `frequency` [rad/s]."""
        return 2.9 / frequency
