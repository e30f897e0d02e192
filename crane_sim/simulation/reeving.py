"""Tensions of the falls of a rope that is reeved over sheaves."""

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
