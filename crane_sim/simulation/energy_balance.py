"""Energy balance of a run: its energy less the initial one and the supplied one, which should be zero.

The balance is of energies relative to the base. It sees errors that change the energy, and only those: a state that is
wrong along the surface of its energy, such as a swing that is late, passes unseen. A small one does not prove a run.
"""

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.jit import entry_point

Array = npt.NDArray[np.float64]


@entry_point
def add_work(total, q, u, work):
    """Add the work of held efforts, one period after the other, to a sum whose rounding error is kept beside it.

    Args:
        total: (2,) [J], the sum and its rounding error (Neumaier).
        q: positions (K + 1, nu) at the ends of the periods.
        u: efforts (K, nu) in them.
        work: to fill with the sum after each period (K,) [J].
    """
    for k in range(len(u)):
        done = 0.0
        for j in range(u.shape[1]):
            done += u[k, j] * (q[k + 1, j] - q[k, j])
        after = total[0] + done
        total[1] += (total[0] - after) + done if abs(total[0]) >= abs(done) else (done - after) + total[0]
        total[0] = after
        work[k] = total[0] + total[1]


class EnergyBalance:
    """The balance of one run, from its instants in order: the same bits however many come at once."""

    def __init__(self, energy: float, metered: bool) -> None:
        """Begin with an energy [J]; the model is `with_meter`, or the work of held efforts is all that is supplied."""
        self._begun, self._metered = energy, metered
        self._offset = 0.0  # J, energy that a meter does not measure
        self._total = np.zeros(2)
        self._last: tuple[Array, Array] | None = None  # positions and efforts of the last instant
        self._worst = 0.0
        self._kinetic, self._lowest, self._highest = 0.0, np.inf, -np.inf

    def extend(self, q: Array, u: Array, supplied: Array, kinetic: Array, potential: Array) -> None:
        """Take K instants, one a period.

        Args:
            q: positions of the actuated joints (K, nu).
            u: efforts held from each instant on (K, nu).
            supplied: readings of the meter (K,) [J].
            kinetic, potential: energies relative to the base (K,) [J].
        """
        work = supplied if self._metered else self._compute_work(q, u)
        self._last = q[-1].copy(), u[-1].copy()
        errors = kinetic + potential - self._begun - (self._offset + work)
        self._worst = max(self._worst, float(np.abs(errors).max()))
        self._kinetic = max(self._kinetic, float(kinetic.max()))
        self._lowest = min(self._lowest, float(potential.min()))
        self._highest = max(self._highest, float(potential.max()))

    def _compute_work(self, q: Array, u: Array) -> Array:
        """Return the work [J] up to each of K instants (K,)."""
        work = np.zeros(len(q))
        if self._last is None:
            add_work(self._total, np.ascontiguousarray(q), np.ascontiguousarray(u[:-1]), work[1:])
        else:
            before, held = self._last
            add_work(self._total, np.vstack([before, q]), np.vstack([held, u[:-1]]), work)
        return work

    def change(self, q: Array, energy: float, metered: bool) -> None:
        """Continue from positions q (nu,) with another model, which supplies `energy` [J]."""
        self._offset, self._metered = energy + self._supplied_energy(q, 0.0), metered

    def _supplied_energy(self, q: Array, supplied: float) -> float:
        """Return the energy [J] supplied up to positions q, where the meter reads `supplied` [J]."""
        if self._metered or self._last is None:
            return self._offset + supplied
        work, (before, held) = np.empty(1), self._last
        add_work(self._total.copy(), np.vstack([before, q]), held[None], work)
        return self._offset + float(work[0])

    def errors(self, q: Array, energy: float, supplied: float) -> tuple[float, float]:
        """Return (energy error at the end, the largest of all instants), relative to the range of the energies.

        Args:
            q: positions at the end (nu,).
            energy: relative to the base at the end [J].
            supplied: the meter's reading at the end [J].
        """
        if self._last is None:
            return 0.0, 0.0
        end = abs(float(energy) - self._begun - self._supplied_energy(q, float(supplied)))
        swung = self._kinetic + self._highest - self._lowest
        scale = max(swung, 1e-9 * max(abs(self._lowest), abs(self._highest)), 1e-12)
        return end / scale, max(end, self._worst) / scale
