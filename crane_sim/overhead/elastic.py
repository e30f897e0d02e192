"""An overhead crane whose cable is a chain of springs and dampers, in the vertical plane or in space.

State: one array [x, (y), (l1), r_1 .. r_N, x', (y'), (l1'), r_1' .. r_N', (energy supplied), (modes)] with the nodes'
positions r_k in the world: (x, z) each in the plane, (x, y, z) in space. Link k pulls with T = k e + c e', e its length
beyond the rest length, l1 of the first link where there is a hoist. Modes: friction of the axes, 1 or 0 for each link
that is taut or slack, changes of the payload.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.jit import generic, kernel, routine
from crane_sim.meter import Meter, meter_size
from crane_sim.overhead.audit import metered
from crane_sim.overhead.axes import Axis, axis_power, demands, rail
from crane_sim.overhead.forces import NodeForces
from crane_sim.overhead.hoists import Hoist, drum, drum_power, hoisted
from crane_sim.overhead.switches import Switches, mode_of, payload_mass, story
from crane_sim.sources import value_at

LINK = 2000
"""Events of link k, from 0: LINK + 2 k, it went slack; LINK + 2 k + 1, it pulls."""


class Springs(NamedTuple):
    """Node masses and links from the top, (N,) arrays; the last node is the payload."""

    masses: Any  # kg
    lengths: Any  # m, at rest; the first one is the initial one where there is a hoist
    stiffness: Any  # N/m
    damping: Any  # N s/m
    tension_only: float  # 1: a link that would push is slack, 0: links also push


class ElasticCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled. It is in space when it has a bridge."""

    trolley: Axis
    bridge: Axis | None
    cable: Springs
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    forces: NodeForces | None = None
    switches: Switches | None = None
    meter: Meter | None = None

    def metered(self, sampled: bool) -> "ElasticCrane":
        """Return the model with a meter where held efforts do not tell all the energy supplied."""
        return self._replace(meter=Meter()) if np.any(self.cable.damping) else metered(self, sampled)

    def story(self, which: int) -> tuple[str, str]:
        """Return (what event number `which` tells, what a user can change) in words."""
        if which < LINK:
            return story(which)
        return f"link {(which - LINK) // 2 + 1} {'pulls' if which % 2 else 'went slack'}", ""


@generic
def dimensions(bridge):
    """Return in how many dimensions the nodes move."""
    return 3


@dimensions.register(type(None))
def _(bridge):
    return 2


@kernel
def layout(p):
    """Return (number of coordinates, index of the first node's, dimensions, index of the first mode)."""
    d = dimensions(p.bridge)
    first = d - 1 + hoisted(p.hoist)
    nq = first + d * len(p.cable.masses)
    return nq, first, d, 2 * nq + meter_size(p.meter)


@generic
def rest_of_first(hoist, cable, x, top, nq):
    """Return (rest length, its rate) of the first link; its coordinate is number `top`."""
    return x[top], x[nq + top]


@rest_of_first.register(type(None))
def _(hoist, cable, x, top, nq):
    return cable.lengths[0], 0.0


@kernel
def vector(p, x, k, order):
    """Return the position (order 0) or velocity (order 1) of node k in the world, (3,); node 0 is the trolley."""
    nq, first, d, _ = layout(p)
    if k == 0:
        i = order * nq
        return x[i], x[i + 1] if d == 3 else 0.0, 0.0
    i = order * nq + first + d * (k - 1)
    return x[i], x[i + 1] if d == 3 else 0.0, x[i + d - 1]


@kernel
def link(p, x, k):
    """Return (unit vector (3,) from node k to node k + 1, length, elongation, its rate) of link k, from 0."""
    nq, first, _, _ = layout(p)
    rest, paid = p.cable.lengths[k], 0.0
    if k == 0:
        rest, paid = rest_of_first(p.hoist, p.cable, x, first - 1, nq)
    (ax, ay, az), (bx, by, bz) = vector(p, x, k, 0), vector(p, x, k + 1, 0)
    (ux, uy, uz), (vx, vy, vz) = vector(p, x, k, 1), vector(p, x, k + 1, 1)
    dx, dy, dz = bx - ax, by - ay, bz - az
    length = sqrt(dx * dx + dy * dy + dz * dz)
    nx, ny, nz = dx / length, dy / length, dz / length
    return (nx, ny, nz), length, length - rest, nx * (vx - ux) + ny * (vy - uy) + nz * (vz - uz) - paid


@generic
def tautness(switches, x, first):
    """Return the mode, 1 taut or 0 slack, of the link whose mode is number `first`."""
    return 1.0


@tautness.register(Switches)
def _(switches, x, first):
    return x[first]


@kernel
def pull(p, x, k):
    """Return (unit vector (3,), tension [N], power that the damper takes [W]) of link k, from 0."""
    _, _, d, modes = layout(p)
    n, _, stretch, rate = link(p, x, k)
    taut = tautness(p.switches, x, modes + d - 1 + k)
    damping = taut * p.cable.damping[k] * rate
    return n, taut * p.cable.stiffness[k] * stretch + damping, damping * rate


@kernel
def mass_of(p, x, k):
    """Return the mass [kg] of node k, from 1."""
    mass = p.cable.masses[k - 1]
    return mass if k < len(p.cable.masses) else payload_mass(p.switches, x, len(x) - 1, mass)


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
