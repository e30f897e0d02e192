"""Explicit Runge-Kutta stages from a tableau that is data.

A tableau has rows a (one per stage after the first), nodes c and weights b. Structural zeros are None and cost nothing.
"""

from typing import Any

from numba.extending import overload

from crane_sim.jit import OPTIONS, kernel
from crane_sim.state_algebra import add, combine
from crane_sim.system import rhs


def slopes(p: Any, t: float, x: Any, u: Any, h: float, a: tuple, c: tuple, ks: tuple) -> tuple:
    """Return all stage derivatives, given the first ones `ks` and the rows `a` and nodes `c` of the stages to come."""
    for row, node in zip(a, c, strict=True):
        ks = (*ks, rhs(p, t + node * h, add(x, combine(h, row, ks)), u))
    return ks


@overload(slopes, jit_options=OPTIONS)
def _slopes(p, t, x, u, h, a, c, ks):
    if len(a) == 0:
        return lambda p, t, x, u, h, a, c, ks: ks

    def next_stage(p, t, x, u, h, a, c, ks):
        k = rhs(p, t + c[0] * h, add(x, combine(h, a[0], ks)), u)
        return slopes(p, t, x, u, h, a[1:], c[1:], (*ks, k))

    return next_stage


@kernel
def explicit_step(p, t, x, u, h, a, c, b):
    """Return the state one step of the tableau (a, c, b) after (t, x)."""
    return add(x, combine(h, b, slopes(p, t, x, u, h, a, c, (rhs(p, t, x, u),))))
