"""A winch that drives a rope over sheaves: response of the length of the falls, and its stick and slip as events.

The mode is that of dry friction (`friction`): 0 while the falls keep their length, else the direction of l'. They stick
while what the winch pulls lies between the lead line's tensions of paying out and of hauling in, with the static
friction of the winch itself on either side.
"""

from typing import NamedTuple

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.stops import WINCH
from crane_sim.models.supports.friction import Friction, friction_effort, has_friction, step_control_of
from crane_sim.models.supports.hoist import hoist_modes, hoist_power, hoist_response
from crane_sim.models.supports.reeving import (
    Drum,
    Reeving,
    SheaveLoss,
    dead_end_of,
    drum_radius,
    follow_rope,
    lead_at_rest,
    reeved_acceleration,
    reeving_energy,
    sheave_factor,
    winding_inertia,
)
from crane_sim.numerics.jit import generic

HALVINGS = 50  # of the part of the friction that is in use at rest


class Torque(NamedTuple):
    """The presence of a drive by the drum's torque."""


class ReevedHoist(NamedTuple):
    """A winch that takes a force on the length of the falls, or the torque of its drum; positive pays out."""

    reeving: Reeving
    friction: Friction | None = None  # N, of the winch, in terms of the length
    torque: Torque | None = None


@has_friction.register(SheaveLoss)
def _(part):
    return True


@hoist_modes.register(ReevedHoist)
def _(hoist):
    return 1 if has_friction(hoist.friction) or has_friction(hoist.reeving.loss) else 0


@step_control_of.register(ReevedHoist)
def _(part):
    return step_control_of(part.friction)


@generic
def radius_of_drum(drum, reeving, length):
    """Return the radius [m] of the rope's centre line where it leaves the drum, 0 without one."""
    return 0.0


@radius_of_drum.register(Drum)
def _(drum, reeving, length):
    return drum_radius(drum.layers, drum, reeving.length - reeving.falls * length)[0]


@generic
def lead_force(torque, reeving, effort, length):
    """Return the winch's force [N] on the lead line at an effort on the length, positive pays out."""
    return effort / reeving.falls


@lead_force.register(Torque)
def _(torque, reeving, effort, length):
    return effort / radius_of_drum(reeving.drum, reeving, length)


@generic
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
    return hoist_response(hoist, t, tau, x, at[0])


@winch_response.register(ReevedHoist)
def _(hoist, t, tau, x, at, motion):
    (length, rate, gravity), mode = motion, winch_mode(hoist, x, at[1])
    if hoist_modes(hoist) > 0 and mode == 0.0:
        return 0.0, 0.0
    force = lead_force(hoist.torque, hoist.reeving, tau[len(tau) - 1], length)
    force += friction_effort(hoist.friction, rate, mode) / hoist.reeving.falls
    return reeved_acceleration(hoist.reeving, sheave_factor(hoist.reeving.loss, mode), force, length, rate, gravity)


def winch_mode(hoist, x, i):
    """Return the mode of the hoist, x[i], 0 for one without friction."""
    return x[i] if hoist_modes(hoist) > 0 else 0.0


@generic
def winch_power(hoist, tau, mode, motion, pull, gravity):
    """Return the power [W] that any hoist below a support supplies, its losses taken off.

    Args:
        hoist: its parameters.
        tau: efforts of all joints, the hoist's own the last one.
        mode: of `winch_mode`.
        motion: (length [m], its rate [m/s], its acceleration [m/s²]).
        pull: of all falls on what is below [N].
        gravity: acceleration of free fall [m/s²].
    """
    return hoist_power(hoist, tau, motion[1], pull)


@winch_power.register(ReevedHoist)
def _(hoist, tau, mode, motion, pull, gravity):
    reeving, factor = hoist.reeving, sheave_factor(hoist.reeving.loss, mode)
    dead_end = dead_end_of(reeving, factor, pull, motion, gravity)
    _, _, _, lost = follow_rope(reeving, factor, dead_end, motion, gravity)
    effort = reeving.falls * lead_force(hoist.torque, reeving, tau[len(tau) - 1], motion[0])
    return (effort + friction_effort(hoist.friction, motion[1], mode) - lost) * motion[1]


@generic
def winch_energy(hoist, length, rate, gravity):
    """Return (kinetic, potential) energy [J] of rope, sheaves and drum; potential: of the rope, from the falls' top."""
    return 0.0, 0.0


@winch_energy.register(ReevedHoist)
def _(hoist, length, rate, gravity):
    return reeving_energy(hoist.reeving, length, rate, gravity)


@generic
def static_friction(friction):
    """Return the friction [N] up to which a winch sticks, in terms of the length."""
    return 0.0


@static_friction.register(Friction)
def _(friction):
    return friction.static


def slip_excess(hoist, tau, pull, length, gravity):
    """Return the forces [N] on the lead line that would (pay out, haul in) beyond what friction holds, at rest."""
    reeving = hoist.reeving
    force = lead_force(hoist.torque, reeving, tau[len(tau) - 1], length)
    static = static_friction(hoist.friction) / reeving.falls
    low = lead_at_rest(reeving, sheave_factor(reeving.loss, 1.0), pull, length, gravity)
    high = lead_at_rest(reeving, sheave_factor(reeving.loss, -1.0), pull, length, gravity)
    return force + low - static, -force - high - static


@generic
def winch_guard(hoist, best, tau, mode, motion, pull):
    """Return the smaller one of `best` and the guard of the winch's stick and slip; motion: (length, rate, gravity)."""
    return best


@winch_guard.register(ReevedHoist)
def _(hoist, best, tau, mode, motion, pull):
    if hoist_modes(hoist) == 0:
        return best
    if mode != 0.0:
        return smaller_guard(best, mode * motion[1], encode(Guard.FRICTION, WINCH))
    out, in_ = slip_excess(hoist, tau, pull, motion[0], motion[2])
    return smaller_guard(best, -max(out, in_), encode(Guard.FRICTION, WINCH))


@generic
def mode_of_stopped_winch(hoist, mode_before, tau, pull, length, gravity):
    """Return the mode of a winch at rest after its guard has failed in mode `mode_before`, see `breakaway_mode`."""
    return 0.0


@mode_of_stopped_winch.register(ReevedHoist)
def _(hoist, mode_before, tau, pull, length, gravity):
    out, in_ = slip_excess(hoist, tau, pull, length, gravity)
    if mode_before != 0.0 and max(out, in_) <= 0.0:
        return 0.0
    return 1.0 if out > in_ else -1.0


@generic
def slip_direction(hoist, rate, mode):
    """Return the direction in which the rope of a hoist with a reeving moves: of a prescribed one that of the rate."""
    return 1.0 if rate > 0.0 else -1.0 if rate < 0.0 else 0.0


@slip_direction.register(ReevedHoist)
def _(hoist, rate, mode):
    return mode


@generic
def rope_direction(hoist, tau, mode, pull, motion, gravity):
    """Return the direction of `sheave_factor` by which the tensions of a hoist's falls follow from the pull on them.

    A rope that sticks uses the same part of the friction on every sheave; a prescribed one uses none at rest.
    """
    return slip_direction(hoist, motion[1], mode)


@rope_direction.register(ReevedHoist)
def _(hoist, tau, mode, pull, motion, gravity):
    if mode != 0.0 or hoist_modes(hoist) == 0:
        return mode
    force, low, high = lead_force(hoist.torque, hoist.reeving, tau[len(tau) - 1], motion[0]), -1.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        lead = lead_at_rest(hoist.reeving, sheave_factor(hoist.reeving.loss, middle), pull, motion[0], gravity)
        low, high = (middle, high) if lead + force > 0.0 else (low, middle)
    return 0.5 * (low + high)


def drum_torque(reeving, lead, motion):
    """Return the torque [N m] on a reeving's drum under this tension of the lead line, positive pays out; 0 without."""
    mass, q = winding_inertia(reeving, motion[0])
    force = mass * reeving.falls * motion[2] - q * motion[1] * motion[1] - lead
    return force * radius_of_drum(reeving.drum, reeving, motion[0])
