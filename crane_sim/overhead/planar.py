"""An overhead crane in the vertical plane: a trolley and a chain of N rigid links, with a hoist or without.

State: one array [x, (l1), α_1 .. α_N, x', (l1'), α_1' .. α_N', (energy supplied), (modes)].
"""

from typing import NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.angles import sincos
from crane_sim.base import carried
from crane_sim.jit import generic, lean_generic, lean_kernel, lean_routine, routine
from crane_sim.meter import Meter, meter_size
from crane_sim.overhead.audit import metered
from crane_sim.overhead.axes import Axis, axis_power, rail
from crane_sim.overhead.carried import Moving, push_links
from crane_sim.overhead.chain import (
    BELOW,
    COS,
    LENGTH,
    RATE,
    SIN,
    TENSION,
    TURNING,
    Chain,
    Rods,
    hang,
    nudge,
    rod_pull,
    slid,
    solve_links,
    work_array,
)
from crane_sim.overhead.forces import NodeForces, force_power
from crane_sim.overhead.hoists import Hoist, drum, drum_power, hoisted
from crane_sim.overhead.joints import Joints, add_joints, joint_power
from crane_sim.overhead.switches import Switches, mode_of, payload_mass, story
from crane_sim.sources import value_at


class PlanarCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    cable: Chain
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    joints: Joints | None = None
    rods: Rods | None = None
    forces: NodeForces | None = None
    switches: Switches | None = None
    meter: Meter | None = None
    base: Moving | None = None

    def metered(self, held: bool) -> "PlanarCrane":
        """Return the model with a meter where held efforts do not tell all the energy supplied."""
        return metered(self, held)

    def story(self, which: int) -> tuple[str, str]:
        """Return (what guard number `which` tells, what a user can change) in words."""
        return story(self.switches, which)


class Solved(NamedTuple):
    """What state and efforts fix at one instant, beside what is in the work array."""

    trolley: float  # m/s²
    paid: float  # m/s², of the first link's length
    pull: float  # N, of the cable and of a moving base on the trolley along x
    given: float  # W, that the moving base supplies


@lean_kernel
def layout(p):
    """Return (number of coordinates, index of the first angle, index of the first mode)."""
    first = 1 + hoisted(p.hoist)
    nq = first + len(p.cable.masses)
    return nq, first, 2 * nq + meter_size(p.meter)


@lean_generic
def first_link(hoist, chain, x, nq):
    """Return (length, rate) of the first link."""
    return x[1], x[nq + 1]


@first_link.register(type(None))
def _(hoist, chain, x, nq):
    return chain.lengths[0], 0.0


@system.workspace.register(PlanarCrane)
def _(p):
    return work_array(p.cable.masses, p.cable.lengths)


@lean_kernel
def links_of(p, x, w):
    """Fill the work array with what the state tells of the links."""
    nq, first, _ = layout(p)
    n = len(p.cable.masses)
    for k in range(n):
        w[SIN, k], w[COS, k] = sincos(x[first + k])
    for k in range(n):
        w[RATE, k] = x[nq + first + k]
    w[LENGTH, 0] = first_link(p.hoist, p.cable, x, nq)[0]
    w[BELOW, n - 1] = 1.0 / payload_mass(p.switches, x, len(x) - 1, p.cable.masses[n - 1])


@lean_generic
def push_nodes(forces, t, w):
    """Add what forces on nodes ask of the links."""


@push_nodes.register(NodeForces)
def _(forces, t, w):
    push = value_at(forces.channel, t) * w[BELOW, forces.node - 1]
    nudge(w, forces.node, push if forces.axis == 0 else 0.0, push if forces.axis == 2 else 0.0)
    push_nodes(forces.rest, t, w)


@lean_routine
def solved(p, t, x, tau, w):
    """Return what state x at time t and joint efforts tau fix; the links' part of it is left in the work array w."""
    nq, first, modes = layout(p)
    links_of(p, x, w)
    give, push = rail(p.trolley, t, tau, 0, x[nq], mode_of(p.switches, x, modes, 0))
    pay, run = drum(p.hoist, t, tau)
    hang(w, push, p.gravity)
    rate = first_link(p.hoist, p.cable, x, nq)[1]
    field = push_links(carried(p.base, p.gravity, t), p.trolley, p.rods, w, x[0], x[nq], rate)
    twist = add_joints(p.joints, w, x, first) + field.x
    w[TENSION, 0] -= w[SIN, 0] * give * twist
    w[TURNING, 0] -= w[COS, 0] * give * twist
    push_nodes(p.forces, t, w)
    free = w[TENSION, 0]
    solve_links(p.rods, w, (give, pay, run, rate))
    pull = w[TENSION, 0] * w[SIN, 0] + rod_pull(p.rods, w) + twist
    paid = run + pay * w[TENSION, 0] if pay >= 0.0 else slid(w, give, free)
    return Solved(push + give * pull, paid, pull, field.power)


@system.fill.register(PlanarCrane)
def _(p, t, x, u, out, work):
    derive(p, t, x, u, out, work)


@lean_routine
def derive(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, modes = layout(p)
    tau = system.effort(u, p, t, x)
    now = solved(p, t, x, tau, work)
    for i in range(nq):
        out[i] = x[nq + i]
    out[nq] = now.trolley
    if first == 2:
        out[nq + 1] = now.paid
    for k in range(nq - first):
        out[nq + first + k] = work[TURNING, k]
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if modes > 2 * nq:
        out[2 * nq] = supply(p, t, x, tau, now, work)


@lean_kernel
def supply(p, t, x, tau, now, w):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    nq, first, _ = layout(p)
    rate = first_link(p.hoist, p.cable, x, nq)[1]
    power = axis_power(p.trolley, tau, 0, x[nq], now.pull) + drum_power(p.hoist, tau, rate, w[TENSION, 0])
    power += joint_power(p.joints, x[nq + first : 2 * nq]) + now.given
    return power + forces_supply(p.forces, p, t, x, w, rate)


@generic
def forces_supply(forces, p, t, x, w, rate):
    """Return the power [W] of forces on nodes."""
    return force_power(forces, t, node_velocities(p, x, w, rate))


@forces_supply.register(type(None))
def _(forces, p, t, x, w, rate):
    return 0.0


@routine
def node_velocities(p, x, w, rate):
    """Return the velocities of nodes 0 to N in the world (N + 1, 3) [m/s]; the first link lengthens at `rate`."""
    nq, n = layout(p)[0], w.shape[1] - 1
    v = np.zeros((n + 1, 3))
    v[0, 0] = x[nq]
    for k in range(n):
        s, c, swing = w[SIN, k], w[COS, k], w[LENGTH, k] * w[RATE, k]
        paid = rate if k == 0 else 0.0
        v[k + 1, 0] = v[k, 0] + paid * s + swing * c
        v[k + 1, 2] = v[k, 2] - paid * c + swing * s
    return v
