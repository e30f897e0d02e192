"""Hoists, which change the first link's length: its acceleration as a function of the tension."""

from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.numerics.jit import generic, kernel, lean_generic
from crane_sim.trajectories.profiles import Motion, evaluate_motion


class PrescribedHoist(NamedTuple):
    """A winch that gives the first link a length that is a function of time."""

    profile: Motion


class ForceHoist(NamedTuple):
    """A winch with inertia that takes a force command; positive pays out."""

    reflected_mass: Positive  # kg, drum inertia over radius squared
    push: float = 0.0  # 1: efforts that pay out are applied, 0: they count as zero, since a rope transmits tension only


class MasslessHoist(NamedTuple):
    """A winch without inertia: the tension of the first link is minus the commanded force (Brogliato's model)."""

    push: float = 0.0  # see `ForceHoist`


Hoist = PrescribedHoist | ForceHoist | MasslessHoist


@lean_generic
def hoist_coordinates(hoist):
    """Return the number of coordinates of the hoist."""
    return 1


@hoist_coordinates.register(type(None))
def _(hoist):
    return 0


@lean_generic
def hoist_response(hoist, t, tau):
    """Return (inverse mass [1/kg], bias acceleration [m/s²]) of the length; of a massless winch (-1, tension [N])."""
    return 0.0, 0.0


@hoist_response.register(PrescribedHoist)
def _(hoist, t, tau):
    return 0.0, evaluate_motion(hoist.profile, t)[2]


@hoist_response.register(ForceHoist)
def _(hoist, t, tau):
    return 1.0 / hoist.reflected_mass, tau[len(tau) - 1] / hoist.reflected_mass


@hoist_response.register(MasslessHoist)
def _(hoist, t, tau):
    return -1.0, -tau[len(tau) - 1]


@lean_generic
def hoist_reflected_mass(hoist):
    """Return the reflected mass [kg] of the winch: drum inertia over radius squared."""
    return 0.0


@hoist_reflected_mass.register(ForceHoist)
def _(hoist):
    return hoist.reflected_mass


@lean_generic
def hoist_power(hoist, tau, rate, tension):
    """Return the power [W] that the winch supplies at this rate of length and tension."""
    return -tension * rate


@hoist_power.register(ForceHoist)
def _(hoist, tau, rate, tension):
    return tau[len(tau) - 1] * rate


@generic
def limit_hoist(hoist, u):
    """Return the efforts (nu,) with the hoist's, the last one, replaced by what it can apply."""
    return u


@limit_hoist.register(ForceHoist)
def _(hoist, u):
    return limit_to_pull(hoist.push, u)


@limit_hoist.register(MasslessHoist)
def _(hoist, u):
    return limit_to_pull(hoist.push, u)


@kernel
def limit_to_pull(push, u):
    """Return the efforts with the last one, which pays out where it is positive, at most 0 unless `push` is 1."""
    last = u[-1] if push > 0.0 else min(u[-1], 0.0)
    return (*u[:-1], last)
