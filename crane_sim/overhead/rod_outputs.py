"""What a crane with a straight cable shows, and how it switches."""

from math import cos, sin

import numpy as np

from crane_sim import system
from crane_sim.jit import generic, kernel, routine
from crane_sim.overhead.axes import axis_guard, axis_mass, freed, rubs
from crane_sim.overhead.efforts import driven, efforts
from crane_sim.overhead.hoists import drum_inertia, hoist_limited
from crane_sim.overhead.rod import DISTANCE, MASS, RodCrane, layout, moments, on_meter, supply, swing_of, upper
from crane_sim.overhead.switches import (
    FRICTION,
    LINK,
    PAYLOAD,
    Switches,
    changes_before,
    friction_event,
    hoist_guard,
    lesser,
    limits_guard,
    payload_guard,
    switching_of,
)
from crane_sim.state_algebra import replaced


@generic
def coordinates(hoist, x, i):
    """Return the joint coordinates (nq,) that stand from x[i] on, as a tuple."""
    return x[i], x[i + 1], x[i + 2]


@coordinates.register(type(None))
def _(hoist, x, i):
    return x[i], x[i + 1]


@generic
def first_modes(switches, t, v):
    """Return the modes that a crane with trolley velocity v starts in at time t."""
    return ()


@first_modes.register(Switches)
def _(switches, t, v):
    return np.sign(v), changes_before(switches, t)


@system.state.register(RodCrane)
def _(p, t, q, v):
    known = first_modes(p.switches, t, v[0])
    return (*coordinates(p.hoist, q, 0), *coordinates(p.hoist, v, 0), *on_meter(p.meter, 0.0), *known)


@system.joints.register(RodCrane)
def _(p, x):
    nq, _ = layout(p)
    return coordinates(p.hoist, x, 0), coordinates(p.hoist, x, nq)


@system.actuated.register(RodCrane)
def _(p, x):
    nq, _ = layout(p)
    return driven(p.trolley, p.hoist, x, 0), driven(p.trolley, p.hoist, x, nq)


@system.held.register(RodCrane)
def _(p, row):
    return efforts(p.trolley, p.hoist, row)


@system.limited.register(RodCrane)
def _(p, u):
    return hoist_limited(p.hoist, u)


@system.acceleration.register(RodCrane)
def _(p, t, x, u):
    nq, _ = layout(p)
    return coordinates(p.hoist, system.rhs(p, t, x, u), nq)


@system.kinetic.register(RodCrane)
def _(p, x):
    nq, _ = layout(p)
    length, rate = upper(p.hoist, p.cable, x)
    total, first, second, _ = moments(p, x, length)
    s, c, v, w = sin(x[nq - 1]), cos(x[nq - 1]), x[nq], x[2 * nq - 1]
    carried = total * (0.5 * (v * v + rate * rate) + v * rate * s) + first * v * w * c + 0.5 * second * w * w
    return carried + 0.5 * axis_mass(p.trolley) * v * v + 0.5 * drum_inertia(p.hoist) * rate * rate


@system.potential.register(RodCrane)
def _(p, x):
    nq, _ = layout(p)
    length, _ = upper(p.hoist, p.cable, x)
    return -p.gravity * moments(p, x, length)[1] * cos(x[nq - 1])


@system.link_count.register(RodCrane)
def _(p):
    return p.cable.nodes.shape[1]


@system.tensions.register(RodCrane)
def _(p, t, x, u, rows, i, first):
    nq, _ = layout(p)
    now, (length, _) = swing_of(p, t, x, system.effort(u, p, t, x)), upper(p.hoist, p.cable, x)
    fall, square = p.gravity * now.c - now.trolley * now.s - now.paid, x[2 * nq - 1] * x[2 * nq - 1]
    rows[i, first] = now.tension
    for k in range(1, rows.shape[1] - first):  # each link carries what the one above does, less the node between them
        reach = length + p.cable.nodes[DISTANCE, k - 1]
        rows[i, first + k] = rows[i, first + k - 1] - p.cable.nodes[MASS, k - 1] * (fall + reach * square)


@system.power.register(RodCrane)
def _(p, t, x, u):
    tau = system.effort(u, p, t, x)
    return supply(p, x, tau, swing_of(p, t, x, tau))


@generic
def reading(meter, x, i):
    """Return entry i of x, where the meter stands; 0 without one."""
    return x[i]


@reading.register(type(None))
def _(meter, x, i):
    return 0.0


@system.supplied.register(RodCrane)
def _(p, x):
    nq, _ = layout(p)
    return reading(p.meter, x, 2 * nq)


@system.point_count.register(RodCrane)
def _(p):
    return 1 + p.cable.nodes.shape[1]


@system.points.register(RodCrane)
def _(p, t, x, out):
    nq, _ = layout(p)
    length, _ = upper(p.hoist, p.cable, x)
    s, c = sin(x[nq - 1]), cos(x[nq - 1])
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for i in range(p.cable.nodes.shape[1]):
        r = length + p.cable.nodes[DISTANCE, i]
        out[i + 1, 0], out[i + 1, 1], out[i + 1, 2] = x[0] + r * s, 0.0, -r * c


@system.switching.register(RodCrane)
def _(p):
    return switching_of(p.switches, rubs(p.trolley), layout(p)[0])


@system.guard.register(RodCrane)
def _(p, t, x, u, work):
    nq, modes = layout(p)
    tau = system.effort(u, p, t, x)
    taut = p.switches.taut > 0.0
    forces = taut or (rubs(p.trolley) and x[modes] == 0.0)
    tension, pull = forces_of(p, t, x, tau) if forces else (0.0, 0.0)
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, pull), FRICTION)
    best = limits_guard(p.switches, best, 0, x[0])
    best = hoist_guard(p.switches, best, upper(p.hoist, p.cable, x)[0])
    best = payload_guard(p.switches, best, t, x[modes + 1])
    value, which = lesser(best, tension, LINK) if taut else best
    return value, which, int(forces)


@kernel
def forces_of(p, t, x, tau):
    """Return (tension, pull on the trolley) [N]."""
    now = swing_of(p, t, x, tau)
    return now.tension, now.pull


@system.switched.register(RodCrane)
def _(p, t, x, u, which):
    return switch(p, t, x, system.effort(u, p, t, x), which)


@kernel
def energy(p, x):
    """Return the total energy [J]."""
    return system.kinetic(p, x) + system.potential(p, x)


@routine
def switch(p, t, x, tau, which):
    """Return (the state after guard `which` has failed, the event to note, whether the crane goes on)."""
    nq, modes = layout(p)
    if which == PAYLOAD:
        after = replaced(x, modes + 1, x[modes + 1] + 1.0)
        gained = energy(p, after) - energy(p, x)  # the payload takes its energy along
        return replaced(after, modes - 1, x[modes - 1] + gained), PAYLOAD, True
    if which == FRICTION:
        still = replaced(replaced(x, nq, 0.0 if x[modes] != 0.0 else x[nq]), modes, 0.0)
        mode = freed(p.trolley, x[modes], tau, 0, swing_of(p, t, still, tau).pull)
        return replaced(still, modes, mode), friction_event(0, mode), True
    return x, which, False
