"""A winch that drives a rope over sheaves: response of the length of the falls, and its stick and slip as events.

The mode is that of dry friction (`friction`): 0 while the falls keep their length, else the direction of l'. They stick
while what the winch pulls lies between the lead line's tensions of paying out and of hauling in, with the static
friction of the winch itself on either side.
"""

from typing import NamedTuple

import numpy as np

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.stops import WINCH
from crane_sim.models.supports.friction import Friction, friction_effort
from crane_sim.models.supports.hoist import hoist_modes, hoist_response
from crane_sim.models.supports.reeving import (
    Reeving,
    dead_end_of,
    follow_rope,
    lead_at_rest,
    reeved_acceleration,
    reeving_energy,
    sheave_factor,
    winding_inertia,
)

HALVINGS = 50  # of the part of the friction that is in use at rest


class Torque(NamedTuple):
    """The presence of a drive by the drum's torque."""


class ReevedHoist(NamedTuple):
    """A winch that takes a force on the length of the falls, or the torque of its drum; positive pays out."""

    reeving: Reeving
    friction: Friction | None = None  # N, of the winch, in terms of the length
    torque: Torque | None = None

    def modes(self):
        """Return one where winch or sheaves have friction."""
        return 0 if self.friction is None and self.reeving.loss is None else 1

    def lead_force(self, tau, length):
        """Return the winch's force [N] on the lead line under the efforts of all joints, positive pays out."""
        if self.torque is None:
            return tau[-1] / self.reeving.falls
        return tau[-1] / radius_of_drum(self.reeving, length)

    def response(self, tau, mode, motion):
        """Return the result of `winch_response`; mode: by `winch_mode`."""
        length, rate, gravity = motion
        if self.modes() > 0 and mode == 0.0:
            return 0.0, 0.0
        force = self.lead_force(tau, length)
        force += friction_effort(self.friction, rate, mode) / self.reeving.falls
        return reeved_acceleration(self.reeving, sheave_factor(self.reeving.loss, mode), force, length, rate, gravity)

    def power(self, tau, mode, motion, pull, gravity):
        """Return the result of `winch_power`."""
        reeving, factor = self.reeving, sheave_factor(self.reeving.loss, mode)
        dead_end = dead_end_of(reeving, factor, pull, motion, gravity)
        _, _, _, lost = follow_rope(reeving, factor, dead_end, motion, gravity)
        effort = reeving.falls * self.lead_force(tau, motion[0])
        return (effort + friction_effort(self.friction, motion[1], mode) - lost) * motion[1]

    def slip_excess(self, tau, pull, length, gravity):
        """Return the forces [N] on the lead line that would (pay out, haul in) beyond what friction holds, at rest."""
        reeving, force = self.reeving, self.lead_force(tau, length)
        static = 0.0 if self.friction is None else self.friction.static / reeving.falls
        low = lead_at_rest(reeving, sheave_factor(reeving.loss, 1.0), pull, length, gravity)
        high = lead_at_rest(reeving, sheave_factor(reeving.loss, -1.0), pull, length, gravity)
        return force + low - static, -force - high - static

    def winch_guard(self, tau, mode, motion, pull):
        """Return the guard of its stick and slip; arguments of the function `winch_guard`."""
        if mode != 0.0:
            return mode * motion[1]
        out, in_ = self.slip_excess(tau, pull, motion[0], motion[2])
        return -max(out, in_)

    def stopped_mode(self, mode_before, tau, pull, length, gravity):
        """Return the result of `mode_of_stopped_winch`."""
        out, in_ = self.slip_excess(tau, pull, length, gravity)
        if mode_before != 0.0 and max(out, in_) <= 0.0:
            return 0.0
        return 1.0 if out > in_ else -1.0

    def used_direction(self, tau, pull, length, gravity):
        """Return the direction of `sheave_factor` of a rope that sticks: by the friction in use, between -1 and 1."""
        force, low, high = self.lead_force(tau, length), -1.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            lead = lead_at_rest(self.reeving, sheave_factor(self.reeving.loss, middle), pull, length, gravity)
            low, high = (middle, high) if lead + force > 0.0 else (low, middle)
        return 0.5 * (low + high)


def winch_response(hoist, t, tau, x, at, motion):
    """Return the result of `hoist_response` for any hoist below a support.

    Args:
        hoist: its parameters.
        t: time [s].
        tau: efforts of all joints, the hoist's own the last one.
        x: state.
        at: indices of the length's rate and of the hoist's mode in it.
        motion: (length [m], its rate [m/s], gravity [m/s²]).
    """
    if isinstance(hoist, ReevedHoist):
        return hoist.response(tau, winch_mode(hoist, x, at[1]), motion)
    return hoist_response(hoist, t, tau, x[at[0]], winch_mode(hoist, x, at[1]))


def winch_mode(hoist, x, i):
    """Return the mode of the hoist, x[i], 0 for one without friction."""
    return x[i] if hoist_modes(hoist) > 0 else 0.0


def winch_power(hoist, tau, mode, motion, pull, gravity):
    """Return the power [W] that any hoist below a support supplies, its losses taken off; 0 without one.

    Args:
        hoist: its parameters.
        tau: efforts of all joints, the hoist's own the last one.
        mode: of `winch_mode`.
        motion: (length [m], its rate [m/s], its acceleration [m/s²]).
        pull: of all falls on what is below [N].
        gravity: acceleration of free fall [m/s²].
    """
    if hoist is None:
        return 0.0
    if isinstance(hoist, ReevedHoist):
        return hoist.power(tau, mode, motion, pull, gravity)
    return hoist.power(tau, motion[1], pull)


def winch_energy(hoist, length, rate, gravity):
    """Return (kinetic, potential) energy [J] of rope, sheaves and drum; potential: of the rope, from the falls' top."""
    if not isinstance(hoist, ReevedHoist):
        return 0.0, 0.0
    return reeving_energy(hoist.reeving, length, rate, gravity)


def winch_guard(hoist, best, tau, mode, motion, pull):
    """Return the smaller one of `best` and the guard of the winch's stick and slip; motion: (length, rate, gravity)."""
    if hoist_modes(hoist) == 0:
        return best
    return smaller_guard(best, hoist.winch_guard(tau, mode, motion, pull), encode(Guard.FRICTION, WINCH))


def mode_of_stopped_winch(hoist, mode_before, tau, pull, length, gravity):
    """Return the mode of a winch at rest after its guard has failed in mode `mode_before`, see `breakaway_mode`."""
    return hoist.stopped_mode(mode_before, tau, pull, length, gravity)


def slip_direction(hoist, rate, mode):
    """Return the direction in which the rope of a hoist with a reeving moves: of a prescribed one that of the rate."""
    return mode if isinstance(hoist, ReevedHoist) else np.sign(rate)


def rope_direction(hoist, tau, mode, pull, motion, gravity):
    """Return the direction of `sheave_factor` by which the tensions of a hoist's falls follow from the pull on them.

    A rope that sticks uses the same part of the friction on every sheave; a prescribed one uses none at rest.
    """
    if not isinstance(hoist, ReevedHoist):
        return np.sign(motion[1])
    if mode != 0.0 or hoist.modes() == 0:
        return mode
    return hoist.used_direction(tau, pull, motion[0], gravity)


def radius_of_drum(reeving, length):
    """Return the radius [m] of the rope's centre line where it leaves the drum, 0 without one."""
    return 0.0 if reeving.drum is None else reeving.drum.winding_radius(reeving.length - reeving.falls * length)[0]


def drum_torque(reeving, lead, motion):
    """Return the torque [N m] on a reeving's drum under this tension of the lead line, positive pays out; 0 without."""
    mass, q = winding_inertia(reeving, motion[0])
    force = mass * reeving.falls * motion[2] - q * motion[1] * motion[1] - lead
    return force * radius_of_drum(reeving, motion[0])
