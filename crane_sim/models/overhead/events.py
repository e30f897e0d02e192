"""Guards and switches of overhead cranes, from what the cable pulls on the axes and its tension at the top.

`tension` [N] is that of the first link; `pulls` [N] are those of the cable and of a moving base on trolley and bridge.
"""

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.overhead import count_axes, layout_of
from crane_sim.models.overhead.modes import get_mode, hoist_guard, limits_guard, make_switching, payload_guard
from crane_sim.models.supports.friction import first_not_none, step_control_of
from crane_sim.models.supports.hoist import (
    HOIST,
    hoist_friction_guard,
    hoist_power,
    hoist_sticks,
    mode_of_stopped_hoist,
)
from crane_sim.models.supports.rails import (
    add_bristle_power,
    axis_guard,
    axis_power,
    has_friction,
    input_count,
    mode_after_stop,
)
from crane_sim.models.wind_kink import with_kink_switching


def switching_of(p, forces):
    """Return the result of `system.switching`; forces: whether guards depend on them, apart from those of friction."""
    step_control = None
    for part in (p.hoist, p.bridge, p.trolley):
        step_control = first_not_none(step_control_of(part), step_control)
    rubs = has_friction(p.trolley) or has_friction(p.bridge) or has_friction(p.hoist)
    return with_kink_switching(p.wind, make_switching(p.event_limits, rubs or forces, layout_of(p)[0], step_control))


def needs_forces(p, x):
    """Return whether a guard of a crane with rigid links depends on forces: one that sticks, or must stay taut."""
    _, _, modes = layout_of(p)
    sticks = has_friction(p.trolley) and x[modes] == 0.0
    sticks = sticks or (has_friction(p.bridge) and x[modes + 1] == 0.0)
    return p.event_limits.taut > 0.0 or sticks or hoist_sticks(p.hoist, x)


def smallest_drive_guard(p, t, x, tau, tension, pulls, length):
    """Return the smallest guard of axes, hoist and payload; length: of the first link [m], None: it has no limits."""
    nq, first, modes = layout_of(p)
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, pulls[0]), encode(Guard.FRICTION, 0))
    if p.bridge is not None:
        bridge = axis_guard(p.bridge, x[nq + 1], x[modes + 1], tau, input_count(p.trolley), pulls[1])
        best = smaller_guard(best, bridge, encode(Guard.FRICTION, 1))
    for axis in range(count_axes(p)):
        best = limits_guard(p.event_limits, best, axis, x[axis])
    if length is not None:
        best = hoist_guard(p.event_limits, best, length)
    best = hoist_friction_guard(p.hoist, best, x, nq + first - 1, tau, tension)
    return payload_guard(p.event_limits, best, t, x[len(x) - 1])


def mode_of_stopped_drive(p, joint, mode, tau, tension, pulls):
    """Return the new mode of an axis or a hoist at rest, after the guard of its friction has failed in `mode`."""
    if joint == HOIST:
        return mode_of_stopped_hoist(p.hoist, mode, tau, tension)
    if p.bridge is None or joint == 0:
        return mode_after_stop(p.trolley, mode, tau, 0, pulls[0])
    return mode_after_stop(p.bridge, mode, tau, input_count(p.trolley), pulls[1])


def drives_power(p, x, tau, tension, pulls, rate):
    """Return the power [W] of axes and hoist, and of their friction; rate: of the first link's length [m/s]."""
    nq, _, modes = layout_of(p)
    power = axis_power(p.trolley, tau, 0, x[nq], pulls[0])
    if p.bridge is not None:
        power += axis_power(p.bridge, tau, input_count(p.trolley), x[nq + 1], pulls[1])
    power += hoist_power(p.hoist, tau, rate, tension)
    power = add_bristle_power(p.trolley, power, x[nq], get_mode(p.event_limits, x, modes, 0))
    if p.bridge is not None:
        power = add_bristle_power(p.bridge, power, x[nq + 1], get_mode(p.event_limits, x, modes, 1))
    return power
