"""A crane with a cable of N rigid links below any support: equations of motion.

State: one array [support, (l1), n_1 .. n_N, (load), and their rates, (energy supplied), (exchanges)] with unit vectors
n_k down the links in the axes of the base, and the number of exchanges of the load up to then. Equations see the state
put back on |n_k| = 1, n_k n_k' = 0, and so does each step.

The tensions solve the tridiagonal system of `cables.chain_3d`: the support enters by the mobility of its tip along the
first link, the load by that of its attachment along the last one.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.cables.chain_3d import (
    Directions,
    SupportEnd,
    align,
    direction_accelerations,
    hoisted_length_acceleration,
    solve_tensions,
)
from crane_sim.models.effects import PayloadDrag, PayloadForce, add_drag
from crane_sim.models.energy_meter import Meter, meter_size
from crane_sim.models.loads import PointLoad, RigidLoad
from crane_sim.models.moving_base import (
    airspeed,
    base_kinematics_at,
    dot,
    imposed_acceleration,
    pose_at,
    to_base,
)
from crane_sim.models.stops import Stops
from crane_sim.models.supports.backlash import drive_accelerations, play_power
from crane_sim.models.supports.hoist import Hoist, hoist_coordinates, hoist_modes
from crane_sim.models.supports.joint_modes import write_friction_rates
from crane_sim.models.supports.reeved_hoist import ReevedHoist, winch_mode, winch_power, winch_response
from crane_sim.models.supports.support import (
    Dynamics,
    Posture,
    Support,
    accelerations,
    bare_tip,
    base_efforts,
    compute_dynamics,
    compute_posture,
    coordinate_count,
    drive_count,
    drive_power,
    friction_state_count,
    joint_efforts,
    mobility,
    net_efforts,
    prescribed_accelerations,
    read_state,
    responses,
    tip_acceleration,
    tip_efforts,
    tip_rate,
    wind_efforts,
    yaw,
)
from crane_sim.models.suspended.exchange import Exchange, current_load, exchange_modes
from crane_sim.models.suspended.load_dynamics import (
    add,
    end_acceleration_across,
    end_acceleration_free,
    end_mobility,
    imposed_load_power,
    load_coordinates,
    load_state,
    moment_power,
    wind_on_load,
    write_load_acceleration,
)
from crane_sim.models.suspended.torsion import (
    Torsion,
    add_twist_power,
    push_nodes,
    twist_efforts,
    twist_load,
    twist_of,
    twist_tip,
)
from crane_sim.models.wind_load import airflow_at
from crane_sim.multibody import linear
from crane_sim.multibody.tree import to_tree_axes
from crane_sim.numerics.jit import generic, routine
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.inputs import value_at
from crane_sim.trajectories.wind import Wind


class SuspendedCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    support: Support
    cable: Chain  # node masses above the load; the last one is not used
    load: PointLoad | RigidLoad
    hoist: Hoist | ReevedHoist | None = None
    gravity: float = 9.81  # m/s²
    drag: PayloadDrag | None = None
    energy_meter: Meter | None = None
    base: AnyBase | None = None
    force: PayloadForce | None = None
    stops: Stops | None = None
    wind: Wind | None = None
    exchange: Exchange | None = None  # of the load
    torsion: Torsion | None = None  # of the rope, above a load that is a body


class Work(NamedTuple):
    """Work arrays of one evaluation."""

    links: Directions
    acc: Any  # (N + 1, 3) m/s², accelerations of tip and nodes
    tension: Any  # (N,) N
    ratio: Any  # (N,) of the elimination


class SuspendedSolution(NamedTuple):
    """Support, load and base at one instant, in addition to the work arrays."""

    pose: Posture  # of the support
    dynamics: Dynamics
    support: Any  # accelerations of its coordinates
    length: float  # m/s², acceleration of the first link's length
    tip_force: tuple[float, float, float]  # N, of rope and torsion on the tip, in the axes of the base
    tau: Any  # efforts on the coordinates of drives, springs, base, wind and torsion
    net: Any  # what accelerates the coordinates: `net_efforts`, with those of the rope
    command: Any  # efforts of the drives
    load: NamedTuple  # kinematics
    base: Any  # kinematics, None at rest
    base_power: float  # W, that the base supplies to nodes and load
    given: Any  # by `load_force`
    moment: tuple[float, float, float]  # N m, of wind and torsion on the load, in its axes
    twist: Any  # `Twist` of the rope, None without torsion


def suspended_layout(p):
    """Return (number nq of coordinates, index of the first link's, index of the first mode)."""
    first = coordinate_count(p.support) + hoist_coordinates(p.hoist)
    nq = first + 3 * len(p.cable.masses) + load_coordinates(p.load)
    return nq, first, 2 * nq + meter_size(p.energy_meter)


def mode_count(p):
    """Return the number of floats of the state's modes: the winch's or those of exchanges, then those of drives."""
    return hoist_modes(p.hoist) + exchange_modes(p.exchange) + drive_count(p.support) + friction_state_count(p.support)


@generic
def first_length(hoist, p, x, nq):
    """Return (length [m], rate [m/s]) of the first link."""
    i = coordinate_count(p.support)
    return x[i], x[nq + i]


@first_length.register(type(None))
def _(hoist, p, x, nq):
    return p.cable.lengths[0], 0.0


@system.workspace.register(SuspendedCrane)
def _(p):
    return work_arrays(p.cable.masses, p.cable.lengths)


@routine
def work_arrays(masses, lengths):
    """Return work arrays with what does not change."""
    n = len(masses)
    links = Directions(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), lengths.copy(), 1.0 / masses)
    return Work(links, np.zeros((n + 1, 3)), np.empty(n), np.empty(n))


def fill_directions(p, x, links):
    """Fill the links with those of state x, put back on what they hold."""
    nq, first, _ = suspended_layout(p)
    for k in range(len(p.cable.masses)):
        unit, rate = align(x, first + 3 * k, nq + first + 3 * k)
        links.units[k, 0], links.units[k, 1], links.units[k, 2] = unit
        links.rates[k, 0], links.rates[k, 1], links.rates[k, 2] = rate
        links.squared_rates[k] = rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2]
    links.lengths[0] = first_length(p.hoist, p, x, nq)[0]


def next_node(links, k, rate, node):
    """Return (position, velocity) of the lower end of link k, whose upper end is `node`; rate: of its length."""
    (x, y, z), (vx, vy, vz) = node
    a, b, c, length = links.units[k, 0], links.units[k, 1], links.units[k, 2], links.lengths[k]
    velocity = (
        vx + length * links.rates[k, 0] + rate * a,
        vy + length * links.rates[k, 1] + rate * b,
        vz + length * links.rates[k, 2] + rate * c,
    )
    return (x + length * a, y + length * b, z + length * c), velocity


def fill_node_accelerations(p, base, links, rate, node, acc):
    """Fill the accelerations of the nodes above the load, without tensions.

    Args:
        p, base, links: the crane, base and links.
        rate: of the first link's length [m/s].
        node: (position, velocity) of the tip.
        acc: (N + 1, 3) to fill.

    Returns:
        (position, velocity) of the last link's lower end, power [W] that the base supplies to the nodes.
    """
    power, n = 0.0, len(links.squared_rates)
    for k in range(n - 1):
        node = next_node(links, k, rate, node)
        rate = 0.0
        x, y, z = imposed_acceleration(base, node[0], node[1])
        acc[k + 1, 0], acc[k + 1, 1], acc[k + 1, 2] = x, y, z - p.gravity
        (vx, vy, vz) = node[1]
        power += (x * vx + y * vy + z * vz) * p.cable.masses[k]
    return next_node(links, n - 1, rate, node), power


def load_force(p, body, t, flow, base, load):
    """Return force (3,) [N] and moment (3,) [N m, in the load's axes] of air, wind and given forces on the load.

    Args:
        p: the crane.
        body: parameters of its load.
        t, flow, base, load: time [s], wind in the base's axes, base and kinematics of the load.
    """
    air = airspeed(base, load.position, load.velocity)
    force = add_given_force(p.force, add_drag(p.drag, (0.0, 0.0, 0.0), air), p.base, t)
    wind, moment = wind_on_load(flow, base, body, load)
    return add(force, wind), moment


@generic
def add_given_force(given, force, base, t):
    """Return the force (3,) [N] plus the given one on the payload at time t, in the axes of the base."""
    return force


@add_given_force.register(PayloadForce)
def _(given, force, base, t):
    x, y, z = to_base(pose_at(base, t), (value_at(given.x, t), value_at(given.y, t), value_at(given.z, t)))
    return force[0] + x, force[1] + y, force[2] + z


@routine
def solve_dynamics(p, t, x, tau, work):
    """Return support, load and base at time t in state x under joint efforts tau; tensions and links are in work.

    The accelerations in `work` are then those under the first link's pull on the tip, and the last one's on the load.
    """
    nq, _, end = suspended_layout(p)
    body, (links, acc, tension, ratio) = current_load(p.exchange, p.load, x, end), work
    fill_directions(p, x, links)
    n, (length, rate) = len(tension), first_length(p.hoist, p, x, nq)
    pose, base = compute_posture(p.support, read_state(p.support, x, nq)), base_kinematics_at(p.base, p.gravity, t)
    node, power = fill_node_accelerations(p, base, links, rate, bare_tip(pose), acc)
    load = load_state(body, x, nq, node)
    last = links.units[n - 1, 0], links.units[n - 1, 1], links.units[n - 1, 2]
    links.inv_masses[n - 1] = end_mobility(body, load, last)
    twist = twist_of(p.torsion, links, load, yaw(p.support, pose.state.q), pose.yaw_rate)
    push_nodes(twist, links, acc)
    flow = airflow_at(p.wind, p.base, t, 0.0)
    given = load_force(p, body, t, flow, base, load)
    (fx, fy, fz), moment = twist_load(twist, links, body, load, *given)
    imposed, m = imposed_acceleration(base, load.position, load.velocity), body.mass
    free = imposed[0] + fx / m, imposed[1] + fy / m, imposed[2] + fz / m - p.gravity
    acc[n, 0], acc[n, 1], acc[n, 2] = end_acceleration_free(body, base, load, free, moment)
    dynamics = compute_dynamics(p.support, pose)
    efforts = linear.add(joint_efforts(p.support, pose, tau), base_efforts(pose, base))
    efforts = linear.add(efforts, wind_efforts(pose, flow, base))
    efforts = linear.add(efforts, twist_efforts(twist, pose))
    beside = to_tree_axes(pose.kinematics.turn, twist_tip(twist, links, (0, 0, 0)))
    net = linear.add(net_efforts(dynamics, p.gravity, efforts), tip_efforts(pose, beside))
    qdd = accelerations(dynamics, net, prescribed_accelerations(p.support, pose, tau))
    acc[0, 0], acc[0, 1], acc[0, 2] = tip_acceleration(pose, qdd)
    first = links.units[0, 0], links.units[0, 1], links.units[0, 2]
    levers = tip_efforts(pose, to_tree_axes(pose.kinematics.turn, first))
    answer = responses(dynamics, levers)
    at = nq + coordinate_count(p.support), end
    hoist_inv_mass, hoist_bias_acc = winch_response(p.hoist, t, tau, x, at, (length, rate, p.gravity))
    top = SupportEnd(mobility(dynamics, levers, answer), hoist_inv_mass, hoist_bias_acc, rate)
    solve_tensions(links, top, acc, tension, ratio)
    length_acc = hoisted_length_acceleration(links, top, acc, tension)
    pull = twist_tip(twist, links, (tension[0] * first[0], tension[0] * first[1], tension[0] * first[2]))
    net = linear.add(net, linear.scale(tension[0], levers))
    qdd = linear.add(qdd, linear.scale(tension[0], answer))
    moved = tip_rate(pose, answer)
    across = end_acceleration_across(body, load, last, tension[n - 1])
    for i in range(3):
        acc[0, i] += tension[0] * moved[i]
        acc[n, i] += across[i]
    power += imposed_load_power(base, body, load)
    return SuspendedSolution(
        pose, dynamics, qdd, length_acc, pull, efforts, net, tau, load, base, power, given, moment, twist
    )


@system.rhs_into.register(SuspendedCrane)
def _(p, t, x, u, out, work):
    write_suspended_derivative(p, t, x, u, out, work)


@routine
def write_suspended_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, end = suspended_layout(p)
    body, tau = current_load(p.exchange, p.load, x, end), system.effort(u, p, t, x)
    links, acc, tension, _ = work
    solved, n, ns = solve_dynamics(p, t, x, tau, work), len(tension), coordinate_count(p.support)
    for i in range(nq):
        out[i] = x[nq + i]
    for k in range(n):
        for i in range(3):
            out[first + 3 * k + i] = links.rates[k, i]
    for i in range(len(solved.support)):
        out[nq + i] = solved.support[i]
    for i, drive_acc in enumerate(drive_accelerations(p.support.drives, solved.command, solved.pose.state)):
        out[nq + len(solved.support) + i] = drive_acc
    if first > ns:
        out[nq + ns] = solved.length
    top = SupportEnd(0.0, 0.0, 0.0, first_length(p.hoist, p, x, nq)[1])
    direction_accelerations(links, top, acc, tension, out, nq + first)
    last = links.units[n - 1, 0], links.units[n - 1, 1], links.units[n - 1, 2]
    pull = last, tension[n - 1], solved.moment
    write_load_acceleration(body, solved.base, solved.load, pull, (out, nq + first + 3 * n))
    if end > 2 * nq:
        out[2 * nq] = suspended_power(p, t, x, solved, work)
    for i in range(end, len(out)):
        out[i] = 0.0
    write_friction_rates(p.support, solved.pose.state, out)


def suspended_power(p, t, x, solved, work):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    nq, _, end = suspended_layout(p)
    body = current_load(p.exchange, p.load, x, end)
    motion, load = (*first_length(p.hoist, p, x, nq), solved.length), solved.load
    force, moment = solved.given
    pull = to_tree_axes(solved.pose.kinematics.turn, solved.tip_force)
    power = drive_power(solved.pose, solved.tau, pull) + solved.base_power
    power += winch_power(p.hoist, solved.command, winch_mode(p.hoist, x, end), motion, work.tension[0], p.gravity)
    power += play_power(p.support.drives, solved.command, solved.pose.state)
    power = add_twist_power(solved.twist, power, solved.pose.yaw_rate)
    return power + dot(force, load.velocity) + moment_power(body, load, moment)
