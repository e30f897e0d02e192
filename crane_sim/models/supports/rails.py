"""Rails of a trolley in the plane, which carries the cable's upper end.

It is driven by a force, moved as prescribed, or fixed. What the cable needs of it is its inverse
mass (0 when its motion is imposed or friction holds it) and its bias acceleration: that when the
cable does not pull.

All have the methods of `FixedAxis`. Efforts `tau` are those of all joints, an axis' own has the
index i; `mode` is that of its friction: 0 sticks, else the direction in which it slips; or its
bristles' deflection.
"""

from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.models.supports.friction import Friction, forced_response, friction_force
from crane_sim.models.supports.lugre import LuGre
from crane_sim.trajectories.profiles import Motion, motion_acceleration


class ForceAxis(NamedTuple):
    """An axis that takes a force command."""

    mass: Positive  # kg, that moves with it
    friction: Friction | LuGre | None = None

    def response(self, t, tau, i, v, mode):
        """Return that of a mass under a force."""
        return forced_response(self.friction, self.mass, tau[i], v, mode)

    def power(self, tau, i, v, pull):
        """Return the power [W] of the force, less what friction takes that has modes."""
        return (tau[i] - friction_force(self.friction, v)) * v


class PrescribedAxis(NamedTuple):
    """An axis whose position is a given function of time."""

    motion: Motion

    def response(self, t, tau, i, v, mode):
        """Return the acceleration that is imposed."""
        return 0.0, motion_acceleration(self.motion, t)

    def power(self, tau, i, v, pull):
        """Return the power [W] of the motion against the pull."""
        return -pull * v


class FixedAxis(NamedTuple):
    """An axis that stays where it is."""

    def response(self, t, tau, i, v, mode):
        """Return (inverse mass [1/kg], bias acceleration [m/s²]) at t [s], velocity v [m/s]."""
        return 0.0, 0.0

    def power(self, tau, i, v, pull):
        """Return the power [W] of drive and friction at velocity v under the cable's `pull` [N]."""
        return -pull * v


Axis = ForceAxis | PrescribedAxis | FixedAxis


def axis_mass(axis):
    """Return the modelled mass [kg] that moves with an axis: none if its motion is imposed.

    There is none without an axis either.
    """
    return axis.mass if isinstance(axis, ForceAxis) else 0.0
