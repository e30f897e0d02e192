"""Dry friction of joints that sticks and slips: stick is a constraint, and events separate the two.

A joint's friction state is a scalar of the crane's state: here its mode, whose derivative is zero,
0 while it sticks, else the direction in which it slips. A joint that sticks does not accelerate,
whatever its inertia; it breaks loose when what would accelerate it exceeds the static friction.
Where several joints stick, each is judged by the effort that holds it while all others keep their
modes, one after the other, the one whose guard is lowest first.

With a Stribeck velocity vs the friction of a joint that slips falls from the static to the Coulomb
level continuously, F(v) = Fc + (Fs - Fc) exp(-(v / vs)²) + viscous |v| (Armstrong-Hélouvry, Dupont,
Canudas de Wit, "A survey of models, analysis tools and compensation methods for the control of
machines with friction", Automatica 30, 1994); without one it jumps.
"""

from math import e, exp, sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive
from crane_sim.system import EventStepControl


class Friction(NamedTuple):
    """Dry and viscous friction of a joint; stick and slip are modes, without smoothing."""

    coulomb: NonNegative  # effort's unit, while it slips
    static: NonNegative  # effort's unit, up to which it sticks; at least the Coulomb friction
    viscous: NonNegative = 0.0  # effort's unit s/joint's unit, on top while it slips
    stribeck: Positive | None = None  # joint's unit/s, vs: velocity scale at which the friction
    # falls from static to Coulomb, as exp(-(v/vs)²); left out: it falls at once

    def dry(self, v):
        """Return the friction [N or N m] at velocity v without its viscous part."""
        if self.stribeck is None:
            return self.coulomb
        return self.coulomb + (self.static - self.coulomb) * exp(
            -(v / self.stribeck) * (v / self.stribeck)
        )

    def sticks(self, mode):
        """Return whether friction holds the joint, whose velocity is then 0."""
        return mode == 0.0

    def effort(self, v, mode):
        """Return friction's effort [N or N m], added to the others' on a joint at velocity v."""
        return -mode * self.dry(v) - abs(mode) * self.viscous * v

    def response(self, mass, force, v, mode):
        """Return (inverse mass, bias acceleration) of a mass on its rail under a force."""
        if mode == 0.0:
            return 0.0, 0.0
        return 1.0 / mass, (force - mode * self.dry(v) - self.viscous * v) / mass

    def state_rate(self, v, mode):
        """Return the derivative of the joint's friction state: modes change by events alone."""
        return 0.0

    def initial_state(self, v):
        """Return the friction state of a joint that begins at velocity v."""
        return np.sign(v)

    def guard(self, v, mode, effort):
        """Return the guard of friction: negative if slipping has ended or sticking cannot hold.

        `effort` [N or N m] is what would accelerate the joint if it did not stick, its own friction
        left out.
        """
        return self.static - abs(effort) if mode == 0.0 else mode * v

    def breakaway_mode(self, mode, effort):
        """Return the mode of a joint at rest after its guard failed: 0 if it holds, else the way.

        A joint that stuck is free now: asking again whether friction holds it could, in the last
        digit, say yes.
        """
        if mode != 0.0 and abs(effort) <= self.static:
            return 0.0
        return 1.0 if effort > 0.0 else -1.0


def friction_of(part: Any) -> Any:
    """Return the friction of an axis or a hoist; None without friction, or without a part."""
    return getattr(part, "friction", None)


def friction_effort(friction, v, friction_state):
    """Return the effort [N or N m] of a joint's friction, 0 without.

    `friction_state` is its mode or its bristles.
    """
    return 0.0 if friction is None else friction.effort(v, friction_state)


def friction_force(friction, v):
    """Return the friction force [N] against a velocity v other than 0; 0 without friction.

    That of bristles follows from their deflection (`LuGre.effort`) and is left out.
    """
    return (
        np.sign(v) * friction.dry(v) + friction.viscous * v
        if isinstance(friction, Friction)
        else 0.0
    )


def forced_response(friction, mass, force, v, mode):
    """Return (inverse mass, bias acceleration) of a mass with friction, or None, under a force."""
    return (
        (1.0 / mass, force / mass) if friction is None else friction.response(mass, force, v, mode)
    )


def step_control_of(*frictions: Any) -> EventStepControl | None:
    """Return `Switching.step_control` of these frictions: None without a Stribeck velocity.

    With one, the friction changes fast where a joint comes to rest.
    """
    fast = [
        isinstance(friction, Friction) and friction.stribeck is not None for friction in frictions
    ]
    return EventStepControl() if any(fast) else None


def steepest_slope(friction: Any) -> float:
    """Return the largest size of dF/dv [effort's unit s/joint's unit].

    That of exp(-(v/vs)²) is sqrt(2/e) / vs.
    """
    falling = (
        0.0
        if friction.stribeck is None
        else (friction.static - friction.coulomb) / friction.stribeck
    )
    return max(friction.viscous, sqrt(2.0 / e) * falling)
