"""An overhead crane in space: a trolley on a bridge and a chain of N rigid links, with a hoist or without.

State: one array [x, y, (l1), n_1 .. n_N, x', y', (l1'), u_1 .. u_N, (energy supplied), (modes)] with unit vectors n_k
down the links and their rates u_k. Equations see the state put back on |n_k| = 1, n_k u_k = 0, and so does each step.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.cables.chain_3d import (
    Directions,
    UpperEnd,
    align,
    direction_accelerations,
    hoisted_length_acceleration,
    node_velocities,
    solve_tensions,
)
from crane_sim.models.energy_meter import Meter
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.overhead import first_link, layout_of
from crane_sim.models.overhead.base_load import add_nodes_load, axes_load, to_world_in_place
from crane_sim.models.overhead.modes import EventLimits, get_mode, get_payload_mass
from crane_sim.models.overhead.node_forces import NodeForce, add_forces
from crane_sim.models.overhead.payload_wind import add_nodes_wind
from crane_sim.models.overhead.rigid_links import Solution, write_others
from crane_sim.models.supports.hoist import Hoist, hoist_response
from crane_sim.models.supports.rails import Axis, input_count
from crane_sim.models.wind_load import Windage
from crane_sim.multibody.vectors import dot
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.wind import Wind


class Work(NamedTuple):
    """Work arrays of one evaluation."""

    links: Directions
    free: Any  # (N + 1, 3) m/s², accelerations of the nodes without tensions
    tension: Any  # (N,) N
    ratio: Any  # (N,) of the elimination


class SpatialCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    bridge: Axis
    cable: Chain
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    forces: tuple[NodeForce, ...] | None = None
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None
    base: AnyBase | None = None
    wind: Wind | None = None
    windage: Windage | None = None  # of the payload
    share: float = 1.0  # of the mass that the bridge moves, at the trolley's position; the remainder is at x = 0

    rods = None

    def cable_coordinates(self):
        """Return the number of components of unit vectors."""
        return 3 * len(self.cable.masses)

    @routine
    def solve(self, t, x, tau, work):
        """Return accelerations and forces at time t in state x under joint efforts tau; those of links are in work."""
        nq, first, modes = layout_of(self)
        links, acc, tension, ratio = work
        self.fill_links(x, work)
        for k in range(1, len(acc)):
            acc[k, 0], acc[k, 1], acc[k, 2] = 0.0, 0.0, -self.gravity
        add_forces(self.forces, t, links.inv_masses, acc)
        inv_mass_x, bias_x = self.trolley.response(t, tau, 0, x[nq], get_mode(self.event_limits, x, modes, 0))
        inv_mass_y, bias_y = self.bridge.response(
            t, tau, input_count(self.trolley), x[nq + 1], get_mode(self.event_limits, x, modes, 1)
        )
        base = base_kinematics_at(self.base, self.gravity, t)
        load = axes_load(base, self, x)
        power = load.power + add_nodes_load(base, self, x, links, acc)
        power = power + add_nodes_wind(self, base, t, x, links, acc)
        acc[0, 0], acc[0, 1] = bias_x + inv_mass_x * load.x, bias_y + inv_mass_y * load.y
        hoist_inv_mass, hoist_bias_acc = hoist_response(self.hoist, t, tau, x, nq + first - 1)
        top = UpperEnd((inv_mass_x, inv_mass_y), hoist_inv_mass, hoist_bias_acc, first_link(self, x)[1])
        solve_tensions(links, top, acc, tension, ratio)
        x_pull, y_pull = tension[0] * links.units[0, 0], tension[0] * links.units[0, 1]
        axes = acc[0, 0] + inv_mass_x * x_pull, acc[0, 1] + inv_mass_y * y_pull
        paid = 0.0 if self.hoist is None else hoisted_length_acceleration(links, top, acc, tension)
        return Solution(axes, paid, (x_pull + load.x, y_pull + load.y), power, top)

    def tensions(self, work):
        """Return the tensions of all links [N] (N,)."""
        return work.tension

    def inv_masses(self, work):
        """Return the inverse masses of the nodes [1/kg] (N,)."""
        return work.links.inv_masses

    def fill_links(self, x, work):
        """Fill the links with those of state x, put back on what they hold."""
        nq, first, _ = layout_of(self)
        n, links = len(self.cable.masses), work.links
        for k in range(n):
            unit, rate = align(x, first + 3 * k, nq + first + 3 * k)
            links.units[k, 0], links.units[k, 1], links.units[k, 2] = unit
            links.rates[k, 0], links.rates[k, 1], links.rates[k, 2] = rate
            links.squared_rates[k] = dot(rate, rate)
        links.lengths[0] = first_link(self, x)[0]
        links.inv_masses[n - 1] = 1.0 / get_payload_mass(self.event_limits, x, len(x) - 1, self.cable.masses[n - 1])

    def node_velocities(self, x, work):
        """Return the velocities of nodes 0 to N relative to the base (N + 1, 3) [m/s]."""
        nq, _, _ = layout_of(self)
        return node_velocities(work.links, x[nq], x[nq + 1], first_link(self, x)[1])

    def write_nodes(self, x, r, v):
        """Write positions and velocities (N + 1, 3) of trolley and nodes relative to the base."""
        work = write_positions(self, x, r)
        v[:] = self.node_velocities(x, work)

    def payload_position(self, x):
        """Return the payload's position (3,) [m] relative to the base."""
        _, first, _ = layout_of(self)
        px, py, pz = x[0], x[1], 0.0
        for k in range(len(self.cable.masses)):
            length, i = self.cable.lengths[k] if k > 0 or first == 2 else x[2], first + 3 * k
            px, py, pz = px + length * x[i], py + length * x[i + 1], pz + length * x[i + 2]
        return px, py, pz


@system.project.register(SpatialCrane)
def project(p, x):
    """Return the state with unit vectors and their rates put back on what they hold."""
    straighten(p, x)
    return x


@system.project_in_place.register(SpatialCrane)
@routine
def straighten(p, x):
    """Give unit vectors their length 1, and take from their rates what is not across them."""
    nq, first, _ = layout_of(p)
    for i in range(first, nq, 3):
        (x[i], x[i + 1], x[i + 2]), (x[nq + i], x[nq + i + 1], x[nq + i + 2]) = align(x, i, nq + i)


@system.workspace.register(SpatialCrane)
@routine
def allocate_work(p):
    """Return work arrays with what does not change."""
    masses, lengths = p.cable.masses, p.cable.lengths
    n, free = len(masses), np.zeros((len(masses) + 1, 3))
    links = Directions(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), lengths.copy(), 1.0 / masses)
    return Work(links, free, np.empty(n), np.empty(n))


@system.rhs_into.register(SpatialCrane)
@routine
def write_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, _ = layout_of(p)
    tau = system.effort(u, p, t, x)
    links, acc, tension, _ = work
    solved = p.solve(t, x, tau, work)
    for i in range(first):
        out[i] = x[nq + i]
    for k in range(len(tension)):
        for c in range(3):
            out[first + 3 * k + c] = links.rates[k, c]
    direction_accelerations(links, solved.top, acc, tension, out, nq + first)
    write_others(p, t, x, tau, solved, work, out)


@system.potential.register(SpatialCrane)
@routine
def potential_energy(p, x):
    """Return the potential energy [J] of the nodes."""
    work = system.workspace(p)
    p.fill_links(x, work)
    links, z, potential = work.links, 0.0, 0.0
    for k in range(len(links.squared_rates)):
        z = z + links.lengths[k] * links.units[k, 2]
        potential += 1.0 / links.inv_masses[k] * p.gravity * z
    return potential


@system.points.register(SpatialCrane)
def write_points(p, t, x, out):
    """Write trolley and nodes."""
    write_positions(p, x, out)
    to_world_in_place(p.base, t, out)


@routine
def write_positions(p, x, out):
    """Write the nodes (N + 1, 3) into `out`; return the work arrays with the links' kinematics."""
    work = system.workspace(p)
    links = work.links
    p.fill_links(x, work)
    out[0, 0], out[0, 1], out[0, 2] = x[0], x[1], 0.0
    for k in range(len(links.squared_rates)):
        for c in range(3):
            out[k + 1, c] = out[k, c] + links.lengths[k] * links.units[k, c]
    return work
