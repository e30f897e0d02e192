"""A trolley on a rail along x: driven by a force, moved as prescribed, or fixed.

What the cable needs of it is its compliance (its acceleration for a unit force; 0 when its motion is imposed) and the
acceleration that it has when the cable does not pull.
"""

from typing import NamedTuple

from crane_sim.jit import generic
from crane_sim.motions import Motion, acceleration_at
from crane_sim.quantities import Positive


class ForceTrolley(NamedTuple):
    """A trolley that takes a force command."""

    mass: Positive  # kg


class PrescribedTrolley(NamedTuple):
    """A trolley whose position is a given function of time."""

    motion: Motion


class FixedTrolley(NamedTuple):
    """A trolley that stays where it is."""


@generic
def rail(trolley, t, tau):
    """Return (compliance [1/kg], free acceleration [m/s²]) at time t under joint efforts tau."""
    return 0.0, 0.0


@rail.register(ForceTrolley)
def _(trolley, t, tau):
    return 1.0 / trolley.mass, tau[0] / trolley.mass


@rail.register(PrescribedTrolley)
def _(trolley, t, tau):
    return 0.0, acceleration_at(trolley.motion, t)


@generic
def trolley_mass(trolley):
    """Return the mass [kg] that moves with the rail coordinate and is modelled: none when its motion is imposed."""
    return 0.0


@trolley_mass.register(ForceTrolley)
def _(trolley):
    return trolley.mass


@generic
def rail_power(trolley, tau, v, pull):
    """Return the power [W] that the drive supplies at rail velocity v when the cable pulls with `pull` along x [N]."""
    return -pull * v


@rail_power.register(ForceTrolley)
def _(trolley, tau, v, pull):
    return tau[0] * v
