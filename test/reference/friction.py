"""Dry friction at the trolley (plane): stick, and slip in either sense, as modes with events."""

from dataclasses import dataclass

import numpy as np
from rigid import Real, Rigid, Vector


@dataclass
class StickSlip(Rigid):
    """Rigid chain whose trolley slips with `mode` +1 or -1, or sticks (0)."""

    coulomb: float = 0.0  # N, while it slips
    static: float = 0.0  # N, what stick can hold
    viscous: float = 0.0  # N s / m
    mode: int = 0

    def __post_init__(self) -> None:
        """Prepare the matrices of the slipping trolley and of the held one."""
        moved, self.trolley = self.trolley, [np.inf]
        super().__post_init__()
        held = self.inverse_mass, self.constraint_inverse_mass
        self.trolley = moved
        super().__post_init__()
        self.matrices = {
            0: held,
            1: (self.inverse_mass, self.constraint_inverse_mass),
            -1: (self.inverse_mass, self.constraint_inverse_mass),
        }
        self.outer = self.drive
        self.enter(self.mode)

    def enter(self, mode: int) -> None:
        """Take up a mode."""
        self.mode = mode
        self.inverse_mass, self.constraint_inverse_mass = self.matrices[mode]

    def solve_accelerations(self, t: Real, q: Vector, v: Vector) -> tuple[Vector, Real, Vector]:
        """Return accelerations and multipliers with the friction of the mode among the forces."""
        axis = np.array([1, 0], Real)
        self.drive = lambda t: (
            self.outer(t) - (Real(self.coulomb) * self.mode + Real(self.viscous) * v[0]) * axis
        )
        return super().solve_accelerations(t, q, v)

    def load(self, t: Real, y: Vector) -> Real:
        """Return the force [N] on the trolley without friction: what stick has to hold."""
        q, v = np.split(y, 2)
        return self.outer(t)[0] + self.solve_accelerations(t, q, v)[2][0] * (q[2] - q[0])

    def event(self, t: Real, y: Vector) -> Real:
        """Return the reserve of stick, or the speed in the sense of slip."""
        if self.mode == 0:
            return Real(self.static) - abs(self.load(t, y))
        return self.mode * y[len(y) // 2]

    def switch(self, t: Real, y: Vector) -> tuple[Vector, list[int]]:
        """Return the state, its trolley at rest, and the mode that follows."""
        y = y.copy()
        y[len(y) // 2] = 0
        breaks = self.mode == 0
        self.enter(0)
        y = self.project(t, y)
        load = self.load(t, y)
        self.enter(int(np.sign(load)) if breaks or abs(load) > self.static else 0)
        return y, [self.mode]
