"""What an overhead crane in space shows: joint coordinates, energies, nodes."""

import numpy as np

from crane_sim import system
from crane_sim.jit import routine
from crane_sim.overhead.axes import axis_mass
from crane_sim.overhead.carried import show
from crane_sim.overhead.directions import node_velocities
from crane_sim.overhead.efforts import driven_both, efforts_both
from crane_sim.overhead.hoists import drum_inertia, hoist_limited
from crane_sim.overhead.spatial import SpatialCrane, first_link, layout, links_of, solved, supply
from crane_sim.overhead.switches import changes_before, mode_count


@system.joints.register(SpatialCrane)
def _(p, x):
    nq, _, _ = layout(p)
    return x[:nq].copy(), x[nq : 2 * nq].copy()


@system.state.register(SpatialCrane)
def _(p, t, q, v):
    nq, _, modes = layout(p)
    x = np.zeros(modes + mode_count(p.switches, 2))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    if len(x) > modes:
        x[modes], x[modes + 1], x[len(x) - 1] = np.sign(v[0]), np.sign(v[1]), changes_before(p.switches, t)
    return x


@system.actuated.register(SpatialCrane)
def _(p, x):
    nq, _, _ = layout(p)
    return driven_both(p.trolley, p.bridge, p.hoist, x, 0), driven_both(p.trolley, p.bridge, p.hoist, x, nq)


@system.held.register(SpatialCrane)
def _(p, row):
    return efforts_both(p.trolley, p.bridge, p.hoist, row)


@system.limited.register(SpatialCrane)
def _(p, u):
    return hoist_limited(p.hoist, u)


@system.acceleration.register(SpatialCrane)
def _(p, t, x, u):
    nq, _, _ = layout(p)
    return system.rhs(p, t, x, u)[nq : 2 * nq].copy()


@routine
def energies(p, x):
    """Return (kinetic, potential) energy."""
    nq, _, _ = layout(p)
    links, rate = system.workspace(p).links, first_link(p.hoist, p.cable, x, nq)[1]
    links_of(p, x, links)
    v, z, potential = node_velocities(links, x[nq], x[nq + 1], rate), 0.0, 0.0
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2 + 0.5 * axis_mass(p.bridge) * x[nq + 1] ** 2
    kinetic += 0.5 * drum_inertia(p.hoist) * rate * rate
    for k in range(len(links.speeds)):
        mass = 1.0 / links.below[k]
        z = z + links.lengths[k] * links.units[k, 2]
        kinetic += 0.5 * mass * (v[k + 1, 0] ** 2 + v[k + 1, 1] ** 2 + v[k + 1, 2] ** 2)
        potential += mass * p.gravity * z
    return kinetic, potential


@system.kinetic.register(SpatialCrane)
def _(p, x):
    return energies(p, x)[0]


@system.potential.register(SpatialCrane)
def _(p, x):
    return energies(p, x)[1]


@system.link_count.register(SpatialCrane)
def _(p):
    return len(p.cable.masses)


@system.tensions.register(SpatialCrane)
def _(p, t, x, u, rows, i, first):
    work = system.workspace(p)
    solved(p, t, x, system.effort(u, p, t, x), work)
    for k in range(len(work.tension)):
        rows[i, first + k] = work.tension[k]


@system.power.register(SpatialCrane)
def _(p, t, x, u):
    tau, work = system.effort(u, p, t, x), system.workspace(p)
    return supply(p, t, x, tau, solved(p, t, x, tau, work), work)


@system.supplied.register(SpatialCrane)
def _(p, x):
    nq, _, modes = layout(p)
    return x[2 * nq] if modes > 2 * nq else 0.0


@system.point_count.register(SpatialCrane)
def _(p):
    return 1 + len(p.cable.masses)


@system.points.register(SpatialCrane)
def _(p, t, x, out):
    place(p, x, out)
    show(p.base, t, out)


@routine
def place(p, x, out):
    """Write the nodes (N + 1, 3) into `out`."""
    links = system.workspace(p).links
    links_of(p, x, links)
    out[0, 0], out[0, 1], out[0, 2] = x[0], x[1], 0.0
    for k in range(len(links.speeds)):
        for c in range(3):
            out[k + 1, c] = out[k, c] + links.lengths[k] * links.units[k, c]
