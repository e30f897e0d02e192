"""An overhead crane in the vertical plane: a trolley and a chain of N rigid links, with a hoist or without.

State: one array [x, (l1), α_1 .. α_N, x', (l1'), α_1' .. α_N', (energy supplied), (modes)].
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import (
    COS,
    INV_MASS,
    LENGTH,
    RATE,
    RHS_ACROSS,
    RHS_ALONG,
    SIN,
    TENSION,
    TURNING,
    Chain,
    Joints,
    Rods,
    add_joints,
    add_node_acceleration,
    assemble_rhs,
    fill_sines,
    joint_energy,
    joint_power,
    massless_hoist_acceleration,
    rod_energy,
    rod_pull,
    solve_links,
    work_array,
)
from crane_sim.models.energy_meter import Meter, meter_size
from crane_sim.models.guards import Guard, encode
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.overhead import energies, layout_of, mode_of_stopped_axis, smallest_guard
from crane_sim.models.overhead.base_load import Moving, add_links_load, to_world_in_place
from crane_sim.models.overhead.modes import (
    EventLimits,
    count_modes,
    count_payload_changes,
    get_mode,
    get_payload_mass,
    hoist_guard,
    limits_guard,
    payload_guard,
    slack_guard,
    write_mode_rate,
)
from crane_sim.models.overhead.node_forces import NodeForces, force_power
from crane_sim.models.overhead.payload_wind import add_links_wind
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
    mode_after_stop,
)
from crane_sim.models.wind_load import Windage
from crane_sim.numerics.jit import generic, routine, simd_range, use_wide_vectors
from crane_sim.trajectories.inputs import value_at
from crane_sim.trajectories.wind import Wind


class PlanarCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    cable: Chain
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    joints: Joints | None = None
    rods: Rods | None = None
    forces: NodeForces | None = None
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None
    base: Moving | None = None
    wind: Wind | None = None
    windage: Windage | None = None  # of the payload


class PlanarSolution(NamedTuple):
    """Accelerations and forces at one instant, in addition to the work array."""

    trolley: float  # m/s²
    paid: float  # m/s², of the first link's length
    pull: float  # N, of the cable and of a moving base on the trolley along x
    outside_power: float  # W, that the moving base and the wind supply


@layout_of.register(PlanarCrane)
def _(p):
    first = 1 + hoist_coordinates(p.hoist)
    nq = first + len(p.cable.masses)
    return nq, first, 2 * nq + meter_size(p.energy_meter)


@generic
def hoisted_link(hoist, chain, x, nq):
    """Return (length, rate) of the first link."""
    return x[1], x[nq + 1]


@hoisted_link.register(type(None))
def _(hoist, chain, x, nq):
    return chain.lengths[0], 0.0


@system.workspace.register(PlanarCrane)
def _(p):
    return work_array(p.cable.masses, p.cable.lengths)


def fill_links(p, x, w):
    """Fill the work array with the links' kinematics."""
    nq, first, _ = layout_of(p)
    n = len(p.cable.masses)
    fill_sines(n, (w[SIN], w[COS]), (x[first:],))
    for k in simd_range(n):
        w[RATE, k] = x[nq + first + k]
    w[LENGTH, 0] = hoisted_link(p.hoist, p.cable, x, nq)[0]
    w[INV_MASS, n - 1] = 1.0 / get_payload_mass(p.event_limits, x, len(x) - 1, p.cable.masses[n - 1])


@generic
def add_node_forces(forces, t, w):
    """Add the accelerations by forces on nodes to the links' right-hand sides."""


@add_node_forces.register(NodeForces)
def _(forces, t, w):
    acc = value_at(forces.channel, t) * w[INV_MASS, forces.node - 1]
    add_node_acceleration(w, forces.node, acc if forces.axis == 0 else 0.0, acc if forces.axis == 2 else 0.0)
    add_node_forces(forces.tail, t, w)


@routine
def forward_dynamics(p, t, x, tau, w):
    """Return accelerations and forces at time t in state x under joint efforts tau; those of links are in w."""
    use_wide_vectors()
    nq, first, modes = layout_of(p)
    fill_links(p, x, w)
    inv_mass, bias_acc = axis_response(p.trolley, t, tau, 0, x[nq], get_mode(p.event_limits, x, modes, 0))
    hoist_inv_mass, hoist_bias_acc = hoist_response(p.hoist, t, tau, x, nq + first - 1)
    assemble_rhs(w, bias_acc, p.gravity)
    rate = hoisted_link(p.hoist, p.cable, x, nq)[1]
    base = base_kinematics_at(p.base, p.gravity, t)
    field = add_links_load(base, p.trolley, p.rods, w, x[0], x[nq], rate)
    twist = add_joints(p.joints, w, x, first) + field.x
    w[RHS_ALONG, 0] -= w[SIN, 0] * inv_mass * twist
    w[RHS_ACROSS, 0] -= w[COS, 0] * inv_mass * twist
    add_node_forces(p.forces, t, w)
    wind_power = add_links_wind(p.wind, p, base, t, w, (x[0], x[nq], rate))
    rhs_along = w[RHS_ALONG, 0]
    solve_links(p.rods, w, (inv_mass, hoist_inv_mass, hoist_bias_acc, rate))
    pull = w[TENSION, 0] * w[SIN, 0] + rod_pull(p.rods, w) + twist
    if hoist_inv_mass >= 0.0:
        paid = hoist_bias_acc + hoist_inv_mass * w[TENSION, 0]
    else:
        paid = massless_hoist_acceleration(w, inv_mass, rhs_along)
    return PlanarSolution(bias_acc + inv_mass * pull, paid, pull, field.power + wind_power)


@system.rhs_into.register(PlanarCrane)
def _(p, t, x, u, out, work):
    write_derivative(p, t, x, u, out, work)


@routine
def write_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, modes = layout_of(p)
    tau = system.effort(u, p, t, x)
    solved = forward_dynamics(p, t, x, tau, work)
    for i in simd_range(nq):
        out[i] = x[nq + i]
    out[nq] = solved.trolley
    if first == 2:
        out[nq + 1] = solved.paid
    for k in simd_range(nq - first):
        out[nq + first + k] = work[TURNING, k]
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if modes > 2 * nq:
        out[2 * nq] = chain_power(p, t, x, tau, solved, work)
    write_mode_rate(p.event_limits, p.trolley, x[nq], x, modes, out)


def chain_power(p, t, x, tau, solved, w):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    nq, first, modes = layout_of(p)
    rate = hoisted_link(p.hoist, p.cable, x, nq)[1]
    power = axis_power(p.trolley, tau, 0, x[nq], solved.pull) + hoist_power(p.hoist, tau, rate, w[TENSION, 0])
    power = add_bristle_power(p.trolley, power, x[nq], get_mode(p.event_limits, x, modes, 0))
    power += joint_power(p.joints, x[nq + first : 2 * nq]) + solved.outside_power
    return power + node_forces_power(p.forces, p, t, x, w, rate)


@generic
def node_forces_power(forces, p, t, x, w, rate):
    """Return the power [W] of forces on nodes."""
    return force_power(forces, t, node_velocities(p, x, w, rate))


@node_forces_power.register(type(None))
def _(forces, p, t, x, w, rate):
    return 0.0


@routine
def node_velocities(p, x, w, rate):
    """Return the velocities of nodes 0 to N in the world (N + 1, 3) [m/s]; the first link lengthens at `rate`."""
    nq, n = layout_of(p)[0], w.shape[1] - 1
    v = np.zeros((n + 1, 3))
    v[0, 0] = x[nq]
    for k in range(n):
        s, c, swing = w[SIN, k], w[COS, k], w[LENGTH, k] * w[RATE, k]
        paid = rate if k == 0 else 0.0
        v[k + 1, 0] = v[k, 0] + paid * s + swing * c
        v[k + 1, 2] = v[k, 2] - paid * c + swing * s
    return v


@system.state.register(PlanarCrane)
def _(p, t, q, v):
    nq, _, modes = layout_of(p)
    x = np.zeros(modes + count_modes(p.event_limits, 1 + hoist_modes(p.hoist)))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    if len(x) > modes:
        x[modes], x[len(x) - 1] = initial_mode(p.trolley, v[0]), count_payload_changes(p.event_limits, t)
        if hoist_modes(p.hoist):
            x[len(x) - 2] = np.sign(v[1])
    return x


@energies.register(PlanarCrane)
def _(p, x):
    nq, first, _ = layout_of(p)
    n, w, rate = len(p.cable.masses), system.workspace(p), hoisted_link(p.hoist, p.cable, x, nq)[1]
    fill_links(p, x, w)
    v, z, potential = node_velocities(p, x, w, rate), 0.0, joint_energy(p.joints, x[first:nq])
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2 + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate
    kinetic += rod_energy(p.rods, x[nq + first : 2 * nq])
    for k in range(n):
        mass = 1.0 / w[INV_MASS, k]
        z = z - w[LENGTH, k] * w[COS, k]
        kinetic += 0.5 * mass * (v[k + 1, 0] ** 2 + v[k + 1, 2] ** 2)
        potential += mass * p.gravity * z
    return kinetic, potential


@system.tensions.register(PlanarCrane)
def _(p, t, x, u, rows, i, first):
    w = system.workspace(p)
    forward_dynamics(p, t, x, system.effort(u, p, t, x), w)
    for k in range(w.shape[1] - 1):
        rows[i, first + k] = w[TENSION, k]


@system.power.register(PlanarCrane)
def _(p, t, x, u):
    tau, w = system.effort(u, p, t, x), system.workspace(p)
    return chain_power(p, t, x, tau, forward_dynamics(p, t, x, tau, w), w)


@system.points.register(PlanarCrane)
def _(p, t, x, out):
    nq, first, _ = layout_of(p)
    length, _ = hoisted_link(p.hoist, p.cable, x, nq)
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for k in range(len(p.cable.masses)):
        link = length if k == 0 else p.cable.lengths[k]
        out[k + 1, 0] = out[k, 0] + link * sin(x[first + k])
        out[k + 1, 1] = 0.0
        out[k + 1, 2] = out[k, 2] - link * cos(x[first + k])
    to_world_in_place(p.base, t, out)


@smallest_guard.register(PlanarCrane)
def _(p, t, x, tau, w):
    nq, first, modes = layout_of(p)
    sticks = (has_friction(p.trolley) and x[modes] == 0.0) or hoist_sticks(p.hoist, x)
    forces = p.event_limits.taut > 0.0 or sticks
    pull = forward_dynamics(p, t, x, tau, w).pull if forces else 0.0
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, pull), encode(Guard.FRICTION, 0))
    best = limits_guard(p.event_limits, best, 0, x[0])
    best = hoist_guard(p.event_limits, best, hoisted_link(p.hoist, p.cable, x, nq)[0])
    best = hoist_friction_guard(p.hoist, best, x, nq + first - 1, tau, w[TENSION, 0])
    best = payload_guard(p.event_limits, best, t, x[len(x) - 1])
    value, number = slack_guard(p.event_limits, best, w[TENSION], len(p.cable.masses))
    return value, number, int(forces)


@mode_of_stopped_axis.register(PlanarCrane)
def _(p, t, x, tau, axis, mode):
    w = system.workspace(p)
    pull = forward_dynamics(p, t, x, tau, w).pull
    if axis == HOIST:
        return mode_of_stopped_hoist(p.hoist, mode, tau, w[TENSION, 0])
    return mode_after_stop(p.trolley, mode, tau, 0, pull)
