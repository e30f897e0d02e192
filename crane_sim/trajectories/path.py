"""References: where the payload or the driven joints should be at every time, with all that changes there.

A scene names a kind (one file each); each kind becomes the same `Pieces`, polynomials of time, which can be delayed
and added, and these become a `Path`, which one piece of compiled code evaluates. A path is at rest before and after.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.jit import entry, lean_generic, lean_kernel
from crane_sim.trajectories.piecewise import find_piece, polynomial_at
from crane_sim.trajectories.polynomials import Array, Pieces


class Coordinate(NamedTuple):
    """The pieces of one coordinate and those of the coordinates after it, a list that kernels can walk by type."""

    coefficients: Any  # (pieces, degree + 1), of powers of t - starts[piece], from the constant on
    rest: "Coordinate | None" = None


class Path(NamedTuple):
    """A compiled reference of n coordinates: payload x, y (z) in the base frame [m], or the actuated joints."""

    starts: Any  # (pieces,) s, increasing; the first piece also holds before
    coordinates: Coordinate
    of_joints: bool = False  # of the actuated joints, in the scene's order, rather than of the payload


def path_of(pieces: Pieces, of_joints: bool = False) -> Path:
    """Return the compiled form of n coordinates."""
    rest: Coordinate | None = None
    for k in reversed(range(pieces.coefficients.shape[1])):
        rest = Coordinate(np.ascontiguousarray(pieces.coefficients[:, k]), rest)
    assert rest is not None, "a path has at least one coordinate"
    return Path(np.ascontiguousarray(pieces.starts, dtype=np.float64), rest, of_joints)


@lean_generic
def low_derivatives(coordinates, piece, s):
    """Return (positions, velocities, accelerations) of a list of coordinates, each a tuple."""
    return (), (), ()


@low_derivatives.register(Coordinate)
def _(coordinates, piece, s):
    x, v, a, _, _ = polynomial_at(coordinates.coefficients, piece, s)
    xs, vs, accelerations = low_derivatives(coordinates.rest, piece, s)
    return (x, *xs), (v, *vs), (a, *accelerations)


@lean_generic
def high_derivatives(coordinates, piece, s):
    """Return (jerks, snaps) of a list of coordinates, each a tuple."""
    return (), ()


@high_derivatives.register(Coordinate)
def _(coordinates, piece, s):
    _, _, _, jerk, snap = polynomial_at(coordinates.coefficients, piece, s)
    jerks, snaps = high_derivatives(coordinates.rest, piece, s)
    return (jerk, *jerks), (snap, *snaps)


@lean_kernel
def reference_at(path, t):
    """Return (position, velocity, acceleration) of a path at time t [s], each a tuple (n,)."""
    piece = find_piece(path.starts, len(path.starts), t)
    return low_derivatives(path.coordinates, piece, t - path.starts[piece])


@lean_kernel
def further_at(path, t):
    """Return (jerk, snap), the third and fourth derivative of a path at time t [s], each a tuple (n,)."""
    piece = find_piece(path.starts, len(path.starts), t)
    return high_derivatives(path.coordinates, piece, t - path.starts[piece])


@entry
def sample_path(path, t):
    """Return position, velocity and acceleration (K, 3, n) of a path at times t (K,) [s]."""
    n = len(reference_at(path, 0.0)[0])
    out = np.empty((len(t), 3, n))
    for i in range(len(t)):
        x, v, a = reference_at(path, t[i])
        for k in range(n):
            out[i, 0, k], out[i, 1, k], out[i, 2, k] = x[k], v[k], a[k]
    return out


__all__ = ["Array", "Coordinate", "Path", "Pieces", "further_at", "path_of", "reference_at", "sample_path"]
