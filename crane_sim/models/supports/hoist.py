"""Hoists, which change the first link's length: its acceleration as a function of the tension."""

from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.supports.friction import (
    Friction,
    breakaway_mode,
    friction_force,
    friction_guard,
    friction_response,
    has_friction,
    step_control_of,
)
from crane_sim.models.supports.reeving import Reeving
from crane_sim.numerics.jit import generic
from crane_sim.trajectories.profiles import Motion, motion_acceleration

HOIST = 2  # index of the hoist among the joints that friction can hold, after trolley and bridge


class PrescribedHoist(NamedTuple):
    """A winch that gives the first link a length that is a function of time."""

    profile: Motion


class ForceHoist(NamedTuple):
    """A winch with inertia that takes a force command; positive pays out."""

    reflected_mass: Positive  # kg, drum inertia over radius squared
    friction: Friction | None = None  # N, of the drum, in terms of the rope


class MasslessHoist(NamedTuple):
    """A winch without inertia: the tension of the first link is minus the commanded force (Brogliato's model)."""

    push: float = 0.0  # 1: efforts that pay out are applied, 0: they count as zero, since a rope transmits tension only


class MotionHoist(NamedTuple):
    """A winch that imposes the length's motion: its input is an acceleration [m/s²], or a velocity [m/s] with a lag."""

    time_constant: Positive | None = None  # s, of the lag; None: the input is the acceleration
    reeving: Reeving | None = None  # what its falls carry, and its drum's torque, follow from the motion


Hoist = PrescribedHoist | ForceHoist | MasslessHoist | MotionHoist


@generic
def hoist_coordinates(hoist):
    """Return the number of coordinates of the hoist."""
    return 1


@hoist_coordinates.register(type(None))
def _(hoist):
    return 0


@generic
def hoist_response(hoist, t, tau, x, i):
    """Return (inverse mass [1/kg], bias acceleration [m/s²]) of the length; of a massless winch (-1, tension [N]).

    Args:
        hoist: its parameters.
        t: time [s].
        tau: efforts of all joints, the hoist's own the last one [N].
        x, i: state, and the index of the length's rate in it.
    """
    return 0.0, 0.0


@hoist_response.register(PrescribedHoist)
def _(hoist, t, tau, x, i):
    return 0.0, motion_acceleration(hoist.profile, t)


@hoist_response.register(ForceHoist)
def _(hoist, t, tau, x, i):
    return drum_response(hoist.friction, hoist.reflected_mass, tau[len(tau) - 1], x, i)


@hoist_response.register(MotionHoist)
def _(hoist, t, tau, x, i):
    return 0.0, winch_acceleration(hoist.time_constant, x[i], tau[len(tau) - 1])


@generic
def winch_acceleration(time_constant, rate, u):
    """Return the acceleration [m/s²] of the length that a winch imposes at input u."""
    return u


@winch_acceleration.register(float)
def _(time_constant, rate, u):
    return (u - rate) / time_constant


@generic
def drum_response(friction, mass, force, x, i):
    """Return the result of `hoist_response` for a drum under a force."""
    return 1.0 / mass, force / mass


@drum_response.register(Friction)
def _(friction, mass, force, x, i):
    return friction_response(friction, mass, force, x[i], hoist_mode(x))


def hoist_mode(x):
    """Return the mode of the hoist's friction in state x: it stands before the number of payload changes."""
    return x[len(x) - 2]


@generic
def hoist_modes(hoist):
    """Return the number of modes of the hoist: one where it has friction."""
    return 0


@hoist_modes.register(ForceHoist)
def _(hoist):
    return 1 if has_friction(hoist.friction) else 0


@generic
def hoist_sticks(hoist, x):
    """Return whether friction holds the hoist in state x."""
    return False


@hoist_sticks.register(ForceHoist)
def _(hoist, x):
    return drum_sticks(hoist.friction, x)


@generic
def drum_sticks(friction, x):
    """Return the result of `hoist_sticks` for a drum with this friction."""
    return False


@drum_sticks.register(Friction)
def _(friction, x):
    return hoist_mode(x) == 0.0


@generic
def hoist_friction_guard(hoist, best, x, i, tau, tension):
    """Return the smaller one of `best` and the guard of the hoist's friction at the tension [N] of the first link."""
    return best


@hoist_friction_guard.register(ForceHoist)
def _(hoist, best, x, i, tau, tension):
    return drum_guard(hoist.friction, best, x, i, tau[len(tau) - 1] + tension)


@generic
def drum_guard(friction, best, x, i, force):
    """Return the result of `hoist_friction_guard` for a drum that `force` [N] would turn."""
    return best


@drum_guard.register(Friction)
def _(friction, best, x, i, force):
    return smaller_guard(best, friction_guard(friction, x[i], hoist_mode(x), force), encode(Guard.FRICTION, HOIST))


@generic
def mode_of_stopped_hoist(hoist, mode, tau, tension):
    """Return the mode of a hoist at rest after its guard has failed in `mode`, see `breakaway_mode`."""
    return 0.0


@mode_of_stopped_hoist.register(ForceHoist)
def _(hoist, mode, tau, tension):
    return breakaway_mode(hoist.friction, mode, tau[len(tau) - 1] + tension)


@has_friction.register(ForceHoist)
def _(part):
    return has_friction(part.friction)


@step_control_of.register(ForceHoist)
def _(part):
    return step_control_of(part.friction)


@hoist_response.register(MasslessHoist)
def _(hoist, t, tau, x, i):
    return -1.0, -tau[len(tau) - 1]


@generic
def hoist_reflected_mass(hoist):
    """Return the reflected mass [kg] of the winch: drum inertia over radius squared."""
    return 0.0


@hoist_reflected_mass.register(ForceHoist)
def _(hoist):
    return hoist.reflected_mass


@generic
def hoist_power(hoist, tau, rate, tension):
    """Return the power [W] that the winch supplies at this rate of length and tension."""
    return -tension * rate


@hoist_power.register(ForceHoist)
def _(hoist, tau, rate, tension):
    return (tau[len(tau) - 1] - friction_force(hoist.friction, rate)) * rate


@generic
def limit_hoist(hoist, u):
    """Return the efforts (nu,) with the hoist's, the last one, replaced by what it can apply.

    What has inertia takes every effort. Of a winch without any, minus the effort is the tension, which cannot be
    negative.
    """
    return u


@limit_hoist.register(MasslessHoist)
def _(hoist, u):
    last = u[-1] if hoist.push > 0.0 else min(u[-1], 0.0)
    return (*u[:-1], last)
