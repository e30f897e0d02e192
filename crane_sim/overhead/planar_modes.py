"""How a planar overhead crane switches between sticking and slipping, changes its payload, and ends."""

from crane_sim import system
from crane_sim.jit import lean_routine, routine
from crane_sim.overhead.axes import axis_guard, freed, rubs
from crane_sim.overhead.chain import TENSION
from crane_sim.overhead.planar import PlanarCrane, first_link, layout, solved
from crane_sim.overhead.planar_outputs import energies
from crane_sim.overhead.switches import (
    FRICTION,
    PAYLOAD,
    friction_event,
    hoist_guard,
    limits_guard,
    payload_guard,
    slack_guard,
    switching_of,
)


@system.switching.register(PlanarCrane)
def _(p):
    return switching_of(p.switches, rubs(p.trolley), layout(p)[0])


@system.guard.register(PlanarCrane)
def _(p, t, x, u, work):
    return least_guard(p, t, x, system.effort(u, p, t, x), work)


@lean_routine
def least_guard(p, t, x, tau, w):
    """Return (the smallest guard, its number, evaluations)."""
    nq, _, modes = layout(p)
    forces = p.switches.taut > 0.0 or (rubs(p.trolley) and x[modes] == 0.0)
    pull = solved(p, t, x, tau, w).pull if forces else 0.0
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, pull), FRICTION)
    best = limits_guard(p.switches, best, 0, x[0])
    best = hoist_guard(p.switches, best, first_link(p.hoist, p.cable, x, nq)[0])
    best = payload_guard(p.switches, best, t, x[len(x) - 1])
    value, which = slack_guard(p.switches, best, w[TENSION], len(p.cable.masses))
    return value, which, int(forces)


@system.switched.register(PlanarCrane)
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
    if which == FRICTION:
        failed = x[modes]
        x[nq], x[modes] = (0.0 if failed != 0.0 else x[nq]), 0.0
        x[modes] = freed(p.trolley, failed, tau, 0, solved(p, t, x, tau, system.workspace(p)).pull)
        return x, friction_event(0, x[modes]), True
    return x, which, False
