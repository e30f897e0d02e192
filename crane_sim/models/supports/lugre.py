"""LuGre friction of joints: bristles that bend while a joint sticks, without events.

Canudas de Wit, Olsson, Åström, Lischinsky, "A new model for control of systems with friction", IEEE Transactions on
Automatic Control 40, 1995, eqs. 1 to 4, with the mean deflection z of the bristles, a scalar state:

    z' = v - σ0 |v| z / g(v),   F = σ0 z + σ1 z' + σ2 v,   g(v) = Fc + (Fs - Fc) exp(-(v / vs)²).

The bristles are relaxed where a run begins at rest, and bent as in steady motion where it begins with a velocity.
"""

from math import exp
from typing import NamedTuple

from crane_sim.files.types import NonNegative, Positive
from crane_sim.models.supports.friction import friction_effort, friction_state_rate, initial_friction_state


class LuGre(NamedTuple):
    """Dry friction of a joint by bristles: smooth, so a sticking joint creeps slowly."""

    coulomb: Positive  # effort's unit, in slow steady motion
    static: NonNegative  # effort's unit, up to which it sticks; at least the Coulomb friction
    stribeck: Positive  # joint's unit/s, vs: velocity scale at which g(v) falls from static to Coulomb friction
    stiffness: Positive  # effort's unit/joint's unit, σ0 of the bristles
    damping: NonNegative  # effort's unit s/joint's unit, σ1 of the bristles
    viscous: NonNegative = 0.0  # effort's unit s/joint's unit, σ2


def steady_friction(friction, v):
    """Return g(v) [N or N m]."""
    ratio = v / friction.stribeck
    return friction.coulomb + (friction.static - friction.coulomb) * exp(-ratio * ratio)


@friction_state_rate.register(LuGre)
def _(friction, v, deflection):
    return v - friction.stiffness * abs(v) * deflection / steady_friction(friction, v)


@friction_effort.register(LuGre)
def _(friction, v, deflection):
    rate = friction_state_rate(friction, v, deflection)
    return -friction.stiffness * deflection - friction.damping * rate - friction.viscous * v


@initial_friction_state.register(LuGre)
def _(friction, v):
    sign = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    return sign * steady_friction(friction, v) / friction.stiffness
