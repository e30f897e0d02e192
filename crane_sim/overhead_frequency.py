"""The fastest small oscillation of an overhead crane: what a fixed step has to bear."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigvalsh_tridiagonal

from crane_sim.overhead_start import filled

if TYPE_CHECKING:
    from crane_sim.overhead_scene import OverheadFile

Array = npt.NDArray[np.float64]


def stiffest(file: "OverheadFile") -> float:
    """Return the largest angular frequency [rad/s] of the cable that hangs still, or the largest initial rate."""
    masses, lengths = np.array(file.parts.masses), np.array(file.parts.lengths)
    rates = max((float(np.linalg.norm(rate)) for rate in file.parts.rates), default=0.0)
    if file.modelled == "straight":
        reach = np.cumsum(lengths)
        return max(rates, float(np.sqrt(file.gravity * (masses @ reach) / (masses @ reach**2))))
    tension = file.gravity * np.cumsum(masses[::-1])[::-1]
    across = tension / lengths
    found = [rates, _largest(file, across)]
    if file.modelled == "elastic" and file.cable.stiffness is not None:
        stiffness = np.array(filled(file.cable.stiffness, len(lengths), "cable.stiffness"))
        found.append(_largest(file, stiffness))
    joints = file.joints or file.cable.joints
    if joints is not None:  # a bound: no node feels more than four times two neighbours' moments
        bending = max(joints.stiffness) / (np.min(masses) * np.min(lengths) ** 2)
        found.append(float(np.hypot(found[1], 4.0 * np.sqrt(bending))))
    return max(found)


def _largest(file: "OverheadFile", springs: Array) -> float:
    """Return the largest frequency of trolley and nodes, neighbours of which are joined by `springs` (N,) [N/m]."""
    trolley = file.trolley.mass if file.trolley.drive == "force" else None
    inverse = np.sqrt(1.0 / np.array([trolley or np.inf, *file.parts.masses]))
    diagonal = np.append(springs, 0.0) + np.append(0.0, springs)
    values = eigvalsh_tridiagonal(diagonal * inverse**2, -springs * inverse[1:] * inverse[:-1])
    return float(np.sqrt(values[-1]))
