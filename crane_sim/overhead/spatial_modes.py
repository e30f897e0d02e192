"""How an overhead crane in space switches between sticking and slipping, changes its payload, and ends."""

from crane_sim import system
from crane_sim.jit import lean_kernel, lean_routine, routine
from crane_sim.overhead.axes import axis_guard, demands, freed, rubs
from crane_sim.overhead.spatial import SpatialCrane, first_link, layout, solved
from crane_sim.overhead.spatial_outputs import energies
from crane_sim.overhead.switches import (
    FRICTION,
    LIMIT,
    PAYLOAD,
    friction_event,
    hoist_guard,
    lesser,
    limits_guard,
    payload_guard,
    slack_guard,
    switching_of,
)


@system.switching.register(SpatialCrane)
def _(p):
    return switching_of(p.switches, rubs(p.trolley) or rubs(p.bridge), layout(p)[0])


@system.guard.register(SpatialCrane)
def _(p, t, x, u, work):
    return least_guard(p, t, x, system.effort(u, p, t, x), work)


@lean_routine
def least_guard(p, t, x, tau, work):
    """Return (the smallest guard, its number, evaluations)."""
    nq, _, modes = layout(p)
    sticks = (rubs(p.trolley) and x[modes] == 0.0) or (rubs(p.bridge) and x[modes + 1] == 0.0)
    forces = sticks or p.switches.taut > 0.0
    pull = solved(p, t, x, tau, work).pull if forces else (0.0, 0.0)
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, pull[0]), FRICTION)
    bridge = axis_guard(p.bridge, x[nq + 1], x[modes + 1], tau, demands(p.trolley), pull[1])
    best = limits_guard(p.switches, lesser(best, bridge, FRICTION + 1), 0, x[0])
    best = limits_guard(p.switches, best, 1, x[1])
    best = hoist_guard(p.switches, best, first_link(p.hoist, p.cable, x, nq)[0])
    best = payload_guard(p.switches, best, t, x[len(x) - 1])
    value, which = slack_guard(p.switches, best, work.tension, len(work.tension))
    return value, which, int(forces)


@system.switched.register(SpatialCrane)
def _(p, t, x, u, which):
    return switch(p, t, x, system.effort(u, p, t, x), which)


@routine
def switch(p, t, x, tau, which):
    """Return (the state after guard `which` has failed, the event to note, whether the crane goes on)."""
    nq, _, modes = layout(p)
    x = x.copy()
    if which == PAYLOAD:
        before = sum(energies(p, x))
        x[len(x) - 1] += 1.0
        x[2 * nq] += sum(energies(p, x)) - before  # the payload takes its energy along
        return x, PAYLOAD, True
    if which < LIMIT:
        axis = which - FRICTION
        failed = x[modes + axis]
        x[nq + axis], x[modes + axis] = (0.0 if failed != 0.0 else x[nq + axis]), 0.0
        x[modes + axis] = way(p, failed, tau, axis, solved(p, t, x, tau, system.workspace(p)).pull[axis])
        return x, friction_event(axis, x[modes + axis]), True
    return x, which, False


@lean_kernel
def way(p, failed, tau, axis, pull):
    """Return the mode of an axis at rest that the cable pulls, as `freed` does."""
    return (
        freed(p.trolley, failed, tau, 0, pull) if axis == 0 else freed(p.bridge, failed, tau, demands(p.trolley), pull)
    )
