"""Unit quaternions (x, y, z, w) and rotation matrices.

Those of many instants at once are arrays: scipy's would take a seventh of a recorder's start to
import.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crane_sim.trajectories.base_motion import rotations

Array = NDArray[np.float64]

Quaternion = tuple[float, float, float, float]
NO_TURN: Quaternion = (0.0, 0.0, 0.0, 1.0)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the quaternion of the turn `b` followed by the turn `a`."""
    return (
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    )


def quaternion_of(rotation: Array) -> Quaternion:
    """Return the unit quaternion (x, y, z, w) of a rotation matrix (3, 3).

    It follows from its largest component (Shepperd 1978).

    Every pair of components has its product among the sums and differences of the matrix's entries.
    """
    r, trace = rotation, float(np.trace(rotation))
    products = np.array(
        [
            [1.0 + 2.0 * r[0, 0] - trace, r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[0, 1] + r[1, 0], 1.0 + 2.0 * r[1, 1] - trace, r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1.0 + 2.0 * r[2, 2] - trace, r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1.0 + trace],
        ]
    )
    row = products[int(np.argmax(np.diag(products)))]
    x, y, z, w = (row / np.linalg.norm(row)).tolist()
    return x, y, z, w


def quaternions_of(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Return unit quaternions (K, 4), x y z w, of turns by yaw, then pitch, then roll [rad].

    Each turn is about the turned axes.

    Args:
        roll: (K,) rad, about x.
        pitch: (K,) rad, about y.
        yaw: (K,) rad, about z.
    """
    (cr, cp, cy), (sr, sp, sy) = (
        [f(0.5 * angle) for angle in (roll, pitch, yaw)] for f in (np.cos, np.sin)
    )
    x = cy * cp * sr - sy * sp * cr
    y = cy * sp * cr + sy * cp * sr
    z = sy * cp * cr - cy * sp * sr
    w = cy * cp * cr + sy * sp * sr
    return np.stack([x, y, z, w], axis=-1)


def rotation_matrices(quaternions: Array) -> Array:
    """Return rotation matrices (K, 3, 3) of non-zero quaternions (K, 4), x y z w, of any size."""
    n, w = quaternions[:, :3], quaternions[:, 3, None, None]
    zero = np.zeros(len(n))
    x, y, z = n.T
    # of n with a vector
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    outer, square = n[:, :, None] * n[:, None, :], np.sum(n * n, axis=1)[:, None, None]
    return ((w * w - square) * np.eye(3) + 2.0 * (outer + w * cross)) / (w * w + square)


def rotations_about_z(angles: Array) -> Array:
    """Return the rotation matrices (K, 3, 3) of turns about z by angles (K,) [rad]."""
    return rotations(np.column_stack([np.zeros((len(angles), 2)), angles]))
