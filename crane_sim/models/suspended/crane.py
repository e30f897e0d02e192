"""A crane with a cable of N rigid links below any support: equations of motion.

State: one array [support, (l1), n_1 .. n_N, (load), and their rates, (energy supplied),
(exchanges)] with unit vectors n_k down the links in the axes of the base, and the number of
exchanges of the load up to then. Equations see the state put back on |n_k| = 1, n_k n_k' = 0, and
so does each step.

The tensions solve the tridiagonal system of `cables.chain_3d`: the support enters by the mobility
of its tip along the first link, the load by that of its attachment along the last one.
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
    row_of,
    solve_tensions,
)
from crane_sim.models.carrier.dynamics import (
    SupportMotion,
    move_support,
    posture_of,
    support_power,
    winch_power,
    winch_response,
    write_common_rates,
)
from crane_sim.models.carrier.exchange import Exchange, load_of
from crane_sim.models.carrier.layout import layout_of, rope_length
from crane_sim.models.effects import (
    NodeForce,
    PayloadDrag,
    PayloadForce,
    SwingFriction,
    force_on_node,
    values_of,
)
from crane_sim.models.energy_meter import Meter
from crane_sim.models.loads import (
    PointLoad,
    RigidLoad,
    centre_acceleration,
    end_acceleration_across,
    end_acceleration_free,
    end_mobility,
    imposed_load_power,
    load_coordinates,
    load_force,
    load_state,
    moment_power,
    write_load_acceleration,
)
from crane_sim.models.moving_base import base_kinematics_at, imposed_acceleration
from crane_sim.models.stops import Stops
from crane_sim.models.supports.hoist import Hoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.support import Support, bare_tip, tip_acceleration, tip_rate, yaw
from crane_sim.models.supports.support_dynamics import responses, tip_efforts
from crane_sim.models.suspended.swing_friction import (
    pull_first_node,
    pull_load,
    pull_tip,
    swing_pull,
)
from crane_sim.models.suspended.torsion import (
    Torsion,
    add_twist_power,
    push_nodes,
    twist_couple,
    twist_load,
    twist_of,
    twist_tip,
)
from crane_sim.models.wind_load import airflow_at
from crane_sim.multibody import linear
from crane_sim.multibody.tree import to_tree_axes
from crane_sim.multibody.vectors import ZERO, add, dot, scale
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.wind import Wind


class OverheadJoints(NamedTuple):
    """Marks an overhead crane's joints: directions of links; a `hoist` changes the first one."""


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
    forces: tuple[NodeForce, ...] | None = None
    swing_friction: SwingFriction | None = None  # of the first link
    overhead: OverheadJoints | None = None

    def hanging_coordinates(self):
        """Return the number of hanging coordinates: unit vectors of links, the load's own."""
        return 3 * len(self.cable.masses) + load_coordinates(self.load)

    def cable_modes(self):
        """Return the number of modes of the cable: rigid links have none."""
        return 0

    def fixed_length(self):
        """Return the length [m] of the first link, where no hoist changes it."""
        return self.cable.lengths[0]


class Work(NamedTuple):
    """Work arrays of one evaluation."""

    links: Directions
    acc: Any  # (N + 1, 3) m/s², accelerations of tip and nodes
    tension: Any  # (N,) N
    ratio: Any  # (N,) of the elimination


class SuspendedSolution(NamedTuple):
    """Support, load and base at one instant, in addition to the work arrays."""

    support: SupportMotion
    length: Any  # m/s², acceleration of the first link's length
    paid: Any  # N, pull of the first link on its length
    load: Any  # kinematics
    base: Any  # kinematics, None at rest
    outside_power: Any  # W, that base and forces supply to nodes, and the base to the load
    given: Any  # by `load_force`
    moment: Any  # (3,) N m, of wind and torsion on the load, in its axes
    twist: Any  # `Twist` of the rope, None without torsion
    swing: Any  # `SwingPull`, None without friction of the swing


@system.workspace.register(SuspendedCrane)
@routine
def work_arrays(p):
    """Return work arrays with what does not change."""
    n = len(p.cable.masses)
    links = Directions(
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty(n),
        p.cable.lengths.copy(),
        1.0 / p.cable.masses,
    )
    return Work(links, np.zeros((n + 1, 3)), np.empty(n), np.empty(n))


def fill_directions(p, x, links):
    """Fill the links with those of state x, put back on what they hold."""
    nq, first, _ = layout_of(p)
    for k in range(len(p.cable.masses)):
        unit, rate = align(x, first + 3 * k, nq + first + 3 * k)
        links.units[k, 0], links.units[k, 1], links.units[k, 2] = unit
        links.rates[k, 0], links.rates[k, 1], links.rates[k, 2] = rate
        links.squared_rates[k] = dot(rate, rate)
    links.lengths[0] = rope_length(p, x)[0]


def next_node(links, k, rate, node):
    """Return (position, velocity) of the lower end of link k, below `node`.

    `rate` is that of the link's length.
    """
    (position, velocity), unit, length = node, row_of(links.units, k), links.lengths[k]
    velocity = add(add(velocity, scale(length, row_of(links.rates, k))), scale(rate, unit))
    return add(position, scale(length, unit)), velocity


def fill_node_accelerations(p, base, values, links, rate, node, acc):
    """Fill the accelerations of the nodes above the load, without tensions.

    Args:
        p, base, links: the crane, base and links.
        values: of the forces on nodes, by `values_of`.
        rate: of the first link's length [m/s].
        node: (position, velocity) of the tip.
        acc: (N + 1, 3) to fill.

    Returns:
        (position, velocity) of the last link's lower end, power [W] that base and forces supply to
        the nodes.
    """
    power, n = 0.0, len(links.squared_rates)
    for k in range(n - 1):
        node = next_node(links, k, rate, node)
        rate = 0.0
        (x, y, z), push = (
            imposed_acceleration(base, node[0], node[1]),
            force_on_node(p.forces, values, k + 1),
        )
        free = add((x, y, z - p.gravity), scale(links.inv_masses[k], push))
        acc[k + 1, 0], acc[k + 1, 1], acc[k + 1, 2] = free
        power += dot((x, y, z), node[1]) * p.cable.masses[k] + dot(push, node[1])
    return next_node(links, n - 1, rate, node), power


@routine
def solve_dynamics(p, t, x, tau, work):
    """Return support, load and base at time t in state x under joint efforts tau.

    Tensions and links are written into `work`.

    The accelerations in `work` are then those under the first link's pull on the tip, and the last
    one's on the load.
    """
    links, acc, tension, _ = work
    fill_directions(p, x, links)
    pose, base = posture_of(p, x), base_kinematics_at(p.base, p.gravity, t)
    flow, values = airflow_at(p.wind, p.base, t, 0.0), values_of(p.forces, t)
    node, power = fill_node_accelerations(
        p, base, values, links, rope_length(p, x)[1], bare_tip(pose), acc
    )
    body = load_of(p, x)
    load = load_state(body, x, layout_of(p)[0], node)
    # torsion and friction of the swing: between load, nodes and tip
    twist = twist_of(p.torsion, links, load, yaw(p.support, pose.state.q), pose.yaw_rate)
    swing = swing_pull(p.swing_friction, pose, links)
    push_nodes(twist, links, acc)
    pull_first_node(swing, links, acc)
    # the load without the last link's pull
    force, moment = load_force(p, body, t, flow, base, load)
    given = add(force, force_on_node(p.forces, values, len(tension))), moment
    force, moment = pull_load(
        swing, links, body, load, *twist_load(twist, links, body, load, *given)
    )
    fill_load_end(p, body, base, load, force, moment, work)
    # the support without the first link's pull
    couple, push = pull_tip(swing, twist_couple(twist), twist_tip(twist, links, ZERO))
    free = move_support(
        p, t, pose, tau, flow, base, couple, to_tree_axes(pose.kinematics.turn, push)
    )
    support, length = pull_links(p, t, x, body, load, free, work)
    power += imposed_load_power(base, body, load)
    return SuspendedSolution(
        support, length, tension[0], load, base, power, given, moment, twist, swing
    )


def fill_load_end(p, body, base, load, force, moment, work):
    """Fill mobility and acceleration of the load's attachment without the cable.

    They are those under a force [N] and a moment [N m].
    """
    links, acc, n = work.links, work.acc, len(work.tension)
    links.inv_masses[n - 1] = end_mobility(body, load, row_of(links.units, n - 1))
    free = centre_acceleration(body, base, load, force, p.gravity)
    acc[n, 0], acc[n, 1], acc[n, 2] = end_acceleration_free(body, base, load, free, moment)


def pull_links(p, t, x, body, load, free, work):
    """Fill the tensions, and what they add to the accelerations of tip and load.

    Args:
        p, t, x: the crane, time [s], state.
        body, load: parameters of the load and its kinematics.
        free: SupportMotion without the cable's pull.
        work: accelerations without tensions.

    Returns:
        SupportMotion under the first link's pull, acceleration of its length [m/s²].
    """
    links, acc, tension, ratio = work
    n, pose = len(tension), free.pose
    acc[0, 0], acc[0, 1], acc[0, 2] = tip_acceleration(pose, free.accelerations)
    levers = tip_efforts(pose, to_tree_axes(pose.kinematics.turn, row_of(links.units, 0)))
    answer = responses(free.dynamics, levers)
    inv_mass, bias_acc = winch_response(p, t, x, free.command)
    top = SupportEnd(linear.inner(levers, answer), inv_mass, bias_acc, rope_length(p, x)[1])
    solve_tensions(links, top, acc, tension, ratio)
    length = hoisted_length_acceleration(links, top, acc, tension)
    net = linear.add(free.net, linear.scale(tension[0], levers))
    qdd = linear.add(free.accelerations, linear.scale(tension[0], answer))
    moved = tip_rate(pose, answer)
    across = end_acceleration_across(body, load, row_of(links.units, n - 1), tension[n - 1])
    for i in range(3):
        acc[0, i] += tension[0] * moved[i]
        acc[n, i] += across[i]
    return free._replace(net=net, accelerations=qdd), length


@system.rhs_into.register(SuspendedCrane)
@routine
def write_suspended_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    (nq, first, _), (links, acc, tension, _) = layout_of(p), work
    solved, n = solve_dynamics(p, t, x, system.effort(u, p, t, x), work), len(tension)
    write_common_rates(p, x, solved, out)
    for k in range(n):
        for i in range(3):
            out[first + 3 * k + i] = links.rates[k, i]
    top = SupportEnd(0.0, 0.0, 0.0, rope_length(p, x)[1])
    direction_accelerations(links, top, acc, tension, out, nq + first)
    pull = row_of(links.units, n - 1), tension[n - 1], solved.moment
    write_load_acceleration(load_of(p, x), solved.base, solved.load, pull, out, nq + first + 3 * n)
    if p.energy_meter is not None:
        out[2 * nq] = suspended_power(p, x, solved)


def suspended_power(p, x, solved):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    (force, moment), yaw_rate = solved.given, solved.support.pose.yaw_rate
    power = support_power(p, solved) + solved.outside_power + winch_power(p, x, solved)
    power = add_twist_power(solved.twist, power, yaw_rate)
    if solved.swing is not None:
        power -= solved.swing.loss + solved.swing.couple * yaw_rate
    return power + dot(force, solved.load.velocity) + moment_power(p.load, solved.load, moment)
