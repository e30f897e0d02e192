"""An overhead crane in space: a trolley on a bridge and a chain of N rigid links, with a hoist or without.

State: one array [x, y, (l1), n_1 .. n_N, x', y', (l1'), u_1 .. u_N, (energy supplied), (modes)] with unit vectors n_k
down the links and their rates u_k. Equations see the state put back on |n_k| = 1, n_k u_k = 0, and so does each step.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.base import carried
from crane_sim.jit import generic, lean_generic, lean_kernel, lean_routine, routine
from crane_sim.meter import Meter, meter_size
from crane_sim.overhead.audit import metered
from crane_sim.overhead.axes import Axis, axis_power, demands, rail
from crane_sim.overhead.carried import Moving, push_axes, push_directions
from crane_sim.overhead.chain import Chain
from crane_sim.overhead.directions import Directions, Top, aligned, node_velocities, paid_out, solve_tensions, turn
from crane_sim.overhead.forces import NodeForces, add_forces, force_power
from crane_sim.overhead.hoists import Hoist, drum, drum_power, hoisted
from crane_sim.overhead.switches import Switches, mode_of, payload_mass, story


class SpatialCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    bridge: Axis
    cable: Chain
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    forces: NodeForces | None = None
    switches: Switches | None = None
    meter: Meter | None = None
    base: Moving | None = None
    share: float = 1.0  # of the mass that the bridge moves, at the trolley's place; the rest is where x = 0

    def metered(self, held: bool) -> "SpatialCrane":
        """Return the model with a meter where held efforts do not tell all the energy supplied."""
        return metered(self, held)

    def story(self, which: int) -> tuple[str, str]:
        """Return (what guard number `which` tells, what a user can change) in words."""
        return story(self.switches, which)


class Work(NamedTuple):
    """Where one evaluation keeps what it computes."""

    links: Directions
    free: Any  # (N + 1, 3) m/s², accelerations of the nodes without tensions
    tension: Any  # (N,) N
    ratio: Any  # (N,) of the elimination


class Solved(NamedTuple):
    """What state and efforts fix at one instant, beside what is in the work arrays."""

    top: Top
    pull: tuple[float, float]  # N, of the cable and of a moving base on trolley and bridge
    axes: tuple[float, float]  # m/s², of trolley and bridge
    given: float  # W, that the moving base supplies


@lean_kernel
def layout(p):
    """Return (number of coordinates, index of the first unit vector, index of the first mode)."""
    first = 2 + hoisted(p.hoist)
    nq = first + 3 * len(p.cable.masses)
    return nq, first, 2 * nq + meter_size(p.meter)


@lean_generic
def first_link(hoist, chain, x, nq):
    """Return (length, rate) of the first link."""
    return x[2], x[nq + 2]


@first_link.register(type(None))
def _(hoist, chain, x, nq):
    return chain.lengths[0], 0.0


@system.project.register(SpatialCrane)
def _(p, x):
    straighten(p, x)
    return x


@lean_routine
def straighten(p, x):
    """Give unit vectors their length 1, and take from their rates what is not across them."""
    nq, first, _ = layout(p)
    for i in range(first, nq, 3):
        (x[i], x[i + 1], x[i + 2]), (x[nq + i], x[nq + i + 1], x[nq + i + 2]) = aligned(x, i, nq + i)


@system.workspace.register(SpatialCrane)
def _(p):
    return work_arrays(p.cable.masses, p.cable.lengths)


@routine
def work_arrays(masses, lengths):
    """Return work arrays with what does not change."""
    n, free = len(masses), np.zeros((len(masses) + 1, 3))
    links = Directions(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), lengths.copy(), 1.0 / masses)
    return Work(links, free, np.empty(n), np.empty(n))


@lean_kernel
def links_of(p, x, links):
    """Fill the links with those of state x, put back on what they hold."""
    nq, first, _ = layout(p)
    n = len(p.cable.masses)
    for k in range(n):
        unit, rate = aligned(x, first + 3 * k, nq + first + 3 * k)
        links.units[k, 0], links.units[k, 1], links.units[k, 2] = unit
        links.rates[k, 0], links.rates[k, 1], links.rates[k, 2] = rate
        links.speeds[k] = rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2]
    links.lengths[0] = first_link(p.hoist, p.cable, x, nq)[0]
    links.below[n - 1] = 1.0 / payload_mass(p.switches, x, len(x) - 1, p.cable.masses[n - 1])


@lean_routine
def solved(p, t, x, tau, work):
    """Return what state x at time t and joint efforts tau fix; the links' part of it is left in the workspace."""
    nq, _, modes = layout(p)
    links, acc, tension, ratio = work
    links_of(p, x, links)
    rate, place, speed = first_link(p.hoist, p.cable, x, nq)[1], (x[0], x[1]), (x[nq], x[nq + 1])
    for k in range(1, len(acc)):
        acc[k, 0], acc[k, 1], acc[k, 2] = 0.0, 0.0, -p.gravity
    add_forces(p.forces, t, links.below, acc)
    give_x, push_x = rail(p.trolley, t, tau, 0, x[nq], mode_of(p.switches, x, modes, 0))
    give_y, push_y = rail(p.bridge, t, tau, demands(p.trolley), x[nq + 1], mode_of(p.switches, x, modes, 1))
    now = carried(p.base, p.gravity, t)
    deck = push_axes(now, p.trolley, p.bridge, p.share, place, speed)
    power = push_directions(now, links, place, speed, rate, acc)
    acc[0, 0], acc[0, 1] = push_x + give_x * deck.x, push_y + give_y * deck.y
    pay, run = drum(p.hoist, t, tau)
    top = Top((give_x, give_y), pay, run, rate)
    solve_tensions(links, top, acc, tension, ratio)
    x_pull, y_pull = tension[0] * links.units[0, 0], tension[0] * links.units[0, 1]
    axes = acc[0, 0] + give_x * x_pull, acc[0, 1] + give_y * y_pull
    return Solved(top, (x_pull + deck.x, y_pull + deck.y), axes, deck.power + power)


@system.fill.register(SpatialCrane)
def _(p, t, x, u, out, work):
    derive(p, t, x, u, out, work)


@lean_routine
def derive(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, modes = layout(p)
    tau = system.effort(u, p, t, x)
    links, acc, tension, _ = work
    now = solved(p, t, x, tau, work)
    for axis in range(2):
        out[axis], out[nq + axis] = x[nq + axis], now.axes[axis]
    if first == 3:
        out[2], out[nq + 2] = x[nq + 2], paid_out(links, now.top, acc, tension)
    for k in range(len(tension)):
        for c in range(3):
            out[first + 3 * k + c] = links.rates[k, c]
    turn(links, now.top, acc, tension, out, nq + first)
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if modes > 2 * nq:
        out[2 * nq] = supply(p, t, x, tau, now, work)


@lean_kernel
def supply(p, t, x, tau, now, work):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    nq, _, _ = layout(p)
    rate = first_link(p.hoist, p.cable, x, nq)[1]
    power = axis_power(p.trolley, tau, 0, x[nq], now.pull[0])
    power += axis_power(p.bridge, tau, demands(p.trolley), x[nq + 1], now.pull[1])
    power += drum_power(p.hoist, tau, rate, work.tension[0])
    return power + now.given + forces_supply(p.forces, p, t, x, work.links, rate)


@generic
def forces_supply(forces, p, t, x, links, rate):
    """Return the power [W] of forces on nodes."""
    nq, _, _ = layout(p)
    return force_power(forces, t, node_velocities(links, x[nq], x[nq + 1], rate))


@forces_supply.register(type(None))
def _(forces, p, t, x, links, rate):
    return 0.0
