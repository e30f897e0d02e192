"""The classical Runge-Kutta method of order 4 with a fixed step (Kutta 1901)."""

from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.integrators.runge_kutta import make_tableau, take_explicit_step

A = ((1 / 2,), (None, 1 / 2), (None, None, 1.0))
C = (1 / 2, 1 / 2, 1.0)
B = (1 / 6, 1 / 3, 1 / 3, 1 / 6)
ORDER = 4


class RK4(NamedTuple):
    """The classical method of order 4 with a fixed step.

    A step that is unstable for the stiffest motion is refused.
    """

    step: Positive  # s, shortened so that a whole number fills each control period; without control
    # it may span several
    tableau = make_tableau(A, B, C)
    stages, last_stage = 4, 3
    take_step = take_explicit_step

    def safe_step(self, frequency: float) -> float:
        """Return half the largest step [s] that is stable for motions up to `frequency` [rad/s]."""
        return 1.4 / frequency
