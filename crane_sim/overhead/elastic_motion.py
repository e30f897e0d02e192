"""How an overhead crane with an elastic cable moves: forces on nodes, axes and hoist."""

from crane_sim import system
from crane_sim.base import carried
from crane_sim.jit import lean_generic, lean_kernel, lean_routine
from crane_sim.overhead.axes import axis_power, demands, rail
from crane_sim.overhead.elastic import ElasticCrane, layout, mass_of, pull
from crane_sim.overhead.elastic_carried import deck, push_points
from crane_sim.overhead.forces import NodeForces
from crane_sim.overhead.hoists import drum, drum_power
from crane_sim.overhead.switches import mode_of
from crane_sim.sources import value_at


@lean_generic
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
def _(p, t, x, u, out, work):
    move(p, t, x, system.effort(u, p, t, x), out)


@lean_routine
def move(p, t, x, tau, out):
    """Write the time derivative of the state under efforts tau into `out`; return the power [W] supplied.

    That is the power of drives, imposed motions and given forces, less what friction and dampers take.
    """
    nq, _, _, modes = layout(p)
    n, tension, lost = pull(p, x, 0)
    lost = hang(p, x, (tension * n[0], tension * n[1], tension * n[2]), out) + lost
    supplied = drive(p, t, x, tau, n, tension, out) + add_pushes(p.forces, p, t, x, out) - lost
    supplied += push_points(carried(p.base, p.gravity, t), p, x, out)
    for i in range(nq):
        out[i] = x[nq + i]
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if modes > 2 * nq:
        out[2 * nq] = supplied
    return supplied


@lean_kernel
def hang(p, x, force, out):
    """Write the nodes' accelerations, given the first link's force (3,); return the power [W] of the other dampers."""
    nq, first, d, _ = layout(p)
    lost, i, masses = 0.0, nq + first, p.cable.masses
    fx, fy, fz = force
    for k in range(1, len(masses)):
        (nx, ny, nz), tension, taken = pull(p, x, k)
        gx, gy, gz, inverse = tension * nx, tension * ny, tension * nz, 1.0 / masses[k - 1]
        place(out, i, d, (gx - fx) * inverse, (gy - fy) * inverse, (gz - fz) * inverse - p.gravity)
        fx, fy, fz, lost, i = gx, gy, gz, lost + taken, i + d
    inverse = 1.0 / mass_of(p, x, len(masses))
    place(out, i, d, -fx * inverse, -fy * inverse, -fz * inverse - p.gravity)
    return lost


@lean_kernel
def place(out, i, d, ax, ay, az):
    """Write a vector to out[i] and on; in the plane its last component takes the place of the one that is not there."""
    out[i], out[i + 1] = ax, ay
    out[i + d - 1] = az


@lean_kernel
def drive(p, t, x, tau, n, tension, out):
    """Write the accelerations of axes and hoist; return the power [W] that they supply."""
    nq, first, d, modes = layout(p)
    ship = deck(p, t, x)
    give, free = rail(p.trolley, t, tau, 0, x[nq], mode_of(p.switches, x, modes, 0))
    out[nq] = free + give * tension * n[0] + give * ship.x
    supplied = axis_power(p.trolley, tau, 0, x[nq], tension * n[0]) + ship.power
    if d == 3:
        give, free = rail(p.bridge, t, tau, demands(p.trolley), x[nq + 1], mode_of(p.switches, x, modes, 1))
        out[nq + 1] = free + give * tension * n[1] + give * ship.y
        supplied += axis_power(p.bridge, tau, demands(p.trolley), x[nq + 1], tension * n[1])
    if first == d:
        give, free = drum(p.hoist, t, tau)
        out[nq + first - 1] = free + give * tension
        supplied += drum_power(p.hoist, tau, x[nq + first - 1], tension)
    return supplied
