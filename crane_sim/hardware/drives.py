"""Actuators: what becomes of a demand on its way to a joint, within the equations.

A board (rows, nu) holds everything about the drives of a run, one column for each actuated joint. A demand is delayed,
passes a dead band, is limited, and is then followed by u' = (demand - u) / lag, never faster than the rate limit. A
demand is held for a period, so that equation has a solution in closed form: a ramp while the rate limit binds, then an
exponential. The effort is that function of time, not a staircase.
"""

from math import exp
from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.hardware.brakes import EFFORT, HELD, POSITION, VELOCITY, compute_brake_effort
from crane_sim.numerics.arrays import store
from crane_sim.numerics.jit import lean_kernel, routine

ORIGIN, TARGET, FACTOR = 9, 10, 11
"""Rows: effort where the period began, effort that is approached, what part of its effort the drive delivers."""
RATE, LAG, LOW, HIGH, DEADBAND, DELAY = 12, 13, 14, 15, 16, 17
"""Rows: limit of |u'| [1/s of the effort], s, limits of the effort, demands below this do nothing, periods."""
DRIVE_ROWS = 18
NEUTRAL = {FACTOR: 1.0, RATE: np.inf, LOW: -np.inf, HIGH: np.inf}
"""What a drive without any effect has in these rows; in others it has 0."""


class Drives(NamedTuple):
    """The source of a period: drives that approach their demands, and brakes."""

    begin: float  # s, of the period
    board: Any  # (DRIVE_ROWS, nu)


@lean_kernel
def ramp_time(far, rate, lag):
    """Return for how long [s] the rate limit binds a drive whose demand is `far` away."""
    return max(0.0, far / rate - lag)


@lean_kernel
def effort_at(board, i, s):
    """Return the effort of drive i, s seconds after the begin of the period."""
    origin, target, rate, lag = board[ORIGIN, i], board[TARGET, i], board[RATE, i], board[LAG, i]
    way = target - origin
    far, direction = abs(way), 1.0 if way >= 0.0 else -1.0
    ramp = ramp_time(far, rate, lag)
    if s < ramp:
        return origin + direction * rate * s
    if lag == 0.0:
        return target
    left = far if ramp == 0.0 else rate * lag
    return target - direction * left * exp(-(s - ramp) / lag)


@system.effort.register(Drives)
def _(u, p, t, x):
    return drive_efforts(p, u.board, t - u.begin, x)


@routine
def drive_efforts(p, board, s, x):
    """Return the efforts (nu,) of drives and brakes in state x, s seconds after the begin of the period."""
    q, v = system.actuated_joints(p, x)
    store(board, POSITION, 0, q)
    store(board, VELOCITY, 0, v)
    for i in range(board.shape[1]):
        drive = board[FACTOR, i] * effort_at(board, i, s)
        board[EFFORT, i] = compute_brake_effort(board, i) if board[HELD, i] > 0.0 else drive
    return system.saturate(p, system.efforts_from_row(p, board[EFFORT]))


@routine
def accept_command(p, board, queue, k, demand):
    """Let the drives have the demand (nu,) of period k; return whether a limit changed one."""
    depth, limited = len(queue), False
    store(queue, k % depth, 0, demand)
    if k == 0:  # before the start the first demand was given all along
        for d in range(depth):
            store(queue, d, 0, demand)
    for i in range(board.shape[1]):
        given = queue[(k - int(board[DELAY, i])) % depth, i]
        given = 0.0 if abs(given) < board[DEADBAND, i] else given
        board[EFFORT, i] = given
        board[TARGET, i] = min(max(given, board[LOW, i]), board[HIGH, i])
    store(board, TARGET, 0, system.saturate(p, system.efforts_from_row(p, board[TARGET])))
    for i in range(board.shape[1]):
        limited = limited or board[TARGET, i] != board[EFFORT, i]
        board[ORIGIN, i] = board[TARGET, i] if k == 0 else board[ORIGIN, i]
    return limited


@lean_kernel
def next_breakpoint(u, t, end):
    """Return the first time after t [s] at which a rate limit stops binding, `end` if there is none before it."""
    board, least = u.board, 1e-9 * (end - u.begin)  # s: nearer to either end a kink is none
    for i in range(board.shape[1]):
        far = abs(board[TARGET, i] - board[ORIGIN, i])
        kink = u.begin + ramp_time(far, board[RATE, i], board[LAG, i])
        if board[HELD, i] == 0.0 and t + least < kink < end - least:
            end = kink
    return end


@routine
def latch(p, u, t, x):
    """Note where the drives are at the end of a period, time t [s] and state x."""
    efforts = system.effort(u, p, t, x)
    store(u.board, EFFORT, 0, efforts)
    for i in range(u.board.shape[1]):
        held = u.board[HELD, i] > 0.0
        u.board[ORIGIN, i] = u.board[EFFORT, i] if held else effort_at(u.board, i, t - u.begin)
