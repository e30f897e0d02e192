"""Chain of springs and dampers in Cartesian coordinates.

A tension-only one goes slack and taut at events.
"""

from dataclasses import dataclass

import numpy as np
from rigid import Real, Rigid, Vector


@dataclass
class Elastic(Rigid):
    """T = k e + c de/dt at the elongation e; tension-only: that where e > 0 and T > 0.

    The elongation is that beyond the rest length.
    """

    spring: float = 0.0  # N/m
    dashpot: float = 0.0  # N s/m
    tension_only: bool = False

    def __post_init__(self) -> None:
        """Prepare the inverse masses; every link begins taut."""
        super().__post_init__()
        self.taut = np.ones(len(self.masses), bool)

    def stretch(self, y: Vector) -> tuple[Vector, Vector, Vector]:
        """Return unit vectors (N, axes), elongations (N,) and their rates."""
        d, rate = (np.diff(half.reshape(-1, self.axes), axis=0) for half in np.split(y, 2))
        length = np.sqrt(np.sum(d * d, axis=1))
        n = d / length[:, None]
        return n, length - self.link_lengths, np.sum(n * rate, axis=1)

    def tension(self, t: Real, y: Vector) -> Vector:
        """Return the tensions (N,) [N] of the links, zero where slack."""
        _, e, rate = self.stretch(y)
        return (Real(self.spring) * e + Real(self.dashpot) * rate) * self.taut

    def field(self, t: Real, y: Vector) -> Vector:
        """Return dy/dt."""
        n = self.stretch(y)[0]
        force = self.nodal_forces(self.tension(t, y)[:, None] * n)
        force[:, -1] -= self.weight
        force[0, :-1] += self.drive(t)[: self.axes - 1]
        return np.concatenate([np.split(y, 2)[1], self.apply_inverse_mass(force).ravel()])

    def project(self, t: Real, y: Vector) -> Vector:
        """Return the state as it is."""
        return y

    def tautness(self, y: Vector) -> Vector:
        """Return what is positive where a link pulls, negative where not (N,) [m]."""
        _, e, rate = self.stretch(y)
        return np.minimum(e, e + Real(self.dashpot) / Real(self.spring) * rate)

    def event(self, t: Real, y: Vector) -> Real:
        """Return the least of the links' distances from their next change."""
        if not self.tension_only:
            return Real(1)
        return np.min(np.where(self.taut, 1, -1) * self.tautness(y))

    def switch(self, t: Real, y: Vector) -> tuple[Vector, list[int]]:
        """Return the state and the links (from 1) that pull now, -k for a link k gone slack."""
        changed = np.argmin(np.where(self.taut, 1, -1) * self.tautness(y))
        self.taut[changed] = not self.taut[changed]
        return y, [int(changed + 1) if self.taut[changed] else -int(changed + 1)]
