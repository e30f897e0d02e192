"""Motion of a base: six functions of time, with their first two derivatives.

In the order surge, sway, heave [m], roll, pitch, yaw [rad]; `crane_sim.models.moving_base` says
what they mean.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import LIGHT, entry_point, optimisation, routine
from crane_sim.trajectories.piecewise import find_piece, polynomial_at

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


class Base(NamedTuple):
    """Each axis: offset + the sum of amplitude sin(frequency t + phase).

    Terms of amplitude 0 cost nothing.
    """

    offsets: Any  # (6,) m, rad
    amplitudes: Any  # (6, n) m, rad
    frequencies: Any  # (6, n) rad/s
    phases: Any  # (6, n) rad


class SplineBase(NamedTuple):
    """Each axis: polynomials between knots.

    The first and the last one hold beyond the ends as well.
    """

    knots: Any  # (k,) s, increasing, k >= 2
    coefficients: Any  # (6, k - 1, 6) of the powers 0 .. 5 of t - knots[piece]


class MountedBase(NamedTuple):
    """A base that stands somewhere on a vessel, turned against it; the vessel's motion is given.

    A point r of the base is position + M r on the vessel.
    """

    vessel: Any  # Base or SplineBase, of the vessel's reference point
    position: tuple[float, float, float]  # m, of the base's origin in the vessel's axes
    rows: tuple[tuple[float, float, float], ...]  # (3, 3) of M, which takes vectors of the base to
    # the vessel


AnyBase = Base | SplineBase | MountedBase
"""The motions that a base can have."""


def axis_at(base, t, i):
    """Return (position, velocity, acceleration) of axis i at time t [s], in m or rad."""
    if isinstance(base, SplineBase):
        piece = find_piece(base.knots, base.coefficients.shape[1], t)
        return polynomial_at(base.coefficients[i], piece, t - base.knots[piece])[:3]
    x, v, a = base.offsets[i], 0.0, 0.0
    for k in range(base.amplitudes.shape[1]):
        amplitude, w = base.amplitudes[i, k], base.frequencies[i, k]
        if amplitude != 0.0:
            s, c = sincos(w * t + base.phases[i, k])
            x += amplitude * s
            v += amplitude * w * c
            a -= amplitude * w * w * s
    return x, v, a


@routine
def base_motion_at(base, t):
    """Return (positions, velocities, accelerations) of the axes at time t [s], in m and rad.

    Each is a tuple (6,).
    """
    axes = [axis_at(base, t, i) for i in range(len(AXES))]
    return tuple([tuple([axis[k] for axis in axes]) for k in range(3)])


@entry_point
@optimisation(LIGHT)
def fill_positions(base, t, out):
    """Fill out (K, 6) with the positions of the six axes at times t (K,) [s]."""
    for i in range(len(t)):
        out[i] = base_motion_at(base, t[i])[0]


def base_positions(base: AnyBase, t: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the positions (K, 6) [m, rad] of a base at times t (K,) [s]."""
    out = np.empty((len(t), len(AXES)))
    if not isinstance(base, MountedBase):
        fill_positions(base, t, out)
        return out
    fill_positions(base.vessel, t, out)
    vessel = rotations(out[:, 3:])
    out[:, :3] += vessel @ base.position
    out[:, 3:] = angles_of(vessel @ np.array(base.rows))
    return out


def rotations(angles: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return Rz(yaw) Ry(pitch) Rx(roll) (K, 3, 3) of (roll, pitch, yaw) (K, 3) [rad]."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles).T, np.cos(angles).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array(rows).transpose(2, 0, 1)


def angles_of(rotation: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return (roll, pitch, yaw) (K, 3) [rad] of rotations (K, 3, 3), with a continuous yaw."""
    roll = np.arctan2(rotation[:, 2, 1], rotation[:, 2, 2])
    pitch = np.arctan2(-rotation[:, 2, 0], np.hypot(rotation[:, 0, 0], rotation[:, 1, 0]))
    yaw = np.unwrap(np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]))
    return np.column_stack([roll, pitch, yaw])
