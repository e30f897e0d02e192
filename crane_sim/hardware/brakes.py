"""Brakes: friction that sticks by a spring and slips at its capacity, one on every actuated joint.

A brake pulls its joint to a reference with a spring and a damper, both together never more than its capacity; where
the spring alone would be stronger, the reference slips along. It slips at the ends of periods only: within one the
joint feels the capacity as long as it lies beyond. Such a pull is that of a potential, |pull| <= capacity, plus a
damper, and moving the reference only lowers that potential: a brake never gives more than its spring has stored.

Where an effort is no force the same element serves: it is an acceleration for a drive that imposes accelerations; a
drive that follows a rate is told zero; one that follows a position is told the one where it was (`FOLLOWS`).
"""

from crane_sim.numerics.jit import lean_kernel

STIFFNESS, DAMPING, CAPACITY, FOLLOWS, ANCHOR, HELD = 0, 1, 2, 3, 4, 5
"""Rows of the board of drives: of brakes; 1 for a drive told its reference; joint's; 1 while the brake holds it."""
EFFORT, POSITION, VELOCITY = 6, 7, 8
"""Rows that evaluations fill."""


@lean_kernel
def within(value, bound):
    """Return the value moved into -bound .. bound."""
    return min(max(value, -bound), bound)


@lean_kernel
def compute_brake_effort(board, i):
    """Return the effort of brake i on its joint, whose position and velocity are on the board."""
    pull = board[STIFFNESS, i] * (board[ANCHOR, i] - board[POSITION, i]) - board[DAMPING, i] * board[VELOCITY, i]
    return board[FOLLOWS, i] * board[ANCHOR, i] + within(pull, board[CAPACITY, i])


@lean_kernel
def engage(board, i, effort):
    """Put the reference of brake i where its spring takes over the effort that the drive had, as far as it can."""
    board[ANCHOR, i] = board[POSITION, i]
    if board[STIFFNESS, i] > 0.0:
        board[ANCHOR, i] += within(effort, board[CAPACITY, i]) / board[STIFFNESS, i]


@lean_kernel
def slip(board, i):
    """Draw the reference of brake i along, where its spring is stretched beyond the capacity."""
    if board[STIFFNESS, i] > 0.0:
        reach = board[CAPACITY, i] / board[STIFFNESS, i]
        board[ANCHOR, i] = board[POSITION, i] + within(board[ANCHOR, i] - board[POSITION, i], reach)
