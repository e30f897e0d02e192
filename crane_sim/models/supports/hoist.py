"""Hoists, which change the first link's length: its acceleration as a function of the tension.

All have the methods of `PrescribedHoist`; a crane without a hoist has None, for which there are
functions. The hoist's effort is the last one of those of all joints, `tau`. `motion` begins with
the length [m] and its rate [m/s]; a power needs its acceleration [m/s²] behind them.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.files.types import Positive
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.stops import WINCH
from crane_sim.models.supports.friction import Friction, forced_response, friction_force
from crane_sim.models.supports.reeving import Reeving
from crane_sim.trajectories.profiles import Motion, motion_acceleration

HOIST = 2  # index of the hoist among the joints that friction can hold, after trolley and bridge


class PrescribedHoist(NamedTuple):
    """A winch that gives the first link a length that is a function of time."""

    profile: Motion

    def response(self, t: Any, tau: Any, mode: Any, motion: Any, gravity: Any) -> tuple[Any, Any]:
        """Return (inverse mass [1/kg], bias acceleration [m/s²]) of the length.

        Without inertia it is (-1, tension [N]).

        Args:
            t: time [s].
            tau: efforts of all joints [N].
            mode: of the hoist's friction, anything without.
            motion: of the length.
            gravity: acceleration of free fall [m/s²].
        """
        return 0.0, motion_acceleration(self.profile, t)

    def power(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the power [W] of the winch less its losses under a `pull` [N] on the length."""
        return -pull * motion[1]


class ForceHoist(NamedTuple):
    """A winch with inertia that takes a force command; positive pays out."""

    reflected_mass: Positive  # kg, drum inertia over radius squared
    friction: Friction | None = None  # N, of the drum, in terms of the rope

    def modes(self) -> int:
        """Return the number of modes: one, to hold or to slip, where it has friction."""
        return 0 if self.friction is None else 1

    def response(self, t: Any, tau: Any, mode: Any, motion: Any, gravity: Any) -> tuple[Any, Any]:
        """Return that of a mass under a force."""
        return forced_response(self.friction, self.reflected_mass, tau[-1], motion[1], mode)

    def power(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the power of the force, less what friction takes."""
        return (tau[-1] - friction_force(self.friction, motion[1])) * motion[1]

    def winch_guard(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the guard of its stick and slip under a pull [N] on the length."""
        return (
            1.0 if self.friction is None else self.friction.guard(motion[1], mode, tau[-1] + pull)
        )

    def stopped_mode(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return its mode at rest after its guard failed in `mode`.

        See `Friction.breakaway_mode`.
        """
        return 0.0 if self.friction is None else self.friction.breakaway_mode(mode, tau[-1] + pull)


class MasslessHoist(NamedTuple):
    """A winch without inertia: the first link's tension is minus the command (Brogliato)."""

    push: float = 0.0  # 1: efforts that pay out are applied, 0: they count as zero, since a rope
    # transmits tension only

    def response(self, t: Any, tau: Any, mode: Any, motion: Any, gravity: Any) -> tuple[Any, Any]:
        """Return the tension."""
        return -1.0, -tau[-1]

    def power(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the power against the pull."""
        return -pull * motion[1]


class MotionHoist(NamedTuple):
    """A winch that imposes the length's acceleration [m/s²], or its velocity [m/s] with a lag."""

    time_constant: Positive | None = None  # s, of the lag; None: the input is the acceleration
    reeving: Reeving | None = None  # what its falls carry, and its drum's torque, follow from the
    # motion

    def response(self, t: Any, tau: Any, mode: Any, motion: Any, gravity: Any) -> tuple[Any, Any]:
        """Return the acceleration that is imposed."""
        return 0.0, winch_acceleration(self.time_constant, motion[1], tau[-1])

    def power(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the power of the motion against the pull."""
        return -pull * motion[1]

    def slip_direction(self, rate: Any, mode: Any) -> Any:
        """Return the direction of `sheave_factor` of its rope: that in which it moves."""
        return np.sign(rate)

    def rope_direction(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the `sheave_factor` direction by which tensions follow the pull: 0 at rest."""
        return np.sign(motion[1])


Hoist = PrescribedHoist | ForceHoist | MasslessHoist | MotionHoist


def winch_acceleration(time_constant, rate, u):
    """Return the acceleration [m/s²] of the length that a winch imposes at input u."""
    return u if time_constant is None else (u - rate) / time_constant


def hoist_coordinates(hoist):
    """Return the number of coordinates of a hoist."""
    return 0 if hoist is None else 1


def hoist_modes(hoist):
    """Return the number of modes of a hoist: of one with friction 1."""
    return hoist.modes() if hasattr(hoist, "modes") else 0


def hoist_response(hoist, t, tau, mode, motion, gravity):
    """Return the result of `response`, that of a length that stays without a hoist."""
    return (0, 0) if hoist is None else hoist.response(t, tau, mode, motion, gravity)


def hoist_guard(hoist, best, tau, mode, motion, pull, gravity):
    """Return the smaller one of `best` and the guard of the winch's friction, if it has any."""
    if hoist_modes(hoist) == 0:
        return best
    return smaller_guard(
        best, hoist.winch_guard(tau, mode, motion, pull, gravity), encode(Guard.FRICTION, WINCH)
    )


def hoist_reflected_mass(hoist):
    """Return the reflected mass [kg] of the winch: drum inertia over radius squared."""
    return hoist.reflected_mass if isinstance(hoist, ForceHoist) else 0.0


def hoist_entry(hoist, row, i):
    """Return entry i of the row as a tuple for a hoist that takes an effort, empty for others."""
    return () if hoist is None or isinstance(hoist, PrescribedHoist) else (row[i],)


def limit_hoist(hoist, u):
    """Return the efforts (nu,) with the hoist's, the last one, replaced by what it can apply.

    What has inertia takes every effort. Of a winch without any, minus the effort is the tension,
    which cannot be negative.
    """
    if not isinstance(hoist, MasslessHoist):
        return u
    last = u[-1] if hoist.push > 0.0 else min(u[-1], 0.0)
    return (*u[:-1], last)
