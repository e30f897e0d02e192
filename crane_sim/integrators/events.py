"""Event location: a model whose equations switch tells by guards when, and a step ends where the first guard fails.

A guard is a function of time and state that stays non-negative while the present mode is valid. Modes are part of the
state (their derivative is zero), so every method integrates one mode's smooth equations through a whole step; the part
of the step beyond the event is thrown away, the model switches its state, and the integration starts afresh.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.integrators.flow import OK, Flow, Scratch, stages, state_at
from crane_sim.integrators.looks import LOOKS, ends, suspect
from crane_sim.jit import generic, kernel, routine
from crane_sim.system import Switching, guard, switched, switching

STOPPED = 100
"""From here on a flow's status tells that guard number `status - STOPPED` failed and the model ends with it."""
CHATTER = 3
MOST_SWITCHES = 50  # at one instant; a model that wants more of them chatters
PROBES = 60  # for one event; halving alone would need about 50


class Seen(NamedTuple):
    """What happened: rows (time, number); once they are full, only the count goes on."""

    total: int
    rows: Any  # (capacity, 2)


@generic
def work_of(scratch):
    """Return the model's workspace, None where it needs none."""
    return None


@work_of.register(Scratch)
def _(scratch):
    return scratch.work


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
    if flow.status != OK:
        return flow
    low, high, n = bracket(method, p, u, flow)
    n += flow.evaluations
    seen = Flow(flow.t0, flow.x0, flow.t, flow.x, flow.h, n, flow.steps, flow.rejected, OK, flow.seen, flow.scratch)
    return seen if low == high else cut_back(method, p, u, seen, low, high)


@kernel
def noted(seen, t, event):
    """Return the record with one more event."""
    if seen.total < len(seen.rows):
        seen.rows[seen.total, 0], seen.rows[seen.total, 1] = t, event
    return Seen(seen.total + 1, seen.rows)


@routine
def switched_flow(p, u, flow):
    """Return the flow after all switches at its present instant."""
    x, status, seen, h, work = flow.x, flow.status, flow.seen, flow.h, work_of(flow.scratch)
    value, which, n = guard(p, flow.t, x, u, work)
    switches = 0
    while value < 0.0 and status == OK:
        x, event, goes_on = switched(p, flow.t, x, u, which)
        seen, h, switches = noted(seen, flow.t, event), 0.0, switches + 1
        status = OK if goes_on else STOPPED + which
        if switches > MOST_SWITCHES:
            status = CHATTER
        value, which, more = guard(p, flow.t, x, u, work)
        n += more
    n, taken, rejected = flow.evaluations + n, flow.steps, flow.rejected
    return Flow(flow.t0, flow.x0, flow.t, x, h, n, taken, rejected, status, seen, flow.scratch)


@kernel
def look_at(flow, j):
    """Return the time of look number j at the last step."""
    return flow.t if j == LOOKS else flow.t0 + (flow.t - flow.t0) * j / LOOKS


@kernel
def probed(method, p, u, flow, t, work):
    """Return (the smallest guard at time t of the last step, by a step of its own, evaluations)."""
    value, _, n = guard(p, t, state_at(method, p, u, flow, t), u, work)
    return value, n if t == flow.t else n + stages(method)


@kernel
def bracket(method, p, u, flow):
    """Return (low, high, evaluations): the first guard fails between these times of the last step; equal: none does.

    Guards are looked at LOOKS times, at even distances and last at the end of the step: before that at interpolated
    states, and what seems to fail there is asked again at the true one. So a guard that recovers within the step is
    seen if it fails at one of these instants, which is sure where it stays negative for 1 / LOOKS of the step.
    """
    work, positions = work_of(flow.scratch), switching(p).positions
    slopes = ends(flow.scratch, p, u, flow, positions)
    j, n = suspect(p, u, flow, slopes, work, 1)
    n += 0 if positions > 0 else 2
    while j < LOOKS:
        value, more = probed(method, p, u, flow, look_at(flow, j), work)
        n += more
        if value < 0.0:
            break
        j, more = suspect(p, u, flow, slopes, work, j + 1)
        n += more
    if j > LOOKS:
        return flow.t, flow.t, n
    return look_at(flow, j - 1), look_at(flow, j), n


@routine
def crossing(method, p, u, flow, low, high):
    """Return (the first time after `low` when a guard is found to fail, evaluations): false position and halving."""
    work = work_of(flow.scratch)
    g_low, n = probed(method, p, u, flow, low, work)
    g_high, more = probed(method, p, u, flow, high, work)
    for probe in range(2, PROBES):
        n += more
        t = 0.5 * (low + high)
        if probe % 3 and g_low > 0.0:
            t = low + (high - low) * g_low / (g_low - g_high)
        if not low < t < high:
            t = 0.5 * (low + high)
        if not low < t < high:
            return high, n
        g, more = probed(method, p, u, flow, t, work)
        if g < 0.0:
            high, g_high, g_low = t, g, 0.5 * g_low
        else:
            low, g_low, g_high = t, g, 0.5 * g_high
    return high, n + more


@routine
def cut_back(method, p, u, flow, low, high):
    """Return the flow back at the first event, between `low` and `high`, and switched."""
    t, more = crossing(method, p, u, flow, low, high)
    n = flow.evaluations + more + stages(method)
    x = state_at(method, p, u, flow, t)
    cut = Flow(flow.t0, flow.x0, t, x, flow.h, n, flow.steps, flow.rejected, OK, flow.seen, flow.scratch)
    return switched_flow(p, u, cut)
