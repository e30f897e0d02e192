"""Tensions of the falls of a rope that is reeved over sheaves, and their largest ones of a run."""

from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.numerics.jit import LIGHT, entry_point, optimisation

Array = npt.NDArray[np.float64]


@entry_point
@optimisation(LIGHT)
def fill_falls(p, t, q, v, u, out):
    """Fill `out` (K, n + 2) as `system.fall_tensions` does, at times t (K,) and joints q, v (K, nq), efforts u."""
    for i in range(len(q)):
        x = system.state(p, t[i], q[i], v[i])
        system.fall_tensions(p, t[i], x, system.efforts_from_row(p, u[i]), out, i)


def fall_tensions(model: Any, t: Array, q: Array, v: Array, u: Array) -> Array:
    """Return (K, n + 2) of a rope with n falls: lead line, falls [N] and the drum's torque [N m]; (K, 0) without one.

    Args:
        model: the crane.
        t, q, v, u: times (K,), positions and velocities of the joints (K, nq), efforts applied (K, nu).
    """
    falls = system.fall_count(model)
    out = np.empty((len(t), falls + 2 if falls else 0))
    if falls:
        fill_falls(model, *(np.ascontiguousarray(part, dtype=np.float64) for part in (t, q, v, u)), out)
    return out


class FallPeaks:
    """The largest tensions of falls and lead line, and the drum's largest torque."""

    def __init__(self) -> None:
        """Begin with nothing seen."""
        self._peaks: Array | None = None

    def extend(self, falls: Array) -> None:
        """Take K instants (K, n + 2) of `fall_tensions`."""
        if falls.size:
            peaks = np.abs(falls).max(axis=0)
            self._peaks = peaks if self._peaks is None else np.maximum(self._peaks, peaks)

    def summary(self) -> dict[str, Any]:
        """Return the metrics, at the start of every period; none without falls."""
        if self._peaks is None:
            return {}
        lead, *falls, torque = map(float, self._peaks)
        return {"max_lead_line_tension": lead, "max_fall_tensions": falls} | (
            {"max_drum_torque": torque} if torque else {}
        )
