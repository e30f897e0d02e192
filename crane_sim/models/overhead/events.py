"""Guards and switches of overhead cranes, from what the cable pulls on the trolley and its tension at the top.

`tension` [N] is that of the first link; `pull` [N] that of the cable and of a moving base on the trolley.
"""

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.overhead import hoist_mode, layout_of
from crane_sim.models.overhead.modes import hoist_guard, limits_guard, make_switching, payload_guard, trolley_mode
from crane_sim.models.supports.friction import Friction, friction_of, step_control_of
from crane_sim.models.supports.hoist import HOIST, hoist_modes
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.wind_kink import with_kink_switching


def switching_of(p):
    """Return the result of `system.switching`."""
    frictions = [friction_of(drive) for drive in (p.trolley, p.hoist)]
    rubs = any([isinstance(friction, Friction) for friction in frictions])
    control = step_control_of(*frictions)
    return with_kink_switching(p.wind, make_switching(p.event_limits, rubs, layout_of(p)[0], control))


def drive_sticks(drive, mode):
    """Return whether friction holds a trolley or a hoist in this mode; None: the crane has none."""
    friction = friction_of(drive)
    return False if friction is None else friction.sticks(mode)


def needs_forces(p, x):
    """Return whether a guard depends on forces: of a drive that sticks, or of links that must stay taut."""
    _, _, modes = layout_of(p)
    return p.event_limits.taut > 0.0 or drive_sticks(p.trolley, x[modes]) or drive_sticks(p.hoist, hoist_mode(x))


def smallest_drive_guard(p, t, x, tau, tension, pull, length):
    """Return the smallest guard of trolley, hoist and payload; length: of the first link [m]."""
    (nq, first, modes), best, friction = layout_of(p), (1.0, encode(Guard.FRICTION, 0)), friction_of(p.trolley)
    if friction is not None:
        best = friction.guard(x[nq], x[modes], tau[0] + pull), encode(Guard.FRICTION, 0)
    best = hoist_guard(p.event_limits, limits_guard(p.event_limits, best, x[0]), length)
    if hoist_modes(p.hoist) > 0:
        hoist = p.hoist.friction.guard(x[nq + first - 1], hoist_mode(x), tau[-1] + tension)
        best = smaller_guard(best, hoist, encode(Guard.FRICTION, HOIST))
    return payload_guard(p.event_limits, best, t, x[len(x) - 1])


def mode_of_stopped_drive(p, joint, mode, tau, tension, pull):
    """Return the new mode of trolley or hoist at rest, after the guard of its friction has failed in `mode`."""
    if joint == HOIST:
        return mode_after_stop(p.hoist, mode, tau, -1, tension)
    return mode_after_stop(p.trolley, mode, tau, 0, pull)


def mode_after_stop(drive, mode, tau, i, pull):
    """Return the mode of a trolley or a hoist at rest after its guard has failed in `mode`, see `breakaway_mode`."""
    friction = friction_of(drive)
    return friction.breakaway_mode(mode, tau[i] + pull) if isinstance(friction, Friction) else 0.0


def drives_power(p, x, tau, tension, pull, rate):
    """Return the power [W] of trolley and hoist, and of their friction; rate: of the first link's length [m/s]."""
    nq, _, modes = layout_of(p)
    power, friction = p.trolley.power(tau, 0, x[nq], pull), friction_of(p.trolley)
    if p.hoist is not None:
        power += p.hoist.power(tau, 0.0, (0.0, rate), tension, p.gravity)
    if isinstance(friction, LuGre):  # the friction of events is in the trolley's own power
        power = power + friction.effort(x[nq], trolley_mode(p.event_limits, x, modes)) * x[nq]
    return power
