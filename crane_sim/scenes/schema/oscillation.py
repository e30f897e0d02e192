"""Largest frequencies and decay rates of small oscillations: what a fixed step has to bear."""

from collections.abc import Sequence
from typing import Any

import numpy as np


def row_frequency(springs: Any, inverse_masses: Any) -> float:
    """Return the largest frequency [rad/s] of a row of bodies with springs between neighbours.

    Args:
        springs: stiffnesses (N,) [N/m].
        inverse_masses: of the bodies (N+1,) [1/kg].
    """
    inverse = np.sqrt(inverse_masses)
    diagonal = np.append(springs, 0.0) + np.append(0.0, springs)
    # here: few scenes ask, and it takes long to import
    from scipy.linalg import eigvalsh_tridiagonal

    values = eigvalsh_tridiagonal(diagonal * inverse**2, -springs * inverse[1:] * inverse[:-1])
    return float(np.sqrt(values[-1]))


def swing_frequency(
    lengths: Sequence[float], masses: Sequence[float], mobility: float, load: Any, gravity: float
) -> float:
    """Return a bound [rad/s] of the frequencies of a cable that hangs still.

    Tensions keep the links upright as springs between their ends. A body's attachment, at the
    distance d from its centre, has the mobility 1 / m + d² / I, and its weight keeps the body
    upright by m g d.

    Args:
        lengths: of rope and further links (N,) [m].
        masses: of the further links' nodes (N-1,) [kg].
        mobility: of the rope's upper end [1/kg].
        load: group `payload` of a file.
        gravity: m/s².
    """
    tensions = gravity * np.cumsum([load.mass, *reversed(masses)])[::-1]
    turned = upright = 0.0
    if load.inertia is not None and load.attachment is not None:
        distance, inertia = (
            float(np.linalg.norm(load.attachment)),
            float(np.linalg.eigvalsh(load.inertia)[0]),
        )
        turned, upright = distance**2 / inertia, gravity * load.mass * distance / inertia
    inverse_masses = [mobility, *(1.0 / mass for mass in masses), 1.0 / load.mass + turned]
    return float(np.hypot(row_frequency(tensions / lengths, inverse_masses), np.sqrt(upright)))
