"""Looking for guards that fail in a step: at even distances, at states interpolated between its ends.

Where guards need positions and time alone, as a model that switches says (`system.Switching`), their cubic Hermite
interpolation needs but the velocities, which stand in the states at both ends: then nothing is evaluated here.
"""

import numpy as np

from crane_sim.integrators.flow import MOST_STAGES, Scratch
from crane_sim.jit import generic, kernel, lean_generic, lean_routine
from crane_sim.state_algebra import add, add_scaled, replaced, scale
from crane_sim.system import fill, guard, rhs

FIRST, SECOND, BETWEEN = MOST_STAGES + 1, MOST_STAGES + 2, MOST_STAGES + 3  # rows of a scratch
LOOKS = 4
"""Instants of a step at which the guards are looked at; the last one is its end."""


@generic
def ends(scratch, p, u, flow, positions):
    """Return the derivatives at both ends of the last step, all or only of the positions; of arrays as rows.

    These are the rows from `MOST_STAGES` + 1 on; the third one is to be filled with a state between.
    """
    if positions > 0:
        return coasting(flow.x0, positions), coasting(flow.x, positions)
    return rhs(p, flow.t0, flow.x0, u), rhs(p, flow.t, flow.x, u)


@ends.register(Scratch)
def _(scratch, p, u, flow, positions):
    fill_ends(scratch.rows, p, u, flow, positions, scratch.work)
    return scratch.rows


@lean_routine
def fill_ends(board, p, u, flow, positions, work):
    """Write the two derivatives of `ends` into their rows of the board."""
    if positions > 0:
        for i in range(len(flow.x)):
            moves = i < positions
            board[FIRST, i] = flow.x0[positions + i] if moves else 0.0
            board[SECOND, i] = flow.x[positions + i] if moves else 0.0
    else:
        fill(p, flow.t0, flow.x0, u, board[FIRST], work)
        fill(p, flow.t, flow.x, u, board[SECOND], work)


@kernel
def coasting(x, positions):
    """Return the derivative of a state whose velocities do not change.

    It is a flat tuple of so many positions and their velocities; or two of these, each half positions.
    """
    return coasted(x[0], x, positions)


@generic
def coasted(first, x, positions):
    """Return what `coasting` does, for a state whose first entry is `first`."""
    rate = scale(0.0, x)
    for i in range(positions):
        rate = replaced(rate, i, x[positions + i])
    return rate


@coasted.register(tuple)
def _(first, x, positions):
    second, rest = x[1], scale(0.0, x)
    return (coasted(first[0], first, len(first) // 2), coasted(second[0], second, len(second) // 2), *rest[2:])


@lean_generic
def guard_between(x, p, u, flow, slopes, s, work):
    """Return the guard at the part s of the last step to x, by cubic Hermite interpolation; slopes as of `ends`."""
    h, rise, (f0, f1) = flow.t - flow.t0, add_scaled(x, -1.0, flow.x0), slopes
    bend = add(scale((s - 1.0) * h, f0), scale(s * h, f1))
    bend = add_scaled(bend, 1.0 - 2.0 * s, rise)
    return guard(p, flow.t0 + s * h, add(add_scaled(flow.x0, s, rise), scale(s * (s - 1.0), bend)), u, work)


@guard_between.register(np.ndarray)
def _(x, p, u, flow, slopes, s, work):
    h = flow.t - flow.t0
    for i in range(len(x)):
        rise = x[i] - flow.x0[i]
        bend = (s - 1.0) * h * slopes[FIRST, i] + s * h * slopes[SECOND, i] + (1.0 - 2.0 * s) * rise
        slopes[BETWEEN, i] = flow.x0[i] + s * rise + s * (s - 1.0) * bend
    return guard(p, flow.t0 + s * h, slopes[BETWEEN], u, work)


@lean_routine
def suspect(p, u, flow, slopes, work, look):
    """Return (the first look from `look` on at which a guard seems to fail, LOOKS + 1 if none does, evaluations)."""
    n = 0
    for j in range(look, LOOKS):
        value, _, more = guard_between(flow.x, p, u, flow, slopes, j / LOOKS, work)
        n += more
        if value < 0.0:
            return j, n
    value, _, more = guard(p, flow.t, flow.x, u, work)
    return LOOKS if value < 0.0 else LOOKS + 1, n + more
