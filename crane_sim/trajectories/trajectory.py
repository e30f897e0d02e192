"""Trajectories: references of the payload or the actuated joints over time, with derivatives.

A scene names a kind (one file each); each kind becomes the same `PiecewisePolynomial`, which can be
delayed and added, and this becomes a `Trajectory`, which one piece of compiled code evaluates. A
trajectory is at rest before and after.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.jit import LIGHT, entry_point, optimisation
from crane_sim.numerics.lanes import take_entry
from crane_sim.trajectories.piecewise import find_piece, polynomial_at
from crane_sim.trajectories.polynomials import Array, PiecewisePolynomial


class Trajectory(NamedTuple):
    """A compiled reference of n coordinates: payload x, y (z) in the base frame [m], or joints.

    The joints are the actuated ones.
    """

    starts: Any  # (pieces,) s, increasing; the first piece also holds before
    coordinates: tuple[Any, ...]  # (n,) of (pieces, degree + 1), of powers of t - starts[piece],
    # from the constant on
    of_joints: bool = False  # of the actuated joints, in the scene's order, rather than of the
    # payload


def compile_trajectory(polynomials: PiecewisePolynomial, of_joints: bool = False) -> Trajectory:
    """Return the compiled form of n coordinates."""
    n = polynomials.coefficients.shape[1]
    coordinates = tuple(np.ascontiguousarray(polynomials.coefficients[:, k]) for k in range(n))
    return Trajectory(
        np.ascontiguousarray(polynomials.starts, dtype=np.float64), coordinates, of_joints
    )


def derivatives_at(trajectory, t, orders):
    """Return the derivatives of these orders, at most 4, at time t [s], each a tuple (n,)."""
    piece = find_piece(trajectory.starts, len(trajectory.starts), t)
    s = t - trajectory.starts[piece]
    derivatives = [polynomial_at(coefficients, piece, s) for coefficients in trajectory.coordinates]
    return tuple([tuple([of_one[k] for of_one in derivatives]) for k in orders])


def reference_at(trajectory, t):
    """Return (position, velocity, acceleration), tuples (n,), of a trajectory at time t [s]."""
    return derivatives_at(trajectory, t, (0, 1, 2))


def higher_derivatives_at(trajectory, t):
    """Return (jerk, snap), the third and fourth derivative, tuples (n,), at time t [s]."""
    return derivatives_at(trajectory, t, (3, 4))


@entry_point
@optimisation(LIGHT)
def sample_trajectory(trajectory, t):
    """Return position, velocity and acceleration (K, 3, n) of a trajectory at times t (K,) [s]."""
    out = np.empty((len(t), 3, len(trajectory.coordinates)))
    for i in range(len(t)):
        out[i] = reference_at(trajectory, t[i])
    return out


@entry_point
def sample_trajectories(trajectories, t):
    """Return position, velocity, acceleration (n, 3, k) of n trajectories at times t (n,) [s].

    Args:
        trajectories: columns of them.
        t: times.
    """
    out = np.empty((len(t), 3, len(trajectories.coordinates)))
    for i in range(len(t)):
        out[i] = reference_at(take_entry(trajectories, i), t[i])
    return out


__all__ = [
    "Array",
    "Trajectory",
    "PiecewisePolynomial",
    "higher_derivatives_at",
    "compile_trajectory",
    "reference_at",
    "sample_trajectories",
    "sample_trajectory",
]
