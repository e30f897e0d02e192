"""How an overhead crane with an elastic cable moves: forces on nodes, axes and hoist."""

from crane_sim import system
from crane_sim.jit import generic, kernel, routine
from crane_sim.overhead.axes import axis_power, demands, rail
from crane_sim.overhead.elastic import ElasticCrane, layout, mass_of, pull
from crane_sim.overhead.forces import NodeForces
from crane_sim.overhead.hoists import drum, drum_power
from crane_sim.overhead.switches import mode_of
from crane_sim.sources import value_at


@generic
def add_pushes(forces, p, t, x, out):
    """Add the given forces' accelerations at time t to the state's derivative `out`; return their power [W]."""
    return 0.0


@add_pushes.register(NodeForces)
def _(forces, p, t, x, out):
    nq, first, d, _ = layout(p)
    i = nq + first + d * (forces.node - 1) + (forces.axis if d == 3 else forces.axis // 2)
    force = value_at(forces.channel, t)
    out[i] += force / mass_of(p, x, forces.node)
    return force * x[i] + add_pushes(forces.rest, p, t, x, out)


@system.fill.register(ElasticCrane)
def _(p, t, x, u, out):
    derive(p, t, x, system.effort(u, p, t, x), out)


@routine
def derive(p, t, x, tau, out):
    """Write the time derivative of the state under efforts tau into `out`."""
    nq, _, _, modes = layout(p)
    supplied = supply(p, t, x, tau, out)
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if modes > 2 * nq:
        out[2 * nq] = supplied


@kernel
def supply(p, t, x, tau, out):
    """Return the power [W] that drives, imposed motions, forces and losses supply; write motions (2 nq) into `out`."""
    nq, _, _, _ = layout(p)
    for i in range(nq):
        out[i], out[nq + i] = x[nq + i], 0.0
    lost = hang(p, x, out)
    return add_pushes(p.forces, p, t, x, out) + drive(p, t, x, tau, out) - lost


@routine
def hang(p, x, out):
    """Add what links and gravity do to the nodes; return the power [W] that dampers take."""
    nq, first, d, _ = layout(p)
    losses = 0.0
    for k in range(len(p.cable.masses)):
        (nx, ny, nz), tension, lost = pull(p, x, k)
        below, i = tension / mass_of(p, x, k + 1), nq + first + d * k
        losses += lost
        out[i] -= below * nx
        out[i + d - 1] -= below * nz + p.gravity
        if d == 3:
            out[i + 1] -= below * ny
        if k > 0:
            above = tension / p.cable.masses[k - 1]
            out[i - d] += above * nx
            out[i - 1] += above * nz
            if d == 3:
                out[i - 2] += above * ny
    return losses


@kernel
def drive(p, t, x, tau, out):
    """Write the accelerations of axes and hoist; return the power [W] that they supply."""
    nq, first, d, modes = layout(p)
    (nx, ny, _), tension, _ = pull(p, x, 0)
    give, free = rail(p.trolley, t, tau, 0, x[nq], mode_of(p.switches, x, modes, 0))
    out[nq] = free + give * tension * nx
    supplied = axis_power(p.trolley, tau, 0, x[nq], tension * nx)
    if d == 3:
        give, free = rail(p.bridge, t, tau, demands(p.trolley), x[nq + 1], mode_of(p.switches, x, modes, 1))
        out[nq + 1] = free + give * tension * ny
        supplied += axis_power(p.bridge, tau, demands(p.trolley), x[nq + 1], tension * ny)
    if first == d:
        give, free = drum(p.hoist, t, tau)
        out[nq + first - 1] = free + give * tension
        supplied += drum_power(p.hoist, tau, x[nq + first - 1], tension)
    return supplied
