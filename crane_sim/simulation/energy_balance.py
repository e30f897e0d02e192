"""Energy balance of a run: its energy less the initial one and the supplied one, which should be zero.

The balance is of energies relative to the base. It sees errors that change the energy, and only those: a state that is
wrong along the surface of its energy, such as a swing that is late, passes unseen. A small one does not prove a run.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.jit import LIGHT, entry_point, optimisation

Array = npt.NDArray[np.float64]


class Balance(NamedTuple):
    """The sums of one run; of many runs, each array is a column."""

    start: Any  # (2,) J: the energy at the start, and what was supplied without being measured
    work: Any  # (2,) J of held efforts: the sum and its rounding error (Neumaier)
    last: Any  # (2, nu), positions and efforts of the last instant
    extremes: Any  # (4,) J: largest error and kinetic energy, lowest and highest potential
    count: Any  # (1,) instants


def empty_balance(nu: int, *runs: int) -> Balance:
    """Return the sums before the first instant, the energy at the start 0, of nu actuated joints."""
    extremes = np.zeros((*runs, 4))
    extremes[..., 2:] = np.inf, -np.inf
    count = np.zeros((*runs, 1), np.int64)
    return Balance(np.zeros((*runs, 2)), np.zeros((*runs, 2)), np.zeros((*runs, 2, nu)), extremes, count)


def work_up_to(work, last, q):
    """Return (sum, rounding error) [J] of the work of held efforts up to positions q (nu,)."""
    done = 0.0
    for j in range(len(q)):
        done += last[1, j] * (q[j] - last[0, j])
    return add_compensated(work[0], work[1], done)


def add_compensated(total, lost, term):
    """Return (sum, its rounding error) with one more term (Neumaier)."""
    after = total + term
    missed = (total - after) + term if abs(total) >= abs(term) else (term - after) + total
    return after, lost + missed


def work_instant(balance, metered, q, u, supplied):
    """Take the work of one instant into the sums; return what was supplied up to it [J]."""
    if not metered and balance.count[0] > 0:
        balance.work[0], balance.work[1] = work_up_to(balance.work, balance.last, q)
    balance.last[0], balance.last[1] = q, u
    balance.count[0] += 1
    return supplied if metered else balance.work[0] + balance.work[1]


def balance_instant(balance, metered, q, u, supplied, kinetic, potential):
    """Take one instant into the sums; arguments of `balance_instants`."""
    done = work_instant(balance, metered, q, u, supplied)
    start, extremes = balance.start, balance.extremes
    error = kinetic + potential - start[0] - (start[1] + done)
    extremes[0] = max(extremes[0], abs(error))
    extremes[1] = max(extremes[1], kinetic)
    extremes[2], extremes[3] = min(extremes[2], potential), max(extremes[3], potential)


@entry_point
@optimisation(LIGHT)
def balance_instants(balance, metered, q, u, supplied, kinetic, potential):
    """Take K instants into the sums, one a period.

    Args:
        balance: `Balance` of one run.
        metered: whether the model's meter tells what is supplied, and not the work of held efforts.
        q: positions of the actuated joints (K, nu).
        u: efforts held from each instant on (K, nu).
        supplied: readings of the meter (K,) [J].
        kinetic, potential: energies relative to the base (K,) [J].
    """
    for i in range(len(q)):
        balance_instant(balance, metered, q[i], u[i], supplied[i], kinetic[i], potential[i])


@entry_point
@optimisation(LIGHT)
def supplied_up_to(balance, metered, q, supplied):
    """Return the energy [J] supplied up to positions q (nu,), where the meter reads `supplied` [J]."""
    if metered or balance.count[0] == 0:
        return balance.start[1] + supplied
    total, lost = work_up_to(balance.work, balance.last, q)
    return balance.start[1] + (total + lost)


@entry_point
@optimisation(LIGHT)
def balance_errors(balance, metered, q, energy, supplied):
    """Return (energy error at the end, the largest of all instants), relative to the range of the energies.

    Args:
        balance: `Balance` of one run.
        metered: as for `balance_instants`.
        q: positions of the actuated joints at the end (nu,).
        energy: relative to the base at the end [J].
        supplied: the meter's reading at the end [J].
    """
    if balance.count[0] == 0:
        return 0.0, 0.0
    extremes = balance.extremes
    worst, kinetic, lowest, highest = extremes[0], extremes[1], extremes[2], extremes[3]
    end = abs(energy - balance.start[0] - supplied_up_to(balance, metered, q, supplied))
    swung = kinetic + highest - lowest
    scale = max(swung, 1e-9 * max(abs(lowest), abs(highest)), 1e-12)
    return end / scale, max(end, worst) / scale


class EnergyBalance:
    """The balance of one run, from its instants in order: the same bits however many come at once."""

    def __init__(self, energy: float, metered: bool, nu: int) -> None:
        """Begin with an energy [J]; the model is `with_meter`, or the work of held efforts is all that is supplied."""
        self._balance, self._metered = empty_balance(nu), metered
        self._balance.start[0] = energy

    def extend(self, q: Array, u: Array, supplied: Array, kinetic: Array, potential: Array) -> None:
        """Take K instants; arguments of `balance_instants`."""
        rows = (np.ascontiguousarray(part) for part in (q, u, supplied, kinetic, potential))
        balance_instants(self._balance, self._metered, *rows)

    def change(self, q: Array, energy: float, metered: bool) -> None:
        """Continue from positions q (nu,) with another model, which supplies `energy` [J]."""
        if metered and not self._metered:  # the work of held efforts ends here
            self._balance.start[1] = supplied_up_to(self._balance, False, q, 0.0)
        self._balance.start[1] += energy
        self._metered = metered

    def errors(self, q: Array, energy: float, supplied: float) -> tuple[float, float]:
        """Return (energy error at the end, the largest of all instants); arguments of `balance_errors`."""
        return balance_errors(self._balance, self._metered, q, float(energy), float(supplied))
