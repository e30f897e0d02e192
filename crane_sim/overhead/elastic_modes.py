"""How an overhead crane with an elastic cable switches: stick and slip, slack links, its payload; and how it ends."""

from crane_sim import system
from crane_sim.jit import lean_kernel, lean_routine, routine
from crane_sim.overhead.axes import axis_guard, demands, freed, rubs
from crane_sim.overhead.elastic import LINK, ElasticCrane, layout, link, pull
from crane_sim.overhead.elastic_carried import deck
from crane_sim.overhead.elastic_outputs import energies
from crane_sim.overhead.switches import (
    FRICTION,
    LIMIT,
    PAYLOAD,
    friction_event,
    hoist_guard,
    lesser,
    limits_guard,
    payload_guard,
    switching_of,
)


@system.switching.register(ElasticCrane)
def _(p):
    forces = rubs(p.trolley) or rubs(p.bridge) or (p.cable.tension_only > 0.0 and damped(p.cable.damping))
    return switching_of(p.switches, forces, layout(p)[0])


@lean_kernel
def damped(damping):
    """Return whether a link has a damper: then whether it pulls depends on its rate too."""
    found = False
    for c in damping:
        found = found or c > 0.0
    return found


@system.guard.register(ElasticCrane)
def _(p, t, x, u, work):
    return (*least_guard(p, t, x, system.effort(u, p, t, x)), 0)


@lean_routine
def least_guard(p, t, x, tau):
    """Return (the smallest guard, its number)."""
    nq, first, d, modes = layout(p)
    ((nx, ny, _), tension, _), ship = pull(p, x, 0), deck(p, t, x)
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, tension * nx + ship.x), FRICTION)
    best = limits_guard(p.switches, best, 0, x[0])
    if d == 3:
        bridge = axis_guard(p.bridge, x[nq + 1], x[modes + 1], tau, demands(p.trolley), tension * ny + ship.y)
        best = limits_guard(p.switches, lesser(best, bridge, FRICTION + 1), 1, x[1])
    if first == d:
        best = hoist_guard(p.switches, best, x[first - 1])
    best = payload_guard(p.switches, best, t, x[len(x) - 1])
    if p.cable.tension_only > 0.0:
        for k in range(len(p.cable.masses)):
            best = lesser(best, link_guard(p, x, k, x[modes + d - 1 + k]), LINK + k)
    return best


@lean_kernel
def link_guard(p, x, k, taut):
    """Return the guard [N] of a link that only pulls: a slack one pulls where both its e and its k e + c e' are > 0."""
    _, _, stretch, rate = link(p, x, k)
    spring, total = p.cable.stiffness[k] * stretch, p.cable.stiffness[k] * stretch + p.cable.damping[k] * rate
    return total if taut > 0.0 else -min(spring, total)


@system.switched.register(ElasticCrane)
def _(p, t, x, u, which):
    return switch(p, t, x, system.effort(u, p, t, x), which)


@routine
def switch(p, t, x, tau, which):
    """Return (the state after guard `which` has failed, the event to note, whether the crane goes on)."""
    nq, _, d, modes = layout(p)
    x, event = x.copy(), which
    before = sum(energies(p, x))
    if which >= LINK:
        mode = modes + d - 1 + which - LINK
        x[mode] = 1.0 - x[mode]
        event = LINK + 2 * (which - LINK) + int(x[mode])
    elif which == PAYLOAD:
        x[len(x) - 1] += 1.0
    elif which < LIMIT:
        axis = which - FRICTION
        failed = x[modes + axis]
        x[nq + axis], x[modes + axis] = (0.0 if failed != 0.0 else x[nq + axis]), 0.0
        (n, tension, _), ship = pull(p, x, 0), deck(p, t, x)
        if axis == 0:  # not one call with either axis: they may be of different types, and the type chooses the body
            x[modes] = freed(p.trolley, failed, tau, 0, tension * n[0] + ship.x)
        else:
            x[modes + 1] = freed(p.bridge, failed, tau, demands(p.trolley), tension * n[1] + ship.y)
        event = friction_event(axis, x[modes + axis])
    else:
        return x, which, False
    x[2 * nq] += sum(energies(p, x)) - before  # the payload takes its energy along, a slack spring that left in it
    return x, event, True
