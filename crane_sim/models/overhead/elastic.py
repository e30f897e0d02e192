"""An overhead crane whose cable is a chain of springs and dampers, in the vertical plane or in space.

State: one array [x, (y), (l1), r_1 .. r_N, x', (y'), (l1'), r_1' .. r_N', (energy supplied), (modes)] with the nodes'
positions r_k on the base: (x, z) each in the plane, (x, y, z) in space. Link k pulls with T = k e + c e', e its length
beyond the rest length, l1 of the first link where there is a hoist. Modes: friction of the axes, 1 or 0 for each link
that is taut or slack, changes of the payload.

The nodes' accelerations, those of axes and hoist, and what a moving base adds to them.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.models.effects import NodeForce
from crane_sim.models.energy_meter import Meter
from crane_sim.models.moving_base import base_kinematics_at, imposed_acceleration
from crane_sim.models.overhead import count_axes, first_link, layout_of, trolley_motion
from crane_sim.models.overhead.base_load import NO_LOAD, axes_load
from crane_sim.models.overhead.modes import EventLimits, get_mode, mass_of
from crane_sim.models.overhead.payload_wind import payload_force
from crane_sim.models.supports.hoist import Hoist, hoist_mode, hoist_response
from crane_sim.models.supports.rails import Axis, input_count
from crane_sim.models.wind_load import Windage
from crane_sim.multibody.vectors import dot, scale, subtract
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.inputs import value_at
from crane_sim.trajectories.wind import Wind


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
    forces: tuple[NodeForce, ...] | None = None
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None
    base: AnyBase | None = None
    wind: Wind | None = None
    windage: Windage | None = None  # of the payload
    share: float = 1.0  # of the mass that the bridge moves, at the trolley's position; the remainder is at x = 0

    rods = None

    def cable_coordinates(self):
        """Return the number of coordinates of the nodes."""
        return (1 + count_axes(self)) * len(self.cable.masses)

    def write_nodes(self, x, r, v):
        """Write positions and velocities (N + 1, 3) of trolley and nodes relative to the base."""
        for k in range(len(r)):
            r[k, 0], r[k, 1], r[k, 2] = node_vector(self, x, k, 0)
            v[k, 0], v[k, 1], v[k, 2] = node_vector(self, x, k, 1)

    def payload_position(self, x):
        """Return the payload's position (3,) [m] relative to the base."""
        return node_vector(self, x, len(self.cable.masses), 0)


def elastic_layout(p):
    """Return (number of coordinates, index of the first node's, dimensions, index of the first mode)."""
    nq, first, modes = layout_of(p)
    return nq, first, 1 + count_axes(p), modes


def node_vector(p, x, k, order):
    """Return the position (order 0) or velocity (order 1) of node k on the base, (3,); node 0 is the trolley."""
    nq, first, d, _ = elastic_layout(p)
    if k == 0:
        return trolley_motion(p, x)[order]
    i = order * nq + first + d * (k - 1)
    return x[i], x[i + 1] if d == 3 else 0.0, x[i + d - 1]


def link(p, x, k):
    """Return (unit vector (3,) from node k to node k + 1, length, elongation, its rate) of link k, from 0."""
    rest, paid = first_link(p, x) if k == 0 else (p.cable.lengths[k], 0.0)
    along = subtract(node_vector(p, x, k + 1, 0), node_vector(p, x, k, 0))
    relative = subtract(node_vector(p, x, k + 1, 1), node_vector(p, x, k, 1))
    length = sqrt(dot(along, along))
    n = along[0] / length, along[1] / length, along[2] / length
    return n, length, length - rest, dot(n, relative) - paid


def tautness(limits, x, first):
    """Return the mode, 1 taut or 0 slack, of the link whose mode is number `first`."""
    return 1.0 if limits is None else x[first]


def link_pull(p, x, k):
    """Return (unit vector (3,), tension [N], power that the damper takes [W]) of link k, from 0."""
    _, _, d, modes = elastic_layout(p)
    n, _, stretch, rate = link(p, x, k)
    taut = tautness(p.event_limits, x, modes + d - 1 + k)
    damping = taut * p.cable.damping[k] * rate
    return n, taut * p.cable.stiffness[k] * stretch + damping, damping * rate


def add_base_accelerations(base, p, x, out):
    """Add the nodes' accelerations to the state's derivative `out`; return the power [W] that they take."""
    if base is None:
        return NO_LOAD
    nq, first, d, _ = elastic_layout(p)
    power = 0.0
    for k in range(1, 1 + len(p.cable.masses)):
        v = node_vector(p, x, k, 1)
        acc = imposed_acceleration(base, node_vector(p, x, k, 0), v)
        power += mass_of(p, x, k) * dot(acc, v)
        add_vector(out, nq + first + d * (k - 1), d, acc)
    return power


def add_elastic_wind(p, base, t, x, out):
    """Add the payload's acceleration by the wind to the state's derivative `out`; return the wind's power [W]."""
    if p.wind is None:
        return NO_LOAD
    nq, first, d, _ = elastic_layout(p)
    n = len(p.cable.masses)
    v = node_vector(p, x, n, 1)
    force = payload_force(p, base, t, node_vector(p, x, n, 0), v)
    add_vector(out, nq + first + d * (n - 1), d, scale(1.0 / mass_of(p, x, n), force))
    return dot(force, v)


def add_node_forces(p, t, x, out):
    """Add the forces' accelerations at time t to the state's derivative `out`; return their power [W]."""
    nq, first, d, _ = elastic_layout(p)
    forces, power = p.forces or (), 0.0
    rates = [nq + first + d * (force.node - 1) + (force.axis if d == 3 else force.axis // 2) for force in forces]
    for i, force in zip(rates, forces, strict=True):
        out[i] += value_at(force.channel, t) / mass_of(p, x, force.node)
    for i, force in reversed(tuple(zip(rates, forces, strict=True))):
        power = value_at(force.channel, t) * x[i] + power
    return power


@system.rhs_into.register(ElasticCrane)
def write_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    write_elastic_derivative(p, t, x, system.effort(u, p, t, x), out)


@routine
def write_elastic_derivative(p, t, x, tau, out):
    """Write the time derivative of the state under efforts tau into `out`; return the power [W] supplied.

    That is the power of drives, imposed motions and forces, less what friction and dampers take.
    """
    nq, _, _, modes = elastic_layout(p)
    n, tension, lost = link_pull(p, x, 0)
    lost = assemble_rhs(p, x, scale(tension, n), out) + lost
    base = base_kinematics_at(p.base, p.gravity, t)
    supplied = drive_upper_end(p, t, x, tau, base, n, tension, out) + add_node_forces(p, t, x, out) - lost
    supplied += add_base_accelerations(base, p, x, out)
    supplied += add_elastic_wind(p, base, t, x, out)
    for i in range(nq):
        out[i] = x[nq + i]
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if modes > 2 * nq:
        out[2 * nq] = supplied
    return supplied


def assemble_rhs(p, x, force, out):
    """Write the nodes' accelerations, given the first link's force (3,); return the power [W] of the other dampers."""
    nq, first, d, _ = elastic_layout(p)
    lost, i, masses = 0.0, nq + first, p.cable.masses
    for k in range(1, len(masses)):
        n, tension, taken = link_pull(p, x, k)
        below = scale(tension, n)
        ax, ay, az = scale(1.0 / masses[k - 1], subtract(below, force))
        write_vector(out, i, d, ax, ay, az - p.gravity)
        force, lost, i = below, lost + taken, i + d
    inverse = 1.0 / mass_of(p, x, len(masses))
    write_vector(out, i, d, -force[0] * inverse, -force[1] * inverse, -force[2] * inverse - p.gravity)
    return lost


def write_vector(out, i, d, ax, ay, az):
    """Write a vector to out[i] and on; in the plane its last component is the second one."""
    out[i], out[i + 1] = ax, ay
    out[i + d - 1] = az


def add_vector(out, i, d, a):
    """Add a vector (3,) to out[i] and on, as `write_vector` writes it."""
    out[i] += a[0]
    if d == 3:
        out[i + 1] += a[1]
    out[i + d - 1] += a[2]


def drive_upper_end(p, t, x, tau, base, n, tension, out):
    """Write the accelerations of axes and hoist; return the power [W] that they supply."""
    nq, first, d, modes = elastic_layout(p)
    load = axes_load(base, p, x)
    inv_mass, bias_acc = p.trolley.response(t, tau, 0, x[nq], get_mode(p.event_limits, x, modes, 0))
    out[nq] = bias_acc + inv_mass * tension * n[0] + inv_mass * load.x
    supplied = p.trolley.power(tau, 0, x[nq], tension * n[0]) + load.power
    if d == 3:
        inv_mass, bias_acc = p.bridge.response(
            t, tau, input_count(p.trolley), x[nq + 1], get_mode(p.event_limits, x, modes, 1)
        )
        out[nq + 1] = bias_acc + inv_mass * tension * n[1] + inv_mass * load.y
        supplied += p.bridge.power(tau, input_count(p.trolley), x[nq + 1], tension * n[1])
    if first == d:
        inv_mass, bias_acc = hoist_response(p.hoist, t, tau, x[nq + first - 1], hoist_mode(x))
        out[nq + first - 1] = bias_acc + inv_mass * tension
        supplied += p.hoist.power(tau, x[nq + first - 1], tension)
    return supplied
