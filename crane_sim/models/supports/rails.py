"""Axes that carry the cable's upper end: a trolley along x, a bridge along y.

An axis is driven by a force, moved as prescribed, or fixed. What the cable needs of it is its inverse mass (0 when
its motion is imposed or friction holds it) and its bias acceleration: that when the cable does not pull.
"""

from typing import NamedTuple

from crane_sim.files.types import NonNegative, Positive
from crane_sim.numerics.jit import lean_generic
from crane_sim.trajectories.profiles import Motion, evaluate_motion


class Friction(NamedTuple):
    """Dry and viscous friction of wheels on a rail. Stick and slip are modes: nothing smooths the jump between them."""

    coulomb: NonNegative  # N, while it slips
    static: NonNegative  # N, up to which it sticks; at least the Coulomb force
    viscous: NonNegative = 0.0  # N s/m, on top while it slips


class ForceAxis(NamedTuple):
    """An axis that takes a force command."""

    mass: Positive  # kg, that moves with it
    friction: Friction | None = None


class PrescribedAxis(NamedTuple):
    """An axis whose position is a given function of time."""

    motion: Motion


class FixedAxis(NamedTuple):
    """An axis that stays where it is."""


Axis = ForceAxis | PrescribedAxis | FixedAxis


@lean_generic
def input_count(axis):
    """Return the number of efforts of the axis."""
    return 0


@input_count.register(ForceAxis)
def _(axis):
    return 1


@lean_generic
def axis_response(axis, t, tau, i, v, mode):
    """Return (inverse mass [1/kg], bias acceleration [m/s²]) of an axis.

    Args:
        axis: its parameters.
        t: time [s].
        tau, i: efforts of all joints, and the index of this axis' own [N].
        v: velocity [m/s].
        mode: of its friction: 0 sticks, else the direction in which it slips.
    """
    return 0.0, 0.0


@axis_response.register(ForceAxis)
def _(axis, t, tau, i, v, mode):
    return friction_response(axis.friction, axis.mass, tau[i], v, mode)


@axis_response.register(PrescribedAxis)
def _(axis, t, tau, i, v, mode):
    return 0.0, evaluate_motion(axis.motion, t)[2]


@lean_generic
def friction_response(friction, mass, force, v, mode):
    """Return (inverse mass, bias acceleration) of a mass on its rail under a force."""
    return 1.0 / mass, force / mass


@friction_response.register(Friction)
def _(friction, mass, force, v, mode):
    if mode == 0.0:
        return 0.0, 0.0
    return 1.0 / mass, (force - mode * friction.coulomb - friction.viscous * v) / mass


@lean_generic
def axis_mass(axis):
    """Return the mass [kg] that moves with the axis and is modelled: none when its motion is imposed."""
    return 0.0


@axis_mass.register(ForceAxis)
def _(axis):
    return axis.mass


@lean_generic
def axis_power(axis, tau, i, v, pull):
    """Return the power [W] that drive and friction supply at velocity v when the cable pulls with `pull` [N]."""
    return -pull * v


@axis_power.register(ForceAxis)
def _(axis, tau, i, v, pull):
    return (tau[i] - friction_force(axis.friction, v)) * v


@lean_generic
def friction_force(friction, v):
    """Return the friction force [N] against a velocity v other than 0."""
    return 0.0


@friction_force.register(Friction)
def _(friction, v):
    direction = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    return direction * friction.coulomb + friction.viscous * v


@lean_generic
def has_friction(part):
    """Return whether an axis, or what rubs there, sticks and slips."""
    return False


@has_friction.register(ForceAxis)
def _(part):
    return has_friction(part.friction)


@has_friction.register(Friction)
def _(part):
    return True


@lean_generic
def axis_guard(axis, v, mode, tau, i, pull):
    """Return the guard of the axis' friction: negative when slipping has ended or sticking cannot hold."""
    return 1.0


@axis_guard.register(ForceAxis)
def _(axis, v, mode, tau, i, pull):
    return friction_guard(axis.friction, v, mode, tau[i] + pull)


@lean_generic
def friction_guard(friction, v, mode, force):
    """Return the guard of `axis_guard` when `force` [N] would accelerate the axis."""
    return 1.0


@friction_guard.register(Friction)
def _(friction, v, mode, force):
    return friction.static - abs(force) if mode == 0.0 else mode * v


@lean_generic
def mode_after_stop(axis, mode, tau, i, pull):
    """Return the mode of an axis at rest after its guard has failed in `mode`: 0 when friction holds it, else the way.

    An axis that stuck is free now: asking again whether friction holds it could, in the last digit, say yes.
    """
    return 0.0


@mode_after_stop.register(ForceAxis)
def _(axis, mode, tau, i, pull):
    return breakaway_mode(axis.friction, mode, tau[i] + pull)


@lean_generic
def breakaway_mode(friction, mode, force):
    """Return the mode of `mode_after_stop`."""
    return 0.0


@breakaway_mode.register(Friction)
def _(friction, mode, force):
    if mode != 0.0 and abs(force) <= friction.static:
        return 0.0
    return 1.0 if force > 0.0 else -1.0
