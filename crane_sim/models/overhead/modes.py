"""Discrete modes and events of an overhead crane: friction, limits, a slack link, changes of the payload.

A mode is a float at the end of the state that says which of several smooth equations hold; events change it. The modes
of a crane with rigid links and events, in this order (a crane without events has none):

| mode | of | value |
|---|---|---|
| friction | trolley | 0 while it sticks, else the direction of slipping, ±1; by `lugre` its bristles' deflection |
| friction | hoist, where it has some | the same |
| payload | | number of changes of the payload so far |

The deflection of bristles has a derivative; the others have 0 and change at events only.

A guard is a pair (value, number), see `models.guards`: an event is where the value of one becomes negative. Functions
`…_guard(limits, best, …)` return the smaller one of the guard `best` and of their own: so a model finds its smallest.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.models.guards import LOWER, UPPER, Guard, decode, describe_friction, encode, smaller_guard
from crane_sim.models.stops import describe_cable_event
from crane_sim.models.supports.friction import friction_of
from crane_sim.models.supports.hoist import HOIST, hoist_modes
from crane_sim.system import EVENT_LOG_CAPACITY, Switching


class EventLimits(NamedTuple):
    """Parameters of the guards of an overhead crane's events; infinite where there is no limit."""

    lower: float  # m, of the trolley
    upper: float
    shortest: float  # m, of the first link
    longest: float
    taut: float  # 1: a run ends when a rigid link goes slack, 0: links are rods that can push
    times: Any  # (changes,) s, when the payload changes
    masses: Any  # (changes + 1,) kg, of the payload before, between and after them


def make_switching(limits, forces, nq, step_control):
    """Return the result of `system.switching` for a crane with these limits of its events.

    Args:
        limits: None for a crane without events.
        forces: whether guards depend on velocities or forces, apart from those of links that must not go slack.
        nq: number of coordinates, which stand first in the state, followed by their rates.
        step_control: `system.EventStepControl` where a step that an event ends is held to the tolerance, since friction
            changes fast just before the event; None where it is not.
    """
    if limits is None:
        return None
    return Switching(EVENT_LOG_CAPACITY, 0 if forces or limits.taut > 0.0 else nq, step_control)


def trolley_mode(limits, x, first):
    """Return the trolley's friction state in state x, whose modes begin at index `first`; 0 of a crane without any."""
    return 0.0 if limits is None else x[first]


def mode_rate(trolley, v, mode):
    """Return the derivative of the trolley's friction state: 0 unless it has bristles."""
    friction = friction_of(trolley)
    return 0.0 if friction is None else friction.state_rate(v, mode)


def initial_mode(trolley, v):
    """Return the friction state of a trolley that begins at velocity v."""
    friction = friction_of(trolley)
    return np.sign(v) if friction is None else friction.initial_state(v)


def drum_modes(hoist, rate):
    """Return the mode of the hoist at this rate as a tuple, empty for one without friction."""
    return (np.sign(rate),) if hoist_modes(hoist) else ()


def initial_modes(p, t, v):
    """Return the modes of a crane with joint velocities v at time t, as a tuple."""
    if p.event_limits is None:
        return ()
    changes = count_payload_changes(p.event_limits, t)
    return (initial_mode(p.trolley, v[0]), *drum_modes(p.hoist, v[1]), changes)


def mass_of(p, x, k):
    """Return the mass [kg] of node k, from 1, of a cable with arrays of masses."""
    mass = p.cable.masses[k - 1]
    return mass if k < len(p.cable.masses) else get_payload_mass(p.event_limits, x, len(x) - 1, mass)


def get_payload_mass(limits, x, last, mass):
    """Return the payload's mass [kg] in state x, whose last index is `last`; `mass` for a crane without events."""
    return mass if limits is None else limits.masses[int(x[last])]


def count_payload_changes(limits, t):
    """Return the number of changes of the payload before time t [s]."""
    changes = 0.0
    if limits is not None:
        for time in limits.times:
            if time < t:
                changes += 1.0
    return changes


def limits_guard(limits, best, q):
    """Return the smaller one of `best` and the guard of the travel limits of the trolley at q [m]."""
    return smaller_guard(best, min(q - limits.lower, limits.upper - q), encode(Guard.TRAVEL, 0))


def hoist_guard(limits, best, length):
    """Return the smallest one of `best` and the guards of the first link's shortest and longest length [m]."""
    best = smaller_guard(best, length - limits.shortest, encode(Guard.LENGTH, LOWER))
    return smaller_guard(best, limits.longest - length, encode(Guard.LENGTH, UPPER))


def payload_guard(limits, best, t, changes):
    """Return the smaller one of `best` and the guard of the next change of the payload, after `changes` of them."""
    if changes < len(limits.times):
        return smaller_guard(best, limits.times[int(changes)] - t, encode(Guard.PAYLOAD, 0))
    return best


def slack_guard(limits, best, tensions, n):
    """Return the smallest one of `best` and the tensions [N] of n rigid links, where a slack one ends the run."""
    if limits.taut > 0.0:
        for k in range(n):
            best = smaller_guard(best, tensions[k], encode(Guard.LINK, k))
    return best


def describe_switch(p: Any, number: int) -> tuple[str, str]:
    """Return texts (meaning of a guard or event, what a user can change)."""
    kind, index, outcome = decode(number)
    if kind == Guard.PAYLOAD:
        return "the payload changed", ""
    if kind in (Guard.LINK, Guard.LENGTH) or (kind == Guard.FRICTION and index == HOIST):
        return describe_cable_event(number, p.event_limits.shortest if p.event_limits is not None else 0.0)
    if kind == Guard.TRAVEL:
        return "the trolley reached its travel limit", "change trolley.limits, or what drives the trolley"
    return describe_friction("trolley", outcome), ""
