"""Explicit Runge-Kutta stages from a tableau that is data.

A tableau has rows a (one per stage after the first), nodes c and weights b. Structural zeros are None and cost nothing.
"""

from crane_sim.jit import kernel
from crane_sim.state_algebra import add, combine
from crane_sim.system import rhs


@kernel
def slope(p, t, x, u, h, row, node, ks):
    """Return the derivative at the stage with this row and node, given those of the stages before, `ks`."""
    return rhs(p, t + node * h, add(x, combine(h, row, ks)), u)


@kernel
def moved(x, h, b, ks):
    """Return the state x moved by the weighted stage derivatives."""
    return add(x, combine(h, b, ks))
