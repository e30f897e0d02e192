"""Leapfrog of Störmer and Verlet, order 2 with a fixed step, for models whose state is an array.

    w = v + h/2 a,  x' = x + h w,  a' = a(t + h, x', w + h/2 a),  v' = w + h/2 a'

It is stable up to h = 2 / frequency at one evaluation a step, which no Runge-Kutta method is at the
price: the cheapest method where two to four digits do and a light cable's whipping, not its error,
limits the step. Accelerations that depend on velocities see them extrapolated, with an error of
order h². Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2nd ed., I.1.4.
"""

from math import inf
from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.integrators.integration import MAX_STAGES
from crane_sim.numerics.jit import routine, simd_range, use_wide_vectors
from crane_sim.numerics.rows import elementwise
from crane_sim.system import position_count, rhs_into

CARRIED = MAX_STAGES + 4  # row of a scratch: the derivative that the next step begins with


class Leapfrog(NamedTuple):
    """Order 2 with a fixed step, for light cables in rigid links.

    A step takes one evaluation, two beside events.
    """

    step: Positive  # s, shortened so that a whole number fills each control period; without control
    # it may span several
    stages, last_stage = 2, 0

    def safe_step(self, frequency: float) -> float:
        """Return half the largest step [s] that is stable for motions up to `frequency` [rad/s]."""
        return 1.0 / frequency

    def take_step(self, p, t, x, u, h, scratch, out):
        """Return (state, evaluations), see `Method`, of a step on its own.

        The steps of a run are those of `continue_step`.
        """
        leap(p, t, x, u, h, scratch, scratch.rows[1], True, out)
        return out, 2

    def continue_step(self, p, t, x, u, h, scratch, begins, out):
        """Fill `out` with the state one step after (t, x), by the derivative left over.

        The step before has left it in the scratch.

        There is none where a period begins: inputs may jump.

        Returns:
            (number of evaluations, how many numbers of the state, squared, are not finite)
        """
        overflows = leap(p, t, x, u, h, scratch, scratch.rows[CARRIED], begins, out)
        return 2 if begins else 1, overflows


def kick(n, out, x, rate, h):
    """Fill the first n of `out` with x after a time h; return how many squares are not finite.

    They are counted while they are at hand: what reads them again waits until they are stored.
    """
    overflows = 0
    for i in simd_range(n):
        out[i] = x[i] + h * rate[i]
        overflows += 0 if out[i] * out[i] < inf else 1
    return overflows


@elementwise
def kick_twice(x, rate, h):
    """Fill x after times h and 2 h."""
    middle = x + h * rate
    return middle, middle + h * rate


@routine
def leap(p, t, x, u, h, scratch, rate, first, out):
    """Write the state one step after (t, x) to `out`, its derivative to `rate`.

    It returns how many numbers of the state, squared, are not finite.

    Args:
        p, t, x, u, h, scratch, out: as of `take_step`.
        rate: row of the scratch with the derivative at (t, x).
        first: whether that is not in it yet.
    """
    n, middle, half = position_count(p), scratch.rows[0], 0.5 * h
    if first:
        rhs_into(p, t, x, u, rate, scratch.work)
    use_wide_vectors()
    others = len(x) - n  # velocities and what is behind them
    kick_twice(others, (middle[n:], out[n:]), (x[n:], rate[n:], half))
    overflows = kick(n, out, x, middle[n:], h)
    rhs_into(p, t + h, out, u, rate, scratch.work)
    return overflows + kick(others, out[n:], middle[n:], rate[n:], half)
