"""Energy balance of a run: its energy less the initial and the supplied one, ideally zero.

The balance is of energies relative to the base. It sees errors that change the energy, and only
those: a state that is wrong along the surface of its energy, such as a swing that is late, passes
unseen. A small one does not prove a run.
"""

from typing import Any, NamedTuple

import numpy as np


class Balance(NamedTuple):
    """The sums of one run; of many runs, each array is a column."""

    start: Any  # (2,) J: the energy at the start, and what was supplied without being measured
    work: Any  # (2,) J of held efforts: the sum and its rounding error (Neumaier)
    supplied: Any  # (1,) J up to the last instant, besides `start`
    last: Any  # (2, nu), positions and efforts of the last instant
    extremes: Any  # (4,) J: largest error and kinetic energy, lowest and highest potential
    count: Any  # (1,) instants
    errors: Any  # (2,), of the end and the largest of all instants, relative to the range of the
    # energies


def empty_balance(nu: int, *runs: int) -> Balance:
    """Return the sums of nu actuated joints before the first instant; the start's energy is 0."""
    extremes = np.zeros((*runs, 4))
    extremes[..., 2:] = np.inf, -np.inf
    start, work, supplied = np.zeros((*runs, 2)), np.zeros((*runs, 2)), np.zeros((*runs, 1))
    last, count = np.zeros((*runs, 2, nu)), np.zeros((*runs, 1), np.int64)
    return Balance(start, work, supplied, last, extremes, count, np.zeros((*runs, 2)))


def work_up_to(balance, watched, q):
    """Return (sum, rounding error) [J] of the work of held efforts up to positions q (nq,)."""
    done, last = 0.0, balance.last
    for j in range(len(watched.driven)):
        done += last[1, j] * (q[watched.driven[j]] - last[0, j])
    return add_compensated(balance.work[0], balance.work[1], done)


def add_compensated(total, lost, term):
    """Return (sum, its rounding error) with one more term (Neumaier)."""
    after = total + term
    missed = (total - after) + term if abs(total) >= abs(term) else (term - after) + total
    return after, lost + missed


def add_work(balance, watched, q, u, metered):
    """Take what was supplied up to an instant into the sums.

    Args:
        balance: `Balance` of one run.
        watched: `totals.Watched` of the run.
        q: joint positions (nq,).
        u: efforts held from the instant on (nu,).
        metered: reading of the meter [J].
    """
    if not watched.metered:  # before the first instant no efforts are held
        balance.work[0], balance.work[1] = work_up_to(balance, watched, q)
    for j in range(len(u)):
        balance.last[0, j], balance.last[1, j] = q[watched.driven[j]], u[j]
    balance.count[0] += 1
    balance.supplied[0] = metered if watched.metered else balance.work[0] + balance.work[1]


def add_energies(balance, kinetic, potential):
    """Take the energies [J] relative to the base at the last instant into the sums."""
    start, extremes = balance.start, balance.extremes
    error = kinetic + potential - start[0] - (start[1] + balance.supplied[0])
    extremes[0] = max(extremes[0], abs(error))
    extremes[1] = max(extremes[1], kinetic)
    extremes[2], extremes[3] = min(extremes[2], potential), max(extremes[3], potential)


def supplied_up_to(balance, watched, q, metered):
    """Return the energy [J] supplied up to positions q (nq,); the meter reads `metered` [J]."""
    if watched.metered or balance.count[0] == 0:
        return balance.start[1] + metered
    total, lost = work_up_to(balance, watched, q)
    return balance.start[1] + (total + lost)


def relative_errors(balance, watched, q, energy, metered):
    """Note the errors of a run that ends at positions q (nq,), relative to its energies' range.

    Args:
        balance, watched, q: of the run.
        energy: relative to the base at the end [J].
        metered: reading of the meter at the end [J].
    """
    if balance.count[0] > 0:
        extremes = balance.extremes
        worst, kinetic, lowest, highest = extremes[0], extremes[1], extremes[2], extremes[3]
        end = abs(energy - balance.start[0] - supplied_up_to(balance, watched, q, metered))
        swung = kinetic + highest - lowest
        scale = max(swung, 1e-9 * max(abs(lowest), abs(highest)), 1e-12)
        balance.errors[0], balance.errors[1] = end / scale, max(end, worst) / scale
    for j in range(len(watched.driven)):
        balance.last[0, j] = q[watched.driven[j]]
