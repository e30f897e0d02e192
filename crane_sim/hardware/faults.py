"""Faults: which are there in a period, by their times or because somebody said so."""

from typing import Any, NamedTuple

from crane_sim.hardware.brakes import HELD, engage
from crane_sim.hardware.drives import FACTOR, ORIGIN
from crane_sim.hardware.sensors import LOST, STUCK
from crane_sim.numerics.jit import routine

KINDS = ("sensor_stuck", "sensor_loss", "effort_loss", "stuck", "payload")
"""Names of the kinds of faults; kernels know them by their places here."""
SENSOR_STUCK, SENSOR_LOSS, EFFORT_LOSS, JOINT_STUCK, PAYLOAD = range(5)
AS_PLANNED = -1.0
"""An order that leaves a fault to its times; others are 0, off, and 1, on."""


class Faults(NamedTuple):
    """The faults that a scene may have (n,)."""

    kind: Any  # index in KINDS
    place: Any  # index of the joint, of the actuated joint for faults of drives
    value: Any  # factor of the effort, mass of the payload [kg]
    begin: Any  # s; infinite: waits for an order
    end: Any  # s


class Log(NamedTuple):
    """What happened to faults."""

    rows: Any  # (capacity, 3): s, number of the fault, 1 on or 0 off
    total: Any  # (1,), how many happened


@routine
def update_active(faults, orders, present, log, t, slack):
    """Fill `present` (n,) with 1 for the faults that are there at time t [s], and log what changed.

    A fault is there in every period that begins at or after its time; `slack` [s] is what rounding may take from t.
    """
    for i in range(len(present)):
        planned = faults.begin[i] <= t + slack < faults.end[i]
        now = orders[i] if orders[i] != AS_PLANNED else 1.0 if planned else 0.0
        if now != present[i]:
            n = int(log.total[0])
            if n < len(log.rows):
                log.rows[n, 0], log.rows[n, 1], log.rows[n, 2] = t, i, now
            log.total[0] += 1.0
            present[i] = now


@routine
def apply_to_sensors(faults, present, signals):
    """Let the faults that are there act on the sensors."""
    nq = signals.shape[1] // 2
    for j in range(2 * nq):
        signals[STUCK, j], signals[LOST, j] = 0.0, 0.0
    for i in range(len(present)):
        row = STUCK if faults.kind[i] == SENSOR_STUCK else LOST
        if present[i] > 0.0 and faults.kind[i] <= SENSOR_LOSS:
            signals[row, int(faults.place[i])] = 1.0
            signals[row, int(faults.place[i]) + nq] = 1.0


@routine
def apply_to_drives(faults, present, board, braking):
    """Let the faults that are there act on the drives, and all brakes if `braking`; POSITION is on the board."""
    for j in range(board.shape[1]):
        held, factor = braking, 1.0
        for i in range(len(present)):
            if present[i] > 0.0 and faults.place[i] == j:
                factor = faults.value[i] if faults.kind[i] == EFFORT_LOSS else factor
                held = held or faults.kind[i] == JOINT_STUCK
        if held and board[HELD, j] == 0.0:
            engage(board, j, board[FACTOR, j] * board[ORIGIN, j])
        board[HELD, j], board[FACTOR, j] = 1.0 if held else 0.0, factor


@routine
def payload_mass(faults, present, mass):
    """Return the payload's mass [kg] with the faults that are there: `mass` without one, else the last one's."""
    for i in range(len(present)):
        if present[i] > 0.0 and faults.kind[i] == PAYLOAD:
            mass = faults.value[i]
    return mass
