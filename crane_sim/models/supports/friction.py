"""Dry friction of joints that sticks and slips: stick is a constraint, and events separate the two.

A joint's friction state is a scalar of the crane's state: here its mode, whose derivative is zero, 0 while it sticks,
else the direction in which it slips. A joint that sticks does not accelerate, whatever its inertia; it breaks loose
when what would accelerate it exceeds the static friction. Where several joints stick, each is judged by the effort that
holds it while all others keep their modes, one after the other, the one whose guard is lowest first.

With a Stribeck velocity vs the friction of a joint that slips falls from the static to the Coulomb level continuously,
F(v) = Fc + (Fs - Fc) exp(-(v / vs)²) + viscous |v| (Armstrong-Hélouvry, Dupont, Canudas de Wit, "A survey of models,
analysis tools and compensation methods for the control of machines with friction", Automatica 30, 1994); without one
it jumps.
"""

from math import e, exp, sqrt
from typing import Any, NamedTuple

from crane_sim.files.types import NonNegative, Positive
from crane_sim.numerics.jit import generic
from crane_sim.system import EventStepControl


class Friction(NamedTuple):
    """Dry and viscous friction of a joint. Stick and slip are modes: nothing smooths the jump between them."""

    coulomb: NonNegative  # effort's unit, while it slips
    static: NonNegative  # effort's unit, up to which it sticks; at least the Coulomb friction
    viscous: NonNegative = 0.0  # effort's unit s/joint's unit, on top while it slips
    stribeck: Positive | None = None  # joint's unit/s, vs: velocity scale at which the friction falls from static to
    # Coulomb, as exp(-(v/vs)²); left out: it falls at once


@generic
def dry_friction(stribeck, friction, v):
    """Return the friction [N or N m] at velocity v without its viscous part; `stribeck` is the one of `friction`."""
    return friction.coulomb


@dry_friction.register(float)
def _(stribeck, friction, v):
    return friction.coulomb + (friction.static - friction.coulomb) * exp(-(v / stribeck) * (v / stribeck))


@generic
def friction_response(friction, mass, force, v, mode):
    """Return (inverse mass, bias acceleration) of a mass on its rail under a force."""
    return 1.0 / mass, force / mass


@friction_response.register(Friction)
def _(friction, mass, force, v, mode):
    if mode == 0.0:
        return 0.0, 0.0
    return 1.0 / mass, (force - mode * dry_friction(friction.stribeck, friction, v) - friction.viscous * v) / mass


@generic
def has_friction(part):
    """Return whether a joint, or what rubs there, sticks and slips."""
    return False


@has_friction.register(Friction)
def _(part):
    return True


@generic
def joint_sticks(friction, friction_state):
    """Return whether friction holds the joint, whose velocity is then 0; `friction_state`: its mode or bristles."""
    return False


@joint_sticks.register(Friction)
def _(friction, friction_state):
    return friction_state == 0.0


@generic
def friction_effort(friction, v, friction_state):
    """Return the effort [N or N m] by which friction adds to the others' on a joint at velocity v."""
    return 0.0


@friction_effort.register(Friction)
def _(friction, v, friction_state):
    return -friction_state * dry_friction(friction.stribeck, friction, v) - abs(friction_state) * friction.viscous * v


@generic
def friction_state_rate(friction, v, friction_state):
    """Return the derivative of the joint's friction state: modes change by events alone."""
    return 0.0


@generic
def initial_friction_state(friction, v):
    """Return the friction state of a joint that begins at velocity v."""
    return 1.0


@initial_friction_state.register(Friction)
def _(friction, v):
    return 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0


@generic
def friction_force(friction, v):
    """Return the friction force [N] against a velocity v other than 0."""
    return 0.0


@friction_force.register(Friction)
def _(friction, v):
    direction = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    return direction * dry_friction(friction.stribeck, friction, v) + friction.viscous * v


@generic
def friction_guard(friction, v, mode, force):
    """Return the guard of a joint's friction: negative when slipping has ended or sticking cannot hold.

    `force` [N or N m] is what would accelerate the joint if it did not stick, its own friction left out.
    """
    return 1.0


@friction_guard.register(Friction)
def _(friction, v, mode, force):
    return friction.static - abs(force) if mode == 0.0 else mode * v


@generic
def breakaway_mode(friction, mode, force):
    """Return the mode of a joint at rest after its guard has failed in `mode`: 0 when friction holds it, else the way.

    A joint that stuck is free now: asking again whether friction holds it could, in the last digit, say yes.
    """
    return 0.0


@breakaway_mode.register(Friction)
def _(friction, mode, force):
    if mode != 0.0 and abs(force) <= friction.static:
        return 0.0
    return 1.0 if force > 0.0 else -1.0


@generic
def step_control_of(part):
    """Return `Switching.step_control` of a friction, or of a part that has one: None without a Stribeck velocity.

    With one, the friction changes fast where a joint comes to rest.
    """
    return None


@step_control_of.register(Friction)
def _(part):
    return step_control_of(part.stribeck)


@step_control_of.register(float)
def _(part):
    return EventStepControl()


@generic
def first_not_none(first, second):
    """Return the first one of two results of `step_control_of` that is not None."""
    return second


@first_not_none.register(EventStepControl)
def _(first, second):
    return first


def steepest_slope(friction: Any) -> float:
    """Return the largest size of dF/dv [effort's unit s/joint's unit]; that of exp(-(v/vs)²) is sqrt(2/e) / vs."""
    falling = 0.0 if friction.stribeck is None else (friction.static - friction.coulomb) / friction.stribeck
    return max(friction.viscous, sqrt(2.0 / e) * falling)
