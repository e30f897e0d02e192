"""The fastest small oscillation of an overhead crane: what a fixed step has to bear."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigvalsh_tridiagonal

from crane_sim.forms.overhead_start import filled

if TYPE_CHECKING:
    from crane_sim.forms.overhead import OverheadFile

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


def bending_error(file: "OverheadFile") -> float:
    """Return about how far [m] the payload strays within the run because a straight cable cannot bend.

    The nodes above it, m_c kg in all, bend the cable by their share of its tension, and push the payload by their share
    of its mass: (m_c / m_p)² of the way that it swings, more below a light trolley, and growing with the phase. The
    factors fit chains of ten links, 2 to 10 m long, from 0.1 to 1.2 rad (true errors were 0.2 to 0.8 of the estimate).
    """
    masses, length = np.array(file.parts.masses), float(np.sum(file.parts.lengths))
    swung = 1.0 + masses[-1] / _lightest_axis(file)
    frequency = float(np.sqrt(file.gravity / length * swung))
    rate = abs(float(file.parts.rates[0]))
    angle = abs(float(file.parts.turns[0])) + (rate / frequency if frequency else 0.0)
    share = float(np.sum(masses[:-1]) / masses[-1])
    return 0.3 * swung * share**2 * length * min(angle, np.pi) * (1.0 + frequency * file.duration / 20.0)


def _lightest_axis(file: "OverheadFile") -> float:
    """Return the smaller one of the masses [kg] that the cable can move along an axis; infinite where it moves none."""
    carried, found = file.trolley.mass or 0.0, [np.inf]
    if file.trolley.drive == "force":
        found.append(carried)
    if file.bridge is not None and file.bridge.drive == "force":
        found.append((file.bridge.mass or 0.0) + carried)
    return min(found)


def _largest(file: "OverheadFile", springs: Array) -> float:
    """Return the largest frequency of trolley and nodes, neighbours of which are joined by `springs` (N,) [N/m]."""
    inverse = np.sqrt(1.0 / np.array([_lightest_axis(file), *file.parts.masses]))
    diagonal = np.append(springs, 0.0) + np.append(0.0, springs)
    values = eigvalsh_tridiagonal(diagonal * inverse**2, -springs * inverse[1:] * inverse[:-1])
    return float(np.sqrt(values[-1]))
