"""Sensors: what a law and everybody else gets to see of the joints.

A board (rows, 2 nq) holds the positions' sensors, then the velocities'. At a period whose number is a multiple of
`EVERY` a sensor takes a sample: the truth plus bias and noise, rounded to its step; some samples are lost, and the last
one stays. What is shown is `DELAY` periods old. Chance is drawn by the number of the period (`chance`).
"""

from math import floor

from crane_sim.hardware.random import normal, uniform
from crane_sim.numerics.jit import lean_kernel, routine

NOISE, BIAS, QUANTUM, DELAY, EVERY, DROPOUT = 0, 1, 2, 3, 4, 5
"""Rows: standard deviation, offset, step of the digits (0: none), periods, periods, chance that a sample is lost."""
TRUTH, SAMPLE, SHOWN, STUCK, LOST = 6, 7, 8, 9, 10
"""Rows: joint coordinate, last sample, what is shown, 1 while a sensor shows what it showed, or shows zero."""
SENSOR_ROWS = 11
STREAMS = 3  # of chance, for each signal


@lean_kernel
def measure_signal(seed, board, j, k):
    """Return a sample of signal j at period k."""
    value = board[TRUTH, j] + board[BIAS, j]
    if board[NOISE, j] > 0.0:
        value += board[NOISE, j] * normal(seed, STREAMS * j, k)
    step = board[QUANTUM, j]
    return step * floor(value / step + 0.5) if step > 0.0 else value


@routine
def sense(seed, board, ring, k, q, v):
    """Let the sensors see the joints at period k; return how many samples were lost.

    Args:
        seed: a word.
        board: of the sensors; its row SHOWN is filled.
        ring: the last samples (depth, 2 nq), as many as the longest delay needs.
        k: number of the period that begins.
        q, v: joint positions and velocities (nq,).
    """
    nq, depth, losses = len(q), len(ring), 0
    for j in range(nq):
        board[TRUTH, j], board[TRUTH, j + nq] = q[j], v[j]
    for j in range(2 * nq):
        due = k % int(board[EVERY, j]) == 0
        lost = due and k > 0 and uniform(seed, STREAMS * j + 2, k) < board[DROPOUT, j]
        losses += 1 if lost else 0
        if due and not lost:
            board[SAMPLE, j] = measure_signal(seed, board, j, k)
        ring[k % depth, j] = board[SAMPLE, j]
        if k == 0:  # before the start the first sample was shown all along
            for d in range(depth):
                ring[d, j] = board[SAMPLE, j]
        if board[STUCK, j] == 0.0:
            board[SHOWN, j] = ring[(k - int(board[DELAY, j])) % depth, j]
        if board[LOST, j] > 0.0:
            board[SHOWN, j] = 0.0
    return losses
