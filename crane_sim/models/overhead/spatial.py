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
from crane_sim.models.energy_meter import Meter, meter_size
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.overhead import energies, layout_of, mode_of_stopped_axis, smallest_guard
from crane_sim.models.overhead.base_load import Moving, add_nodes_load, axes_load, to_world_in_place
from crane_sim.models.overhead.modes import (
    EventLimits,
    count_modes,
    count_payload_changes,
    get_mode,
    get_payload_mass,
    hoist_guard,
    limits_guard,
    make_switching,
    payload_guard,
    slack_guard,
    write_mode_rate,
)
from crane_sim.models.overhead.node_forces import NodeForces, add_forces, force_power
from crane_sim.models.overhead.payload_wind import add_nodes_wind
from crane_sim.models.supports.friction import first_not_none, step_control_of
from crane_sim.models.supports.hoist import (
    HOIST,
    Hoist,
    hoist_coordinates,
    hoist_friction_guard,
    hoist_modes,
    hoist_power,
    hoist_reflected_mass,
    hoist_response,
    hoist_sticks,
    mode_of_stopped_hoist,
)
from crane_sim.models.supports.rails import (
    Axis,
    add_bristle_power,
    axis_guard,
    axis_mass,
    axis_power,
    axis_response,
    has_friction,
    initial_mode,
    input_count,
    mode_after_stop,
)
from crane_sim.models.wind_kink import with_kink_switching
from crane_sim.models.wind_load import Windage
from crane_sim.numerics.jit import generic, routine
from crane_sim.trajectories.wind import Wind


class SpatialCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    bridge: Axis
    cable: Chain
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    forces: NodeForces | None = None
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None
    base: Moving | None = None
    wind: Wind | None = None
    windage: Windage | None = None  # of the payload
    share: float = 1.0  # of the mass that the bridge moves, at the trolley's position; the remainder is at x = 0


class Work(NamedTuple):
    """Work arrays of one evaluation."""

    links: Directions
    free: Any  # (N + 1, 3) m/s², accelerations of the nodes without tensions
    tension: Any  # (N,) N
    ratio: Any  # (N,) of the elimination


class SpatialSolution(NamedTuple):
    """Accelerations and forces at one instant, in addition to the work arrays."""

    top: UpperEnd
    pull: tuple[float, float]  # N, of the cable and of a moving base on trolley and bridge
    axes: tuple[float, float]  # m/s², of trolley and bridge
    outside_power: float  # W, that the moving base and the wind supply


@layout_of.register(SpatialCrane)
def _(p):
    first = 2 + hoist_coordinates(p.hoist)
    nq = first + 3 * len(p.cable.masses)
    return nq, first, 2 * nq + meter_size(p.energy_meter)


@generic
def hoisted_link(hoist, chain, x, nq):
    """Return (length, rate) of the first link."""
    return x[2], x[nq + 2]


@hoisted_link.register(type(None))
def _(hoist, chain, x, nq):
    return chain.lengths[0], 0.0


@system.project.register(SpatialCrane)
def _(p, x):
    straighten(p, x)
    return x


@system.project_in_place.register(SpatialCrane)
def _(p, x):
    straighten(p, x)


@routine
def straighten(p, x):
    """Give unit vectors their length 1, and take from their rates what is not across them."""
    nq, first, _ = layout_of(p)
    for i in range(first, nq, 3):
        (x[i], x[i + 1], x[i + 2]), (x[nq + i], x[nq + i + 1], x[nq + i + 2]) = align(x, i, nq + i)


@system.workspace.register(SpatialCrane)
def _(p):
    return work_arrays(p.cable.masses, p.cable.lengths)


@routine
def work_arrays(masses, lengths):
    """Return work arrays with what does not change."""
    n, free = len(masses), np.zeros((len(masses) + 1, 3))
    links = Directions(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), lengths.copy(), 1.0 / masses)
    return Work(links, free, np.empty(n), np.empty(n))


def fill_links(p, x, links):
    """Fill the links with those of state x, put back on what they hold."""
    nq, first, _ = layout_of(p)
    n = len(p.cable.masses)
    for k in range(n):
        unit, rate = align(x, first + 3 * k, nq + first + 3 * k)
        links.units[k, 0], links.units[k, 1], links.units[k, 2] = unit
        links.rates[k, 0], links.rates[k, 1], links.rates[k, 2] = rate
        links.squared_rates[k] = rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2]
    links.lengths[0] = hoisted_link(p.hoist, p.cable, x, nq)[0]
    links.inv_masses[n - 1] = 1.0 / get_payload_mass(p.event_limits, x, len(x) - 1, p.cable.masses[n - 1])


@routine
def forward_dynamics(p, t, x, tau, work):
    """Return accelerations and forces at time t in state x under joint efforts tau; those of links are in work."""
    nq, first, modes = layout_of(p)
    links, acc, tension, ratio = work
    fill_links(p, x, links)
    rate, position, velocity = hoisted_link(p.hoist, p.cable, x, nq)[1], (x[0], x[1]), (x[nq], x[nq + 1])
    for k in range(1, len(acc)):
        acc[k, 0], acc[k, 1], acc[k, 2] = 0.0, 0.0, -p.gravity
    add_forces(p.forces, t, links.inv_masses, acc)
    inv_mass_x, bias_x = axis_response(p.trolley, t, tau, 0, x[nq], get_mode(p.event_limits, x, modes, 0))
    inv_mass_y, bias_y = axis_response(
        p.bridge, t, tau, input_count(p.trolley), x[nq + 1], get_mode(p.event_limits, x, modes, 1)
    )
    base = base_kinematics_at(p.base, p.gravity, t)
    load = axes_load(base, p.trolley, p.bridge, p.share, position, velocity)
    power = load.power + add_nodes_load(base, links, position, velocity, rate, acc)
    power = power + add_nodes_wind(p.wind, p, base, t, links, (position, velocity, rate), acc)
    acc[0, 0], acc[0, 1] = bias_x + inv_mass_x * load.x, bias_y + inv_mass_y * load.y
    hoist_inv_mass, hoist_bias_acc = hoist_response(p.hoist, t, tau, x, nq + first - 1)
    top = UpperEnd((inv_mass_x, inv_mass_y), hoist_inv_mass, hoist_bias_acc, rate)
    solve_tensions(links, top, acc, tension, ratio)
    x_pull, y_pull = tension[0] * links.units[0, 0], tension[0] * links.units[0, 1]
    axes = acc[0, 0] + inv_mass_x * x_pull, acc[0, 1] + inv_mass_y * y_pull
    return SpatialSolution(top, (x_pull + load.x, y_pull + load.y), axes, power)


@system.rhs_into.register(SpatialCrane)
def _(p, t, x, u, out, work):
    write_derivative(p, t, x, u, out, work)


@routine
def write_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, modes = layout_of(p)
    tau = system.effort(u, p, t, x)
    links, acc, tension, _ = work
    solved = forward_dynamics(p, t, x, tau, work)
    for axis in range(2):
        out[axis], out[nq + axis] = x[nq + axis], solved.axes[axis]
    if first == 3:
        out[2], out[nq + 2] = x[nq + 2], hoisted_length_acceleration(links, solved.top, acc, tension)
    for k in range(len(tension)):
        for c in range(3):
            out[first + 3 * k + c] = links.rates[k, c]
    direction_accelerations(links, solved.top, acc, tension, out, nq + first)
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if modes > 2 * nq:
        out[2 * nq] = chain_power(p, t, x, tau, solved, work)
    write_mode_rate(p.event_limits, p.trolley, x[nq], x, modes, out)
    write_mode_rate(p.event_limits, p.bridge, x[nq + 1], x, modes + 1, out)


def chain_power(p, t, x, tau, solved, work):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    nq, _, modes = layout_of(p)
    rate = hoisted_link(p.hoist, p.cable, x, nq)[1]
    power = axis_power(p.trolley, tau, 0, x[nq], solved.pull[0])
    power += axis_power(p.bridge, tau, input_count(p.trolley), x[nq + 1], solved.pull[1])
    power += hoist_power(p.hoist, tau, rate, work.tension[0])
    power = add_bristle_power(p.trolley, power, x[nq], get_mode(p.event_limits, x, modes, 0))
    power = add_bristle_power(p.bridge, power, x[nq + 1], get_mode(p.event_limits, x, modes, 1))
    return power + solved.outside_power + node_forces_power(p.forces, p, t, x, work.links, rate)


@generic
def node_forces_power(forces, p, t, x, links, rate):
    """Return the power [W] of forces on nodes."""
    nq, _, _ = layout_of(p)
    return force_power(forces, t, node_velocities(links, x[nq], x[nq + 1], rate))


@node_forces_power.register(type(None))
def _(forces, p, t, x, links, rate):
    return 0.0


@system.state.register(SpatialCrane)
def _(p, t, q, v):
    nq, _, modes = layout_of(p)
    x = np.zeros(modes + count_modes(p.event_limits, 2 + hoist_modes(p.hoist)))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    if len(x) > modes:
        x[modes], x[modes + 1] = initial_mode(p.trolley, v[0]), initial_mode(p.bridge, v[1])
        x[len(x) - 1] = count_payload_changes(p.event_limits, t)
        if hoist_modes(p.hoist):
            x[len(x) - 2] = np.sign(v[2])
    return x


@energies.register(SpatialCrane)
def _(p, x):
    nq, _, _ = layout_of(p)
    links, rate = system.workspace(p).links, hoisted_link(p.hoist, p.cable, x, nq)[1]
    fill_links(p, x, links)
    v, z, potential = node_velocities(links, x[nq], x[nq + 1], rate), 0.0, 0.0
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2 + 0.5 * axis_mass(p.bridge) * x[nq + 1] ** 2
    kinetic += 0.5 * hoist_reflected_mass(p.hoist) * rate * rate
    for k in range(len(links.squared_rates)):
        mass = 1.0 / links.inv_masses[k]
        z = z + links.lengths[k] * links.units[k, 2]
        kinetic += 0.5 * mass * (v[k + 1, 0] ** 2 + v[k + 1, 1] ** 2 + v[k + 1, 2] ** 2)
        potential += mass * p.gravity * z
    return kinetic, potential


@system.tensions.register(SpatialCrane)
def _(p, t, x, u, rows, i, first):
    work = system.workspace(p)
    forward_dynamics(p, t, x, system.effort(u, p, t, x), work)
    for k in range(len(work.tension)):
        rows[i, first + k] = work.tension[k]


@system.power.register(SpatialCrane)
def _(p, t, x, u):
    tau, work = system.effort(u, p, t, x), system.workspace(p)
    return chain_power(p, t, x, tau, forward_dynamics(p, t, x, tau, work), work)


@system.points.register(SpatialCrane)
def _(p, t, x, out):
    write_positions(p, x, out)
    to_world_in_place(p.base, t, out)


@routine
def write_positions(p, x, out):
    """Write the nodes (N + 1, 3) into `out`."""
    links = system.workspace(p).links
    fill_links(p, x, links)
    out[0, 0], out[0, 1], out[0, 2] = x[0], x[1], 0.0
    for k in range(len(links.squared_rates)):
        for c in range(3):
            out[k + 1, c] = out[k, c] + links.lengths[k] * links.units[k, c]


@system.switching.register(SpatialCrane)
def _(p):
    rubs = has_friction(p.trolley) or has_friction(p.bridge) or has_friction(p.hoist)
    step_control = first_not_none(
        first_not_none(step_control_of(p.trolley), step_control_of(p.bridge)), step_control_of(p.hoist)
    )
    return with_kink_switching(p.wind, make_switching(p.event_limits, rubs, layout_of(p)[0], step_control))


@smallest_guard.register(SpatialCrane)
def _(p, t, x, tau, work):
    nq, first, modes = layout_of(p)
    sticks = (has_friction(p.trolley) and x[modes] == 0.0) or (has_friction(p.bridge) and x[modes + 1] == 0.0)
    forces = sticks or hoist_sticks(p.hoist, x) or p.event_limits.taut > 0.0
    pull = forward_dynamics(p, t, x, tau, work).pull if forces else (0.0, 0.0)
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, pull[0]), encode(Guard.FRICTION, 0))
    bridge = axis_guard(p.bridge, x[nq + 1], x[modes + 1], tau, input_count(p.trolley), pull[1])
    best = limits_guard(p.event_limits, smaller_guard(best, bridge, encode(Guard.FRICTION, 1)), 0, x[0])
    best = limits_guard(p.event_limits, best, 1, x[1])
    best = hoist_guard(p.event_limits, best, hoisted_link(p.hoist, p.cable, x, nq)[0])
    best = hoist_friction_guard(p.hoist, best, x, nq + first - 1, tau, work.tension[0])
    best = payload_guard(p.event_limits, best, t, x[len(x) - 1])
    value, number = slack_guard(p.event_limits, best, work.tension, len(work.tension))
    return value, number, int(forces)


@mode_of_stopped_axis.register(SpatialCrane)
def _(p, t, x, tau, axis, mode):
    work = system.workspace(p)
    pull = forward_dynamics(p, t, x, tau, work).pull
    if axis == HOIST:
        return mode_of_stopped_hoist(p.hoist, mode, tau, work.tension[0])
    if axis == 0:  # not one call with either axis: they may be of different types, and the type chooses the body
        return mode_after_stop(p.trolley, mode, tau, 0, pull[0])
    return mode_after_stop(p.bridge, mode, tau, input_count(p.trolley), pull[1])
