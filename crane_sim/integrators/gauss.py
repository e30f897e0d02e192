"""Gauss collocation, three stages, order 6: for long horizons, as its energy error does not grow.

Coefficients: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2nd ed., II.1.3. The stages
are iterated until rounding stops them, so that what is left of the method's symmetry is not spoilt
by a tolerance (VIII.6).
"""

from math import nan, sqrt
from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.integrators.step_control import copy_state
from crane_sim.numerics.jit import routine
from crane_sim.numerics.states import add, add_scaled, scale, squared_error_norm
from crane_sim.system import rhs

ROOT = sqrt(15.0)
A = (
    (5 / 36, 2 / 9 - ROOT / 15, 5 / 36 - ROOT / 30),
    (5 / 36 + ROOT / 24, 2 / 9, 5 / 36 - ROOT / 24),
    (5 / 36 + ROOT / 30, 2 / 9 + ROOT / 15, 5 / 36),
)
C = (1 / 2 - ROOT / 10, 1 / 2, 1 / 2 + ROOT / 10)
B = (5 / 18, 4 / 9, 5 / 18)
ORDER = 6
MAX_SWEEPS, SETTLED = 60, 1e-26
"""Sweeps over the stages; the squared relative change below which they end as soon as it no longer
shrinks."""


class Gauss(NamedTuple):
    """Gauss collocation of order 6, fixed step; energy errors do not grow over long horizons."""

    step: Positive  # s, shortened so that a whole number fills each control period; without control
    # it may span several
    stages, last_stage = 3, 0

    def safe_step(self, frequency: float) -> float:
        """Return the largest step [s] with which sweeps settle up to `frequency` [rad/s]."""
        return 1.0 / frequency

    def take_step(self, p, t, x, u, h, scratch, out):
        """Return (state, evaluations), see `Method`."""
        y, sweeps = solve_collocation(p, t, x, u, h)
        return copy_state(y, out), 1 + 3 * sweeps


def add_stages(x, h, row, k1, k2, k3):
    """Return x + h (row . k)."""
    return add(x, add_scaled(add_scaled(scale(h * row[0], k1), h * row[1], k2), h * row[2], k3))


def change(h, x, new, old):
    """Return the squared relative change of a stage's step."""
    difference = scale(h, add_scaled(new, -1.0, old))
    return squared_error_norm(difference, x, x, 1.0, 1.0)


@routine
def solve_collocation(p, t, x, u, h):
    """Return (the state one step after (t, x), sweeps); NaN when the stages do not settle."""
    k1 = rhs(p, t, x, u)
    k2, k3, last = k1, k1, 1e300
    for sweep in range(MAX_SWEEPS):
        n1 = rhs(p, t + C[0] * h, add_stages(x, h, A[0], k1, k2, k3), u)
        n2 = rhs(p, t + C[1] * h, add_stages(x, h, A[1], n1, k2, k3), u)
        n3 = rhs(p, t + C[2] * h, add_stages(x, h, A[2], n1, n2, k3), u)
        moved = change(h, x, n1, k1) + change(h, x, n2, k2) + change(h, x, n3, k3)
        k1, k2, k3 = n1, n2, n3
        if moved == 0.0 or (moved < SETTLED and moved >= last):
            return add_stages(x, h, B, k1, k2, k3), sweep + 1
        last = moved
    return scale(nan, x), MAX_SWEEPS
