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
from crane_sim.models.energy_meter import Meter, meter_size
from crane_sim.models.moving_base import BaseKinematics, base_kinematics_at, imposed_acceleration
from crane_sim.models.overhead.base_load import NO_LOAD, Moving, axes_load
from crane_sim.models.overhead.modes import EventLimits, get_mode, get_payload_mass
from crane_sim.models.overhead.node_forces import NodeForces
from crane_sim.models.overhead.payload_wind import add_elastic_wind
from crane_sim.models.supports.hoist import Hoist, hoist_coordinates, hoist_power, hoist_response
from crane_sim.models.supports.rails import Axis, axis_power, axis_response, input_count
from crane_sim.models.wind_load import Windage
from crane_sim.numerics.jit import generic, routine
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
    forces: NodeForces | None = None
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None
    base: Moving | None = None
    wind: Wind | None = None
    windage: Windage | None = None  # of the payload
    share: float = 1.0  # of the mass that the bridge moves, at the trolley's position; the remainder is at x = 0


@generic
def dimensions(bridge):
    """Return in how many dimensions the nodes move."""
    return 3


@dimensions.register(type(None))
def _(bridge):
    return 2


def elastic_layout(p):
    """Return (number of coordinates, index of the first node's, dimensions, index of the first mode)."""
    d = dimensions(p.bridge)
    first = d - 1 + hoist_coordinates(p.hoist)
    nq = first + d * len(p.cable.masses)
    return nq, first, d, 2 * nq + meter_size(p.energy_meter)


@generic
def rest_of_first(hoist, cable, x, top, nq):
    """Return (rest length, its rate) of the first link; its coordinate is number `top`."""
    return x[top], x[nq + top]


@rest_of_first.register(type(None))
def _(hoist, cable, x, top, nq):
    return cable.lengths[0], 0.0


def node_vector(p, x, k, order):
    """Return the position (order 0) or velocity (order 1) of node k on the base, (3,); node 0 is the trolley."""
    nq, first, d, _ = elastic_layout(p)
    if k == 0:
        i = order * nq
        return x[i], x[i + 1] if d == 3 else 0.0, 0.0
    i = order * nq + first + d * (k - 1)
    return x[i], x[i + 1] if d == 3 else 0.0, x[i + d - 1]


def link(p, x, k):
    """Return (unit vector (3,) from node k to node k + 1, length, elongation, its rate) of link k, from 0."""
    nq, first, _, _ = elastic_layout(p)
    rest, paid = p.cable.lengths[k], 0.0
    if k == 0:
        rest, paid = rest_of_first(p.hoist, p.cable, x, first - 1, nq)
    (ax, ay, az), (bx, by, bz) = node_vector(p, x, k, 0), node_vector(p, x, k + 1, 0)
    (ux, uy, uz), (vx, vy, vz) = node_vector(p, x, k, 1), node_vector(p, x, k + 1, 1)
    dx, dy, dz = bx - ax, by - ay, bz - az
    length = sqrt(dx * dx + dy * dy + dz * dz)
    nx, ny, nz = dx / length, dy / length, dz / length
    return (nx, ny, nz), length, length - rest, nx * (vx - ux) + ny * (vy - uy) + nz * (vz - uz) - paid


@generic
def tautness(limits, x, first):
    """Return the mode, 1 taut or 0 slack, of the link whose mode is number `first`."""
    return 1.0


@tautness.register(EventLimits)
def _(limits, x, first):
    return x[first]


def link_pull(p, x, k):
    """Return (unit vector (3,), tension [N], power that the damper takes [W]) of link k, from 0."""
    _, _, d, modes = elastic_layout(p)
    n, _, stretch, rate = link(p, x, k)
    taut = tautness(p.event_limits, x, modes + d - 1 + k)
    damping = taut * p.cable.damping[k] * rate
    return n, taut * p.cable.stiffness[k] * stretch + damping, damping * rate


def mass_of(p, x, k):
    """Return the mass [kg] of node k, from 1."""
    mass = p.cable.masses[k - 1]
    return mass if k < len(p.cable.masses) else get_payload_mass(p.event_limits, x, len(x) - 1, mass)


def axes_motion(p, x):
    """Return (position [m], velocity [m/s]) of the trolley along x and y."""
    nq, _, d, _ = elastic_layout(p)
    if d == 3:
        return (x[0], x[1]), (x[nq], x[nq + 1])
    return (x[0], 0.0), (x[nq], 0.0)


def base_load(base, p, x):
    """Return the Load of trolley and bridge, as `axes_load` does."""
    position, velocity = axes_motion(p, x)
    return axes_load(base, p.trolley, p.bridge, p.share, position, velocity)


@generic
def add_base_accelerations(base, p, x, out):
    """Add the nodes' accelerations to the state's derivative `out`; return the power [W] that they take."""
    return NO_LOAD


@add_base_accelerations.register(BaseKinematics)
def _(base, p, x, out):
    nq, first, d, _ = elastic_layout(p)
    power, i = 0.0, nq + first
    for k in range(1, 1 + len(p.cable.masses)):
        v = node_vector(p, x, k, 1)
        ax, ay, az = imposed_acceleration(base, node_vector(p, x, k, 0), v)
        power += mass_of(p, x, k) * (ax * v[0] + ay * v[1] + az * v[2])
        out[i] += ax
        if d == 3:
            out[i + 1] += ay
        out[i + d - 1] += az
        i += d
    return power


@generic
def add_node_forces(forces, p, t, x, out):
    """Add the forces' accelerations at time t to the state's derivative `out`; return their power [W]."""
    return 0.0


@add_node_forces.register(NodeForces)
def _(forces, p, t, x, out):
    nq, first, d, _ = elastic_layout(p)
    i = nq + first + d * (forces.node - 1) + (forces.axis if d == 3 else forces.axis // 2)
    force = value_at(forces.channel, t)
    out[i] += force / mass_of(p, x, forces.node)
    return force * x[i] + add_node_forces(forces.tail, p, t, x, out)


@system.rhs_into.register(ElasticCrane)
def _(p, t, x, u, out, work):
    write_elastic_derivative(p, t, x, system.effort(u, p, t, x), out)


@routine
def write_elastic_derivative(p, t, x, tau, out):
    """Write the time derivative of the state under efforts tau into `out`; return the power [W] supplied.

    That is the power of drives, imposed motions and forces, less what friction and dampers take.
    """
    nq, _, _, modes = elastic_layout(p)
    n, tension, lost = link_pull(p, x, 0)
    lost = assemble_rhs(p, x, (tension * n[0], tension * n[1], tension * n[2]), out) + lost
    base = base_kinematics_at(p.base, p.gravity, t)
    supplied = drive_upper_end(p, t, x, tau, base, n, tension, out) + add_node_forces(p.forces, p, t, x, out) - lost
    supplied += add_base_accelerations(base, p, x, out)
    supplied += add_elastic_wind(p.wind, p, base, t, x, out)
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
    fx, fy, fz = force
    for k in range(1, len(masses)):
        (nx, ny, nz), tension, taken = link_pull(p, x, k)
        gx, gy, gz, inverse = tension * nx, tension * ny, tension * nz, 1.0 / masses[k - 1]
        write_vector(out, i, d, (gx - fx) * inverse, (gy - fy) * inverse, (gz - fz) * inverse - p.gravity)
        fx, fy, fz, lost, i = gx, gy, gz, lost + taken, i + d
    inverse = 1.0 / mass_of(p, x, len(masses))
    write_vector(out, i, d, -fx * inverse, -fy * inverse, -fz * inverse - p.gravity)
    return lost


def write_vector(out, i, d, ax, ay, az):
    """Write a vector to out[i] and on; in the plane its last component is the second one."""
    out[i], out[i + 1] = ax, ay
    out[i + d - 1] = az


def drive_upper_end(p, t, x, tau, base, n, tension, out):
    """Write the accelerations of axes and hoist; return the power [W] that they supply."""
    nq, first, d, modes = elastic_layout(p)
    load = base_load(base, p, x)
    inv_mass, bias_acc = axis_response(p.trolley, t, tau, 0, x[nq], get_mode(p.event_limits, x, modes, 0))
    out[nq] = bias_acc + inv_mass * tension * n[0] + inv_mass * load.x
    supplied = axis_power(p.trolley, tau, 0, x[nq], tension * n[0]) + load.power
    if d == 3:
        inv_mass, bias_acc = axis_response(
            p.bridge, t, tau, input_count(p.trolley), x[nq + 1], get_mode(p.event_limits, x, modes, 1)
        )
        out[nq + 1] = bias_acc + inv_mass * tension * n[1] + inv_mass * load.y
        supplied += axis_power(p.bridge, tau, input_count(p.trolley), x[nq + 1], tension * n[1])
    if first == d:
        inv_mass, bias_acc = hoist_response(p.hoist, t, tau, x, nq + first - 1)
        out[nq + first - 1] = bias_acc + inv_mass * tension
        supplied += hoist_power(p.hoist, tau, x[nq + first - 1], tension)
    return supplied
