"""The leapfrog method of Störmer and Verlet, order 2 with a fixed step, for models whose state is an array.

    w = v + h/2 a,  x' = x + h w,  a' = a(t + h, x', w + h/2 a),  v' = w + h/2 a'

It is stable up to h = 2 / frequency at one evaluation a step, which no Runge-Kutta method is at the price: the cheapest
method where two to four digits do and a light cable's whipping, not its error, limits the step. Accelerations that
depend on velocities see them extrapolated, with an error of order h². Hairer, Lubich, Wanner, "Geometric Numerical
Integration", 2nd ed., I.1.4.
"""

from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.integrators.array_steps import advance_array, step_into, take_array_steps
from crane_sim.integrators.integration import MAX_STAGES, equal_step, explicit_step, stages, status_of
from crane_sim.numerics.jit import routine, use_wide_vectors
from crane_sim.numerics.rows import elementwise
from crane_sim.system import position_count, project_in_place, rhs_into

CARRIED = MAX_STAGES + 4  # row of a scratch: the derivative that the next step begins with


class Leapfrog(NamedTuple):
    """Order 2 with a fixed step, one evaluation each (two beside events): for light cables in rigid links."""

    step: Positive  # s, shortened so that a whole number fills each control period; without control it may span several

    def safe_step(self, frequency: float) -> float:
        """Return half the largest step [s] that is stable for motions up to `frequency` [rad/s]."""
        return 1.0 / frequency


@elementwise
def kick(x, rate, h):
    """Fill x after a time h."""
    return (x + h * rate,)


@elementwise
def kick_twice(x, rate, h):
    """Fill x after times h and 2 h."""
    middle = x + h * rate
    return middle, middle + h * rate


@routine
def leap(p, t, x, u, h, scratch, rate, first, out):
    """Write the state one step after (t, x) into `out`, and the derivative there into `rate`.

    Args:
        p, t, x, u, h, scratch, out: as of `explicit_step`.
        rate: row of the scratch with the derivative at (t, x).
        first: whether that is not in it yet.
    """
    n, middle, half = position_count(p), scratch.rows[0], 0.5 * h
    if first:
        rhs_into(p, t, x, u, rate, scratch.work)
    use_wide_vectors()
    others = len(x) - n  # velocities and what is behind them
    kick_twice(others, (middle[n:], out[n:]), (x[n:], rate[n:], half))
    kick(n, (out,), (x, middle[n:], h))
    rhs_into(p, t + h, out, u, rate, scratch.work)
    kick(others, (out[n:],), (middle[n:], rate[n:], half))


@explicit_step.register(Leapfrog)
def _(method, p, t, x, u, h, scratch, out):
    leap(p, t, x, u, h, scratch, scratch.rows[1], True, out)  # a sample's, between steps that carry theirs


@stages.register(Leapfrog)
def _(method):
    return 2  # of a step by itself


@step_into.register(Leapfrog)
def _(method, scratch, p, t, x, u, h, end, out):
    """Take over the derivative of the step before, whose size is h; none, 0, where a period begins: inputs may jump."""
    size, after = equal_step(method.step, t, end)
    leap(p, t, x, u, size, scratch, scratch.rows[CARRIED], h == 0.0, out)
    project_in_place(p, out)
    return after, 0.0 if after == end else size, 2 if h == 0.0 else 1, 0, status_of(out)


@take_array_steps.register(Leapfrog)
def _(method, p, u, integration, t, end):
    return advance_array(method, p, u, integration, t, end)
