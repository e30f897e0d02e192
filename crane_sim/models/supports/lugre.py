"""LuGre friction of joints: bristles that bend while a joint sticks, without events.

Canudas de Wit, Olsson, Åström, Lischinsky, "A new model for control of systems with friction", IEEE
Transactions on Automatic Control 40, 1995, eqs. 1 to 4, with the mean deflection z of the bristles,
a scalar state:

    z' = v - σ0 |v| z / g(v),   F = σ0 z + σ1 z' + σ2 v,   g(v) = Fc + (Fs - Fc) exp(-(v / vs)²).

The bristles are relaxed where a run begins at rest, and bent as in steady motion where it begins
with a velocity.
"""

from math import exp
from typing import NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive


class LuGre(NamedTuple):
    """Dry friction of a joint by bristles: smooth, so a sticking joint creeps slowly."""

    coulomb: Positive  # effort's unit, in slow steady motion
    static: NonNegative  # effort's unit, up to which it sticks; at least the Coulomb friction
    stribeck: Positive  # joint's unit/s, vs: velocity scale at which g(v) falls from static to
    # Coulomb friction
    stiffness: Positive  # effort's unit/joint's unit, σ0 of the bristles
    damping: NonNegative  # effort's unit s/joint's unit, σ1 of the bristles
    viscous: NonNegative = 0.0  # effort's unit s/joint's unit, σ2

    def steady(self, v):
        """Return g(v) [N or N m]."""
        ratio = v / self.stribeck
        return self.coulomb + (self.static - self.coulomb) * exp(-ratio * ratio)

    def sticks(self, deflection):
        """Return that no constraint holds the joint: it creeps."""
        return False

    def effort(self, v, deflection):
        """Return friction's effort -F [N or N m], added to the others' at velocity v."""
        rate = self.state_rate(v, deflection)
        return -self.stiffness * deflection - self.damping * rate - self.viscous * v

    def response(self, mass, force, v, deflection):
        """Return (inverse mass, bias acceleration) of a mass on its rail under a force."""
        return 1.0 / mass, (force + self.effort(v, deflection)) / mass

    def state_rate(self, v, deflection):
        """Return the derivative of the deflection."""
        return v - self.stiffness * abs(v) * deflection / self.steady(v)

    def initial_state(self, v):
        """Return the deflection of a joint that begins at velocity v."""
        return np.sign(v) * self.steady(v) / self.stiffness

    def guard(self, v, deflection, effort):
        """Return the guard of a joint without events: it never fails."""
        return 1.0
