"""Discrete modes and events of an overhead crane: friction, limits, slack links, payload changes.

A mode is a float at the end of the state that says which of several smooth equations hold; events
change it. The modes of a crane with rigid links and events, in this order (a crane without events
has none):

| mode | of | value |
|---|---|---|
| friction | trolley | 0 while it sticks, else the direction of slipping, ±1; by `lugre` its bristles' deflection |
| friction | hoist, where it has some | the same |
| payload | | number of changes of the payload so far |

The deflection of bristles has a derivative; the others have 0 and change at events only.

A guard is a pair (value, number), see `models.guards`: an event is where the value of one becomes
negative. `tension` [N] is that of the first link; `pull` [N] that of the cable and of a moving base
on the trolley.
"""  # noqa: E501

from typing import Any, NamedTuple

import numpy as np

from crane_sim.models.guards import (
    Guard,
    decode,
    describe_friction,
    encode,
    smaller_guard,
    travel_guard,
)
from crane_sim.models.overhead import hoist_mode, layout_of
from crane_sim.models.stops import Stops, describe_cable_event, length_guard
from crane_sim.models.supports.friction import Friction, friction_of, step_control_of
from crane_sim.models.supports.hoist import HOIST, hoist_modes
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.wind_kink import with_kink_switching
from crane_sim.system import EVENT_LOG_CAPACITY, Switching


class EventLimits(NamedTuple):
    """Parameters of the guards of an overhead crane's events."""

    travel: tuple[float, float]  # m, of the trolley; infinite where there is no limit
    stops: Stops  # of the first link's length, and of links that must stay taut
    times: Any  # (changes,) s, when the payload changes
    masses: Any  # (changes + 1,) kg, of the payload before, between and after them


def switching_of(p):
    """Return the result of `system.switching`.

    Guards depend on velocities or forces where there is friction, or links must stay taut.
    """
    if p.event_limits is None:
        return with_kink_switching(p.wind, None)
    frictions = [friction_of(drive) for drive in (p.trolley, p.hoist)]
    forces = p.event_limits.stops.taut > 0.0 or any(
        [isinstance(friction, Friction) for friction in frictions]
    )
    switching = Switching(
        EVENT_LOG_CAPACITY, 0 if forces else layout_of(p)[0], step_control_of(*frictions)
    )
    return with_kink_switching(p.wind, switching)


def trolley_mode(limits, x, first):
    """Return the trolley's friction state in state x; 0 of a crane without any.

    The modes in x begin at index `first`.
    """
    return 0.0 if limits is None else x[first]


def mode_rate(trolley, v, mode):
    """Return the derivative of the trolley's friction state: 0 unless it has bristles."""
    friction = friction_of(trolley)
    return 0.0 if friction is None else friction.state_rate(v, mode)


def drum_modes(hoist, rate):
    """Return the mode of the hoist at this rate as a tuple, empty for one without friction."""
    return (np.sign(rate),) if hoist_modes(hoist) else ()


def initial_modes(p, t, v):
    """Return the modes of a crane with joint velocities v at time t, as a tuple."""
    limits, friction = p.event_limits, friction_of(p.trolley)
    if limits is None:
        return ()
    trolley = np.sign(v[0]) if friction is None else friction.initial_state(v[0])
    changes = 0.0
    for time in limits.times:
        if time < t:
            changes += 1.0
    return (trolley, *drum_modes(p.hoist, v[1]), changes)


def get_payload_mass(limits, x, last, mass):
    """Return the payload's mass [kg] in state x; `mass` for a crane without events.

    `last` is the last index of the state.
    """
    return mass if limits is None else limits.masses[int(x[last])]


def drive_sticks(drive, mode):
    """Return whether friction holds a trolley or a hoist in this mode; None: the crane has none."""
    friction = friction_of(drive)
    return False if friction is None else friction.sticks(mode)


def needs_forces(p, x):
    """Return whether a guard depends on forces: a drive sticks, or links must stay taut."""
    _, _, modes = layout_of(p)
    sticks = drive_sticks(p.trolley, x[modes]) or drive_sticks(p.hoist, hoist_mode(x))
    return p.event_limits.stops.taut > 0.0 or sticks


def smallest_drive_guard(p, t, x, tau, tension, pull, length):
    """Return the smallest guard of trolley, hoist and payload; length: of the first link [m]."""
    (nq, first, modes), limits, friction = layout_of(p), p.event_limits, friction_of(p.trolley)
    best = 1.0, encode(Guard.FRICTION, 0)
    if friction is not None:
        best = friction.guard(x[nq], x[modes], tau[0] + pull), encode(Guard.FRICTION, 0)
    best = travel_guard(limits.travel, best, x[0], encode(Guard.TRAVEL, 0))
    best = length_guard(limits.stops, best, length, 0.0)
    if hoist_modes(p.hoist) > 0:
        hoist = p.hoist.friction.guard(x[nq + first - 1], hoist_mode(x), tau[-1] + tension)
        best = smaller_guard(best, hoist, encode(Guard.FRICTION, HOIST))
    changes = x[len(x) - 1]
    if changes < len(limits.times):
        best = smaller_guard(best, limits.times[int(changes)] - t, encode(Guard.PAYLOAD, 0))
    return best


def mode_of_stopped_drive(p, joint, mode, tau, tension, pull):
    """Return the mode of trolley or hoist at rest, after its friction's guard failed in `mode`."""
    if joint == HOIST:
        return mode_after_stop(p.hoist, mode, tau, -1, tension)
    return mode_after_stop(p.trolley, mode, tau, 0, pull)


def mode_after_stop(drive, mode, tau, i, pull):
    """Return the mode of a drive at rest after its guard failed in `mode`.

    See `breakaway_mode`.
    """
    friction = friction_of(drive)
    return friction.breakaway_mode(mode, tau[i] + pull) if isinstance(friction, Friction) else 0.0


def drives_power(p, x, tau, tension, pull, rate):
    """Return the power [W] of trolley and hoist and of friction; rate: of the length [m/s]."""
    nq, _, modes = layout_of(p)
    power, friction = p.trolley.power(tau, 0, x[nq], pull), friction_of(p.trolley)
    if p.hoist is not None:
        power += p.hoist.power(tau, 0.0, (0.0, rate), tension, p.gravity)
    if isinstance(friction, LuGre):  # the friction of events is in the trolley's own power
        power = power + friction.effort(x[nq], trolley_mode(p.event_limits, x, modes)) * x[nq]
    return power


def describe_switch(p: Any, number: int) -> tuple[str, str]:
    """Return texts (meaning of a guard or event, what a user can change)."""
    kind, index, outcome = decode(number)
    if kind == Guard.PAYLOAD:
        return "the payload changed", ""
    if kind in (Guard.LINK, Guard.LENGTH) or (kind == Guard.FRICTION and index == HOIST):
        return describe_cable_event(
            number, p.event_limits.stops.shortest if p.event_limits is not None else 0.0
        )
    if kind == Guard.TRAVEL:
        return (
            "the trolley reached its travel limit",
            "change trolley.limits, or what drives the trolley",
        )
    return describe_friction("trolley", outcome), ""
