"""What an overhead crane with an elastic cable shows: joint coordinates, energies, nodes."""

import numpy as np

from crane_sim import system
from crane_sim.jit import kernel, routine
from crane_sim.overhead.axes import axis_mass
from crane_sim.overhead.carried import show
from crane_sim.overhead.efforts import efforts_both, pushed, wound
from crane_sim.overhead.elastic import ElasticCrane, layout, link, mass_of, pull, tautness, vector
from crane_sim.overhead.elastic_motion import move
from crane_sim.overhead.hoists import drum_inertia, hoist_limited
from crane_sim.overhead.switches import changes_before, mode_count


@system.joints.register(ElasticCrane)
def _(p, x):
    nq, _, _, _ = layout(p)
    return x[:nq].copy(), x[nq : 2 * nq].copy()


@system.state.register(ElasticCrane)
def _(p, t, q, v):
    return state_of(p, t, q, v)


@routine
def state_of(p, t, q, v):
    """Return the state, with the modes that positions and velocities tell."""
    nq, _, d, modes = layout(p)
    n = len(p.cable.masses)
    x = np.zeros(modes + mode_count(p.switches, d - 1 + n))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    if len(x) > modes:
        for axis in range(d - 1):
            x[modes + axis] = np.sign(v[axis])
        for k in range(n):
            x[modes + d - 1 + k] = 1.0 if p.cable.tension_only == 0.0 or strain(p, x, k) >= 0.0 else 0.0
        x[len(x) - 1] = changes_before(p.switches, t)
    return x


@routine
def strain(p, x, k):
    """Return the smaller one of k e and k e + c e' [N] of link k: where it is positive, the link pulls."""
    _, _, stretch, rate = link(p, x, k)
    spring = p.cable.stiffness[k] * stretch
    return spring + min(0.0, p.cable.damping[k] * rate)


@system.actuated.register(ElasticCrane)
def _(p, x):
    nq, _, _, _ = layout(p)
    return driven_from(p, x, 0), driven_from(p, x, nq)


@kernel
def driven_from(p, x, i):
    """Return the actuated joints' share of the coordinates from x[i] on as a tuple: trolley, bridge, hoist."""
    _, _, d, _ = layout(p)
    return (*pushed(p.trolley, x, i), *pushed(p.bridge, x, i + 1), *wound(p.hoist, x, i + d - 1))


@system.held.register(ElasticCrane)
def _(p, row):
    return efforts_both(p.trolley, p.bridge, p.hoist, row)


@system.limited.register(ElasticCrane)
def _(p, u):
    return hoist_limited(p.hoist, u)


@system.acceleration.register(ElasticCrane)
def _(p, t, x, u):
    nq, _, _, _ = layout(p)
    return system.rhs(p, t, x, u)[nq : 2 * nq].copy()


@routine
def energies(p, x):
    """Return (kinetic, potential) energy, that of slack links left out."""
    nq, first, d, modes = layout(p)
    kinetic, potential = 0.5 * axis_mass(p.trolley) * x[nq] ** 2, 0.0
    if d == 3:
        kinetic += 0.5 * axis_mass(p.bridge) * x[nq + 1] ** 2
    if first == d:
        kinetic += 0.5 * drum_inertia(p.hoist) * x[nq + first - 1] ** 2
    for k in range(len(p.cable.masses)):
        mass, (vx, vy, vz) = mass_of(p, x, k + 1), vector(p, x, k + 1, 1)
        _, _, stretch, _ = link(p, x, k)
        taut = tautness(p.switches, x, modes + d - 1 + k)
        kinetic += 0.5 * mass * (vx * vx + vy * vy + vz * vz)
        potential += mass * p.gravity * vector(p, x, k + 1, 0)[2]
        potential += 0.5 * taut * p.cable.stiffness[k] * stretch * stretch
    return kinetic, potential


@system.kinetic.register(ElasticCrane)
def _(p, x):
    return energies(p, x)[0]


@system.potential.register(ElasticCrane)
def _(p, x):
    return energies(p, x)[1]


@system.link_count.register(ElasticCrane)
def _(p):
    return len(p.cable.masses)


@system.tensions.register(ElasticCrane)
def _(p, t, x, u, rows, i, first):
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = pull(p, x, k)[1]


@system.power.register(ElasticCrane)
def _(p, t, x, u):
    return move(p, t, x, system.effort(u, p, t, x), np.empty(len(x)))


@system.supplied.register(ElasticCrane)
def _(p, x):
    nq, _, _, modes = layout(p)
    return x[2 * nq] if modes > 2 * nq else 0.0


@system.point_count.register(ElasticCrane)
def _(p):
    return 1 + len(p.cable.masses)


@system.points.register(ElasticCrane)
def _(p, t, x, out):
    for k in range(1 + len(p.cable.masses)):
        out[k, 0], out[k, 1], out[k, 2] = vector(p, x, k, 0)
    show(p.base, t, out)
