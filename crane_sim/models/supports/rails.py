"""Axes that carry the cable's upper end: a trolley along x, a bridge along y.

An axis is driven by a force, moved as prescribed, or fixed. What the cable needs of it is its inverse mass (0 when
its motion is imposed or friction holds it) and its bias acceleration: that when the cable does not pull.
"""

from typing import NamedTuple

import numpy as np

from crane_sim.files.types import Positive
from crane_sim.models.supports.friction import (
    Friction,
    breakaway_mode,
    friction_effort,
    friction_force,
    friction_guard,
    friction_response,
    friction_state_rate,
    has_friction,
    initial_friction_state,
    step_control_of,
)
from crane_sim.models.supports.lugre import LuGre
from crane_sim.numerics.jit import generic
from crane_sim.trajectories.profiles import Motion, motion_acceleration


class ForceAxis(NamedTuple):
    """An axis that takes a force command."""

    mass: Positive  # kg, that moves with it
    friction: Friction | LuGre | None = None


class PrescribedAxis(NamedTuple):
    """An axis whose position is a given function of time."""

    motion: Motion


class FixedAxis(NamedTuple):
    """An axis that stays where it is."""


Axis = ForceAxis | PrescribedAxis | FixedAxis


@generic
def input_count(axis):
    """Return the number of efforts of the axis."""
    return 0


@input_count.register(ForceAxis)
def _(axis):
    return 1


@generic
def axis_response(axis, t, tau, i, v, mode):
    """Return (inverse mass [1/kg], bias acceleration [m/s²]) of an axis.

    Args:
        axis: its parameters.
        t: time [s].
        tau, i: efforts of all joints, and the index of this axis' own [N].
        v: velocity [m/s].
        mode: of its friction: 0 sticks, else the direction in which it slips; or its bristles' deflection.
    """
    return 0.0, 0.0


@axis_response.register(ForceAxis)
def _(axis, t, tau, i, v, mode):
    return friction_response(axis.friction, axis.mass, tau[i], v, mode)


@axis_response.register(PrescribedAxis)
def _(axis, t, tau, i, v, mode):
    return 0.0, motion_acceleration(axis.motion, t)


@generic
def axis_mass(axis):
    """Return the mass [kg] that moves with the axis and is modelled: none when its motion is imposed."""
    return 0.0


@axis_mass.register(ForceAxis)
def _(axis):
    return axis.mass


@generic
def axis_power(axis, tau, i, v, pull):
    """Return the power [W] that drive and friction supply at velocity v when the cable pulls with `pull` [N]."""
    return -pull * v


@axis_power.register(ForceAxis)
def _(axis, tau, i, v, pull):
    return (tau[i] - friction_force(axis.friction, v)) * v


@friction_response.register(LuGre)
def _(friction, mass, force, v, mode):
    return 1.0 / mass, (force + friction_effort(friction, v, mode)) / mass


@generic
def add_bristle_power(axis, power, v, mode):
    """Return the power [W] less what the bristles of an axis take; the friction of events is in `axis_power`."""
    return power


@add_bristle_power.register(ForceAxis)
def _(axis, power, v, mode):
    return add_bristle_power(axis.friction, power, v, mode)


@add_bristle_power.register(LuGre)
def _(axis, power, v, mode):
    return power + friction_effort(axis, v, mode) * v


@generic
def mode_rate(axis, v, mode):
    """Return the derivative of an axis' friction state: 0 unless it has bristles."""
    return 0.0


@mode_rate.register(ForceAxis)
def _(axis, v, mode):
    return friction_state_rate(axis.friction, v, mode)


@generic
def initial_mode(axis, v):
    """Return the friction state of an axis that begins at velocity v."""
    return np.sign(v)


@initial_mode.register(ForceAxis)
def _(axis, v):
    return initial_mode(axis.friction, v)


@initial_mode.register(LuGre)
def _(axis, v):
    return initial_friction_state(axis, v)


@has_friction.register(ForceAxis)
def _(part):
    return has_friction(part.friction)


@step_control_of.register(ForceAxis)
def _(part):
    return step_control_of(part.friction)


@generic
def axis_guard(axis, v, mode, tau, i, pull):
    """Return the guard of the axis' friction: negative when slipping has ended or sticking cannot hold."""
    return 1.0


@axis_guard.register(ForceAxis)
def _(axis, v, mode, tau, i, pull):
    return friction_guard(axis.friction, v, mode, tau[i] + pull)


@generic
def mode_after_stop(axis, mode, tau, i, pull):
    """Return the mode of an axis at rest after its guard has failed in `mode`: 0 when friction holds it, else the way.

    An axis that stuck is free now: asking again whether friction holds it could, in the last digit, say yes.
    """
    return 0.0


@mode_after_stop.register(ForceAxis)
def _(axis, mode, tau, i, pull):
    return breakaway_mode(axis.friction, mode, tau[i] + pull)
