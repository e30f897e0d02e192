"""Spong's collocated partial feedback linearisation of a crane with a hoist, (175)-(179)."""

from typing import NamedTuple

import numpy as np

from crane_bench.reproduce.lagrange.chain import LumpedCrane, bias, mass_matrix
from crane_bench.reproduce.lagrange.coordinates import Array


class Collocated(NamedTuple):
    """The dynamics of section 6.2.2 without unactuated angles: 𝓜 (ẍ, l̈_1) + bias = (F, F_1)."""

    mass: Array  # 𝓜, (2, 2), equation (178)
    bias: Array  # (2,), the rest of the left sides of (176) and (177)
    angle_mass: Array  # M_θθ, (N, N), equation (175)
    coupling: Array  # (N, 2): M_θx and M_θl
    angle_bias: Array  # NL_θ, (N,)

    def forces(self, accelerations: Array) -> Array:
        """Return (F, F_1) for the wanted accelerations (2,) of trolley and hoist: (176), (177)."""
        return self.mass @ accelerations + self.bias

    def angles(self, actuated: Array) -> Array:
        """Return θ̈ (N,) under accelerations (ẍ, l̈_1) of actuated coordinates, equation (179)."""
        return -np.linalg.solve(self.angle_mass, self.coupling @ actuated + self.angle_bias)


def collocate(crane: LumpedCrane, q: Array, v: Array) -> Collocated:
    """Return the crane with trolley and l_1 actuated, l_2 .. l_N fixed, at q and v (2N+1,)."""
    n = len(crane.masses)
    mass, load = mass_matrix(crane, q), bias(crane, q, v)
    driven, swinging = [0, n + 1], list(range(1, n + 1))
    angle_mass, coupling = mass[np.ix_(swinging, swinging)], mass[np.ix_(swinging, driven)]
    gains = np.linalg.solve(angle_mass, coupling).T
    reduced = mass[np.ix_(driven, driven)] - gains @ coupling
    return Collocated(
        reduced, load[driven] - gains @ load[swinging], angle_mass, coupling, load[swinging]
    )
