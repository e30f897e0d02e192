"""Event location: a model whose equations switch tells by guards when, and a step ends where the first guard fails.

A guard is a function of time and state that stays non-negative while the present mode is valid. Modes are part of the
state (their derivative is zero), so every method integrates one mode's smooth equations through a whole step; the part
of the step beyond the event is thrown away, the model switches its state, and the integration starts afresh.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.integrators.flow import OK, Flow, stages, state_at
from crane_sim.jit import generic, kernel, routine
from crane_sim.state_algebra import add, add_scaled, scale
from crane_sim.system import Switching, guard, rhs, switched

STOPPED = 100
"""From here on a flow's status tells that guard number `status - STOPPED` failed and the model ends with it."""
CHATTER = 3
LOOKS = 4  # instants of a step at which the guards are looked at
MOST_SWITCHES = 50  # at one instant; a model that wants more of them chatters
PROBES = 60  # for one event; halving alone would need about 50


class Seen(NamedTuple):
    """What happened: rows (time, number); once they are full, only the count goes on."""

    total: int
    rows: Any  # (capacity, 2)


@generic
def record(switches):
    """Return an empty record of events; None for a model that does not switch."""
    return None


@record.register(Switching)
def _(switches):
    return Seen(0, np.zeros((switches.capacity, 2)))


@generic
def settled(switches, p, u, flow):
    """Return the flow with every guard that fails at its present instant answered: efforts may have jumped there."""
    return flow


@settled.register(Switching)
def _(switches, p, u, flow):
    return switched_flow(p, u, flow)


@generic
def located(switches, method, p, u, flow):
    """Return the flow cut back to the first event of its last step, and switched; as it is where there is none."""
    return flow


@located.register(Switching)
def _(switches, method, p, u, flow):
    return cut_back(method, p, u, flow)


@kernel
def noted(seen, t, event):
    """Return the record with one more event."""
    if seen.total < len(seen.rows):
        seen.rows[seen.total, 0], seen.rows[seen.total, 1] = t, event
    return Seen(seen.total + 1, seen.rows)


@routine
def switched_flow(p, u, flow):
    """Return the flow after all switches at its present instant."""
    x, status, seen, h = flow.x, flow.status, flow.seen, flow.h
    value, which = guard(p, flow.t, x, u)
    switches = 0
    while value < 0.0 and status == OK:
        x, event, goes_on = switched(p, flow.t, x, u, which)
        seen, h, switches = noted(seen, flow.t, event), 0.0, switches + 1
        status = OK if goes_on else STOPPED + which
        if switches > MOST_SWITCHES:
            status = CHATTER
        value, which = guard(p, flow.t, x, u)
    n, taken, rejected = flow.evaluations, flow.steps, flow.rejected
    return Flow(flow.t0, flow.x0, flow.t, x, h, n, taken, rejected, status, seen)


@kernel
def between(flow, f0, f1, s):
    """Return the state at the part s of the last step, by cubic Hermite interpolation."""
    h, rise = flow.t - flow.t0, add_scaled(flow.x, -1.0, flow.x0)
    bend = add(scale((s - 1.0) * h, f0), scale(s * h, f1))
    bend = add_scaled(bend, 1.0 - 2.0 * s, rise)
    return add(add_scaled(flow.x0, s, rise), scale(s * (s - 1.0), bend))


@routine
def bracket(method, p, u, flow):
    """Return (low, high), times of the last step between which the first guard fails; (t, t) when none does."""
    f0, f1 = rhs(p, flow.t0, flow.x0, u), rhs(p, flow.t, flow.x, u)
    low = flow.t0
    for j in range(1, LOOKS):
        t = flow.t0 + (flow.t - flow.t0) * j / LOOKS
        value, _ = guard(p, t, between(flow, f0, f1, j / LOOKS), u)
        if value < 0.0:
            value, _ = guard(p, t, state_at(method, p, u, flow, t), u)
            if value < 0.0:
                return low, t
        low = t
    value, _ = guard(p, flow.t, flow.x, u)
    return (low, flow.t) if value < 0.0 else (flow.t, flow.t)


@routine
def crossing(method, p, u, flow, low, high):
    """Return (the first time after `low` at which a guard is found to fail, probes): false position and halving."""
    g_low, _ = guard(p, low, state_at(method, p, u, flow, low), u)
    g_high, _ = guard(p, high, state_at(method, p, u, flow, high), u)
    probes = 2
    while probes < PROBES:
        t = 0.5 * (low + high)
        if probes % 3 and g_low > 0.0:
            t = low + (high - low) * g_low / (g_low - g_high)
        if not low < t < high:
            t = 0.5 * (low + high)
        if not low < t < high:
            break
        g, _ = guard(p, t, state_at(method, p, u, flow, t), u)
        probes += 1
        if g < 0.0:
            high, g_high, g_low = t, g, 0.5 * g_low
        else:
            low, g_low, g_high = t, g, 0.5 * g_high
    return high, probes


@routine
def cut_back(method, p, u, flow):
    """Return the flow as `located` does."""
    if flow.status != OK:
        return flow
    low, high = bracket(method, p, u, flow)
    if low == high:
        return flow
    t, probes = crossing(method, p, u, flow, low, high)
    x = state_at(method, p, u, flow, t)
    n = flow.evaluations + probes * stages(method)
    cut = Flow(flow.t0, flow.x0, t, x, flow.h, n, flow.steps, flow.rejected, OK, flow.seen)
    return switched_flow(p, u, cut)
