"""Guards and switches of overhead cranes, from what the cable pulls on the axes and its tension at the top.

`tension` [N] is that of the first link; `pulls` [N] are those of the cable and of a moving base on trolley and bridge.
"""

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.overhead import count_axes, layout_of
from crane_sim.models.overhead.modes import get_mode, hoist_guard, limits_guard, make_switching, payload_guard
from crane_sim.models.supports.friction import Friction, friction_of, step_control_of
from crane_sim.models.supports.hoist import HOIST, hoist_mode, hoist_modes
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.supports.rails import input_count
from crane_sim.models.wind_kink import with_kink_switching


def switching_of(p, forces):
    """Return the result of `system.switching`; forces: whether guards depend on them, apart from those of friction."""
    frictions = [friction_of(drive) for drive in (p.trolley, p.bridge, p.hoist)]
    rubs = any([isinstance(friction, Friction) for friction in frictions])
    control = step_control_of(*frictions)
    return with_kink_switching(p.wind, make_switching(p.event_limits, rubs or forces, layout_of(p)[0], control))


def drive_sticks(drive, mode):
    """Return whether friction holds an axis or a hoist in this mode; None: the crane has none."""
    friction = friction_of(drive)
    return False if friction is None else friction.sticks(mode)


def drive_guard(drive, v, mode, tau, i, pull):
    """Return the guard of the friction of an axis or a hoist, whose effort is tau[i], at a pull [N] of the cable."""
    friction = friction_of(drive)
    return 1.0 if friction is None else friction.guard(v, mode, tau[i] + pull)


def mode_after_stop(drive, mode, tau, i, pull):
    """Return the mode of an axis or a hoist at rest after its guard has failed in `mode`, see `breakaway_mode`."""
    friction = friction_of(drive)
    return friction.breakaway_mode(mode, tau[i] + pull) if isinstance(friction, Friction) else 0.0


def needs_forces(p, x):
    """Return whether a guard of a crane with rigid links depends on forces: one that sticks, or must stay taut."""
    _, _, modes = layout_of(p)
    sticks = drive_sticks(p.trolley, x[modes]) or drive_sticks(p.bridge, x[modes + 1])
    return p.event_limits.taut > 0.0 or sticks or drive_sticks(p.hoist, hoist_mode(x))


def smallest_drive_guard(p, t, x, tau, tension, pulls, length):
    """Return the smallest guard of axes, hoist and payload; length: of the first link [m], None: it has no limits."""
    nq, first, modes = layout_of(p)
    best = (drive_guard(p.trolley, x[nq], x[modes], tau, 0, pulls[0]), encode(Guard.FRICTION, 0))
    if p.bridge is not None:
        bridge = drive_guard(p.bridge, x[nq + 1], x[modes + 1], tau, input_count(p.trolley), pulls[1])
        best = smaller_guard(best, bridge, encode(Guard.FRICTION, 1))
    for axis in range(count_axes(p)):
        best = limits_guard(p.event_limits, best, axis, x[axis])
    if length is not None:
        best = hoist_guard(p.event_limits, best, length)
    if hoist_modes(p.hoist) > 0:
        hoist = drive_guard(p.hoist, x[nq + first - 1], hoist_mode(x), tau, -1, tension)
        best = smaller_guard(best, hoist, encode(Guard.FRICTION, HOIST))
    return payload_guard(p.event_limits, best, t, x[len(x) - 1])


def mode_of_stopped_drive(p, joint, mode, tau, tension, pulls):
    """Return the new mode of an axis or a hoist at rest, after the guard of its friction has failed in `mode`."""
    if joint == HOIST:
        return mode_after_stop(p.hoist, mode, tau, -1, tension)
    if p.bridge is None or joint == 0:
        return mode_after_stop(p.trolley, mode, tau, 0, pulls[0])
    return mode_after_stop(p.bridge, mode, tau, input_count(p.trolley), pulls[1])


def add_bristle_power(axis, power, v, mode):
    """Return the power [W] less what the bristles of an axis take; the friction of events is in its own power."""
    friction = friction_of(axis)
    return power + friction.effort(v, mode) * v if isinstance(friction, LuGre) else power


def drives_power(p, x, tau, tension, pulls, rate):
    """Return the power [W] of axes and hoist, and of their friction; rate: of the first link's length [m/s]."""
    nq, _, modes = layout_of(p)
    power = p.trolley.power(tau, 0, x[nq], pulls[0])
    if p.bridge is not None:
        power += p.bridge.power(tau, input_count(p.trolley), x[nq + 1], pulls[1])
    if p.hoist is not None:
        power += p.hoist.power(tau, rate, tension)
    power = add_bristle_power(p.trolley, power, x[nq], get_mode(p.event_limits, x, modes, 0))
    if p.bridge is not None:
        power = add_bristle_power(p.bridge, power, x[nq + 1], get_mode(p.event_limits, x, modes, 1))
    return power
