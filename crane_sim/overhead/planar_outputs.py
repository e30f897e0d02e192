"""What a planar overhead crane shows: joint coordinates, energies, tensions, nodes."""

from math import cos, sin

import numpy as np

from crane_sim import system
from crane_sim.jit import routine
from crane_sim.overhead.axes import axis_mass
from crane_sim.overhead.carried import show
from crane_sim.overhead.chain import BELOW, COS, LENGTH, TENSION
from crane_sim.overhead.efforts import driven, efforts
from crane_sim.overhead.hoists import drum_inertia, hoist_limited
from crane_sim.overhead.joints import joint_energy
from crane_sim.overhead.planar import PlanarCrane, first_link, layout, links_of, node_velocities, solved, supply
from crane_sim.overhead.rods import rod_energy
from crane_sim.overhead.switches import changes_before, mode_count


@system.joints.register(PlanarCrane)
def _(p, x):
    nq, _, _ = layout(p)
    return x[:nq].copy(), x[nq : 2 * nq].copy()


@system.state.register(PlanarCrane)
def _(p, t, q, v):
    nq, _, modes = layout(p)
    x = np.zeros(modes + mode_count(p.switches, 1))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    if len(x) > modes:
        x[modes], x[len(x) - 1] = np.sign(v[0]), changes_before(p.switches, t)
    return x


@system.actuated.register(PlanarCrane)
def _(p, x):
    nq, _, _ = layout(p)
    return driven(p.trolley, p.hoist, x, 0), driven(p.trolley, p.hoist, x, nq)


@system.held.register(PlanarCrane)
def _(p, row):
    return efforts(p.trolley, p.hoist, row)


@system.limited.register(PlanarCrane)
def _(p, u):
    return hoist_limited(p.hoist, u)


@system.acceleration.register(PlanarCrane)
def _(p, t, x, u):
    nq, _, _ = layout(p)
    return system.rhs(p, t, x, u)[nq : 2 * nq].copy()


@routine
def energies(p, x):
    """Return (kinetic, potential) energy."""
    nq, first, _ = layout(p)
    n, w, rate = len(p.cable.masses), system.workspace(p), first_link(p.hoist, p.cable, x, nq)[1]
    links_of(p, x, w)
    v, z, potential = node_velocities(p, x, w, rate), 0.0, joint_energy(p.joints, x[first:nq])
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2 + 0.5 * drum_inertia(p.hoist) * rate * rate
    kinetic += rod_energy(p.rods, x[nq + first : 2 * nq])
    for k in range(n):
        mass = 1.0 / w[BELOW, k]
        z = z - w[LENGTH, k] * w[COS, k]
        kinetic += 0.5 * mass * (v[k + 1, 0] ** 2 + v[k + 1, 2] ** 2)
        potential += mass * p.gravity * z
    return kinetic, potential


@system.kinetic.register(PlanarCrane)
def _(p, x):
    return energies(p, x)[0]


@system.potential.register(PlanarCrane)
def _(p, x):
    return energies(p, x)[1]


@system.link_count.register(PlanarCrane)
def _(p):
    return len(p.cable.masses)


@system.tensions.register(PlanarCrane)
def _(p, t, x, u, rows, i, first):
    w = system.workspace(p)
    solved(p, t, x, system.effort(u, p, t, x), w)
    for k in range(w.shape[1] - 1):
        rows[i, first + k] = w[TENSION, k]


@system.power.register(PlanarCrane)
def _(p, t, x, u):
    tau, w = system.effort(u, p, t, x), system.workspace(p)
    return supply(p, t, x, tau, solved(p, t, x, tau, w), w)


@system.supplied.register(PlanarCrane)
def _(p, x):
    nq, _, modes = layout(p)
    return x[2 * nq] if modes > 2 * nq else 0.0


@system.point_count.register(PlanarCrane)
def _(p):
    return 1 + len(p.cable.masses)


@system.points.register(PlanarCrane)
def _(p, t, x, out):
    nq, first, _ = layout(p)
    length, _ = first_link(p.hoist, p.cable, x, nq)
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for k in range(len(p.cable.masses)):
        link = length if k == 0 else p.cable.lengths[k]
        out[k + 1, 0] = out[k, 0] + link * sin(x[first + k])
        out[k + 1, 1] = 0.0
        out[k + 1, 2] = out[k, 2] - link * cos(x[first + k])
    show(p.base, t, out)
