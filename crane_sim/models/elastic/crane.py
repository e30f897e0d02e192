"""A crane with a cable of springs and dampers below a support, in space or a vertical plane.

State: one array [support, (l1), r_1 .. r_N, and their rates, (energy supplied), modes] with the
nodes' positions r_k on
the base: (x, z) each in the plane, (x, y, z) in space. Link k pulls with T = k e + c e', e its
length beyond the rest length, l1 of the first link where there is a hoist. Where links only pull,
each has a mode, 1 while it is taut, 0 while it is slack; other modes stand behind
(`carrier.layout`).

The nodes' accelerations, those of support and hoist, and what a moving base adds to them.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.models.carrier.dynamics import (
    SupportMotion,
    carrier_energies,
    move_support,
    node_energies,
    posture_of,
    support_power,
    winch_power,
    winch_response,
    write_common_rates,
    write_polyline,
)
from crane_sim.models.carrier.exchange import Exchange, load_of
from crane_sim.models.carrier.layout import layout_of, rope_length
from crane_sim.models.effects import NodeForce, PayloadDrag, PayloadForce, force_on_node, values_of
from crane_sim.models.energy_meter import Meter
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.loads import PointLoad, PointState, load_energies, load_force
from crane_sim.models.moving_base import base_kinematics_at, imposed_acceleration, pose_at, to_world
from crane_sim.models.stops import Stops
from crane_sim.models.supports.bridge import Bridge
from crane_sim.models.supports.hoist import Hoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.support import Support, bare_tip
from crane_sim.models.suspended.crane import OverheadJoints
from crane_sim.models.wind_kink import pressed_point
from crane_sim.models.wind_load import airflow_at
from crane_sim.multibody import linear
from crane_sim.multibody.tree import to_tree_axes
from crane_sim.multibody.vectors import Vector, add, dot, scale, subtract
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.wind import Wind


class Slack(NamedTuple):
    """The presence of links that go slack where they would push."""


class Springs(NamedTuple):
    """Node masses and links from the top, (N,) arrays; the last node is the payload."""

    masses: Any  # kg, above the load; the last one is not used
    lengths: Any  # m, at rest; the first one is not used where there is a hoist
    stiffness: Any  # N/m
    damping: Any  # N s/m
    slack: Slack | None = None  # None: links also push


class ElasticCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    support: Support
    cable: Springs
    load: PointLoad
    hoist: Hoist | ReevedHoist | None = None
    gravity: float = 9.81  # m/s²
    drag: PayloadDrag | None = None
    energy_meter: Meter | None = None
    base: AnyBase | None = None
    force: PayloadForce | None = None
    stops: Stops | None = None
    wind: Wind | None = None
    exchange: Exchange | None = None  # of the load
    forces: tuple[NodeForce, ...] | None = None
    overhead: OverheadJoints | None = None

    def dimensions(self):
        """Return the number of a node's coordinates: 2 below a trolley without a bridge."""
        structure = self.support.structure
        return 2 if isinstance(structure, Bridge) and structure.bridge is None else 3

    def hanging_coordinates(self):
        """Return the number of coordinates of the nodes."""
        return self.dimensions() * len(self.cable.masses)

    def cable_modes(self):
        """Return the number of links that have a mode."""
        return 0 if self.cable.slack is None else len(self.cable.masses)

    def fixed_length(self):
        """Return the length [m] of the first link at rest, where no hoist changes it."""
        return self.cable.lengths[0]


class Pull(NamedTuple):
    """A link at one instant."""

    n: Vector  # unit vector down the link
    tension: Any  # N
    lost: Any  # W, that its damper takes


class ElasticSolution(NamedTuple):
    """Motion and forces at one instant, in addition to the accelerations of the nodes."""

    support: SupportMotion
    length: Any  # m/s², acceleration of the first link's length
    paid: Any  # N, pull of the first link on its length
    outside_power: Any  # W, of base, wind and forces on nodes and load, less what dampers take


def node_at(p, x, k):
    """Return (position, velocity), each (3,), of node k, from 1, on the base."""
    (nq, first, _), d = layout_of(p), p.dimensions()
    i = first + d * (k - 1)
    return vector_at(x, i, d), vector_at(x, nq + i, d)


def vector_at(x, i, d):
    """Return the vector (3,) that begins at x[i]; in the plane its second component is 0."""
    return x[i], x[i + 1] if d == 3 else 0, x[i + d - 1]


def stretch_of(upper, lower, rest, paid):
    """Return (unit vector (3,), elongation [m], its rate [m/s]) of a link between two nodes.

    A node is (position, velocity).

    Args:
        upper, lower: its ends.
        rest, paid: its length at rest [m], and the rate of that [m/s].
    """
    along, relative = subtract(lower[0], upper[0]), subtract(lower[1], upper[1])
    length = sqrt(dot(along, along))
    n = along[0] / length, along[1] / length, along[2] / length
    return n, length - rest, dot(n, relative) - paid


def first_stretch(p, x, tip):
    """Return the `stretch_of` the first link; tip: (position, velocity) of its upper end."""
    return stretch_of(tip, node_at(p, x, 1), *rope_length(p, x))


def further_stretch(p, x, k):
    """Return the result of `stretch_of` for link k, from 1: one below the first."""
    return stretch_of(node_at(p, x, k), node_at(p, x, k + 1), p.cable.lengths[k], 0.0)


def stretch_at(p, x, k, tip):
    """Return the result of `stretch_of` for link k, from 0."""
    return first_stretch(p, x, tip) if k == 0 else further_stretch(p, x, k)


def tautness(p, x, k):
    """Return the mode of link k, from 0: 1 taut or 0 slack."""
    return 1.0 if p.cable.slack is None else x[layout_of(p)[2] + k]


def pull_of(p, x, k, stretched):
    """Return the Pull of link k, from 0, by the result of `stretch_of`."""
    (n, stretch, rate), taut = stretched, tautness(p, x, k)
    damping = taut * p.cable.damping[k] * rate
    return Pull(n, taut * p.cable.stiffness[k] * stretch + damping, damping * rate)


def payload_state(p, x):
    """Return the load's PointState."""
    return PointState(*node_at(p, x, len(p.cable.masses)))


def write_node(p, base, x, k, force, mass, out):
    """Write the acceleration of node k of a mass [kg] under a force (3,) [N].

    Return the power [W] of the base.
    """
    (nq, first, _), d = layout_of(p), p.dimensions()
    i, acc, power = nq + first + d * (k - 1), scale(1.0 / mass, force), 0
    if base is not None:
        position, velocity = node_at(p, x, k)
        imposed = imposed_acceleration(base, position, velocity)
        acc, power = add(acc, imposed), mass * dot(imposed, velocity)
    out[i], out[i + 1] = acc[0], acc[1]
    out[i + d - 1] = acc[2] - p.gravity
    return power


@routine
def write_nodes(p, t, x, base, given, first, out):
    """Write the nodes' accelerations into the state's derivative `out`.

    Args:
        p, t, x: the crane, time [s], state.
        base: as of `base_kinematics_at`.
        given: force (3,) [N] on the load.
        first: Pull of the first link on its upper node.
        out: to write to.

    Returns:
        the power [W] of base and forces, less what the dampers of links take.
    """
    n, power, values = len(p.cable.masses), 0.0, values_of(p.forces, t)
    force = scale(first.tension, first.n)
    for k in range(1, n):
        below = pull_of(p, x, k, further_stretch(p, x, k))
        pull, push = scale(below.tension, below.n), force_on_node(p.forces, values, k)
        node = add(subtract(pull, force), push)
        imposed = write_node(p, base, x, k, node, p.cable.masses[k - 1], out)
        power += imposed + dot(push, node_at(p, x, k)[1]) - below.lost
        force = pull
    given = add(given, force_on_node(p.forces, values, n))
    power += write_node(p, base, x, n, subtract(given, force), load_of(p, x).mass, out)
    return power + dot(given, node_at(p, x, n)[1]) - first.lost


@routine
def solve_dynamics(p, t, x, tau, out):
    """Return motion and forces at time t in state x under efforts tau.

    The nodes' accelerations are written into `out`.
    """
    pose, base = posture_of(p, x), base_kinematics_at(p.base, p.gravity, t)
    first = pull_of(p, x, 0, first_stretch(p, x, bare_tip(pose)))
    flow = airflow_at(p.wind, p.base, t, 0.0)
    at_tip = to_tree_axes(pose.kinematics.turn, scale(first.tension, first.n))
    support = move_support(p, t, pose, tau, flow, base, 0, at_tip)
    inv_mass, bias_acc = winch_response(p, t, x, tau)
    given, _ = load_force(p, load_of(p, x), t, flow, base, payload_state(p, x))
    power = write_nodes(p, t, x, base, given, first, out)
    return ElasticSolution(support, bias_acc + inv_mass * first.tension, first.tension, power)


@system.rhs_into.register(ElasticCrane)
@routine
def write_elastic_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, _, _ = layout_of(p)
    solved = solve_dynamics(p, t, x, system.effort(u, p, t, x), out)
    write_common_rates(p, x, solved, out)
    if p.energy_meter is not None:
        out[2 * nq] = elastic_power(p, x, solved)


def elastic_power(p, x, solved):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    return support_power(p, solved) + solved.outside_power + winch_power(p, x, solved)


@routine
def initialize_link_modes(p, x):
    """Set the modes of links that go slack to those of their elongations."""
    if p.cable.slack is None:
        return
    (_, _, modes), tip = layout_of(p), bare_tip(posture_of(p, x))
    for k in range(len(p.cable.masses)):
        x[modes + k] = 1.0 if min(*link_forces(p, x, k, tip)) >= 0.0 else 0.0


def link_forces(p, x, k, tip):
    """Return (k e, k e + c e') [N] of link k: where it is taut it pulls by the second one."""
    _, stretch, rate = stretch_at(p, x, k, tip)
    spring = p.cable.stiffness[k] * stretch
    return spring, spring + p.cable.damping[k] * rate


@routine
def elastic_energies(p, base, x):
    """Return the energies [J] of the crane, see `carrier_energies`."""
    pose, n = posture_of(p, x), len(p.cable.masses)
    total, tip = carrier_energies(p, base, x, pose), bare_tip(pose)
    for k in range(n):
        _, stretch, _ = stretch_at(p, x, k, tip)
        stored = 0.5 * tautness(p, x, k) * p.cable.stiffness[k] * stretch * stretch
        total = linear.add(total, (0.0, stored, 0.0, 0.0))
    for k in range(1, n):
        total = linear.add(
            total, node_energies(base, p.cable.masses[k - 1], node_at(p, x, k), p.gravity)
        )
    return linear.add(total, load_energies(base, load_of(p, x), payload_state(p, x), p.gravity))


@system.tensions.register(ElasticCrane)
@routine
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    tip = bare_tip(posture_of(p, x))
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = pull_of(p, x, k, stretch_at(p, x, k, tip)).tension


@system.points.register(ElasticCrane)
@routine
def write_points(p, t, x, out):
    """Write support and nodes in the world into out (N, 3)."""
    base = pose_at(p.base, t)
    i = write_polyline(posture_of(p, x), base, out)
    for k in range(len(p.cable.masses)):
        out[i + k, 0], out[i + k, 1], out[i + k, 2] = to_world(base, node_at(p, x, k + 1)[0])


@pressed_point.register(ElasticCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    return payload_state(p, x).position


def links_guard(p, best, x):
    """Return the smaller one of `best` and the guards [N] of links that only pull.

    A slack one pulls where both its e and its k e + c e' are > 0.
    """
    if p.cable.slack is None:
        return best
    tip = bare_tip(posture_of(p, x))
    for k in range(len(p.cable.masses)):
        spring, total = link_forces(p, x, k, tip)
        value = total if tautness(p, x, k) > 0.0 else -min(spring, total)
        best = smaller_guard(best, value, encode(Guard.LINK, k))
    return best
