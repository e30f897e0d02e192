"""Outputs of a suspended crane: energies, tensions, points; guards of what its rope bears."""

from crane_sim import system
from crane_sim.models.cables.chain_3d import align
from crane_sim.models.carrier.dynamics import (
    carrier_energies,
    fall_guard,
    node_energies,
    posture_of,
    write_polyline,
)
from crane_sim.models.carrier.exchange import load_of
from crane_sim.models.carrier.layout import layout_of, rope_length
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.loads import RigidLoad, align_quaternion, load_energies, load_state
from crane_sim.models.moving_base import pose_at, to_world
from crane_sim.models.supports.support import bare_tip, read_state, yaw
from crane_sim.models.suspended.crane import (
    SuspendedCrane,
    fill_directions,
    next_node,
    solve_dynamics,
)
from crane_sim.models.suspended.torsion import MAX_TWIST, twist_energy, twist_motion, twist_of
from crane_sim.models.wind_kink import pressed_point, pressed_point_of
from crane_sim.multibody import linear
from crane_sim.multibody.vectors import ZERO, add, scale
from crane_sim.numerics.jit import routine


@system.project_in_place.register(SuspendedCrane)
@routine
def straighten(p, x):
    """Give unit vectors and quaternion length 1, and make their rates perpendicular to them."""
    nq, first, _ = layout_of(p)
    for i in range(first, first + 3 * len(p.cable.masses), 3):
        (x[i], x[i + 1], x[i + 2]), (x[nq + i], x[nq + i + 1], x[nq + i + 2]) = align(x, i, nq + i)
    if isinstance(p.load, RigidLoad):
        align_quaternion(x, nq - 4, 2 * nq - 4)


@system.tensions.register(SuspendedCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    work = system.workspace(p)
    solve_dynamics(p, t, x, system.effort(u, p, t, x), work)
    for k in range(len(work.tension)):
        rows[i, first + k] = work.tension[k]


@routine
def suspended_energies(p, base, x):
    """Return the energies [J] of the crane, see `carrier_energies`."""
    links, (_, rate), pose = system.workspace(p).links, rope_length(p, x), posture_of(p, x)
    fill_directions(p, x, links)
    total, node, n = carrier_energies(p, base, x, pose), bare_tip(pose), len(links.squared_rates)
    for k in range(n):
        node = next_node(links, k, rate, node)
        rate = 0.0
        if k + 1 < n:
            total = linear.add(total, node_energies(base, p.cable.masses[k], node, p.gravity))
    body = load_of(p, x)
    load = load_state(body, x, layout_of(p)[0], node)
    total = linear.add(total, load_energies(base, body, load, p.gravity))
    twist = twist_of(p.torsion, links, load, yaw(p.support, pose.state.q), pose.yaw_rate)
    return linear.add(total, (0.0, twist_energy(twist, p.torsion), 0.0, 0.0))


@system.points.register(SuspendedCrane)
@routine
def write_points(p, t, x, out):
    """Write support, nodes and the load's attachment in the world into out (N, 3)."""
    links, base, (_, rate) = system.workspace(p).links, pose_at(p.base, t), rope_length(p, x)
    fill_directions(p, x, links)
    pose = posture_of(p, x)
    i, node = write_polyline(pose, base, out), bare_tip(pose)
    for k in range(len(links.squared_rates)):
        node = next_node(links, k, rate, node)
        out[i + k, 0], out[i + k, 1], out[i + k, 2] = to_world(base, node[0])


@pressed_point.register(SuspendedCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    nq, first, _ = layout_of(p)
    node, (length, _) = bare_tip(posture_of(p, x))[0], rope_length(p, x)
    for k in range(len(p.cable.masses)):
        length, i = length if k == 0 else p.cable.lengths[k], first + 3 * k
        node = add(node, scale(length, (x[i], x[i + 1], x[i + 2])))
    body = load_of(p, x)
    return pressed_point_of(body, load_state(body, x, nq, (node, ZERO)))


def taut_guard(p, best, x, acceleration, tension):
    """Return the smaller one of `best` and the tensions [N] of links and falls to stay taut.

    `acceleration` is that of the first link's length [m/s²].
    """
    if p.stops.taut > 0.0:
        for k in range(len(tension)):
            best = smaller_guard(best, tension[k], encode(Guard.LINK, k))
        best = fall_guard(p, best, x, acceleration, tension)
    return best


def twist_guard(p, best, x, links):
    """Return the smaller one of `best` and the guard of the rope's twist; `links` is filled."""
    if p.torsion is None:
        return best
    nq, _, _ = layout_of(p)
    fill_directions(p, x, links)
    load = load_state(p.load, x, nq, (ZERO, ZERO))
    twist, _ = twist_motion(links, load, yaw(p.support, read_state(p.support, x, nq).q), 0.0)
    return smaller_guard(best, MAX_TWIST - abs(twist), encode(Guard.TWIST, 0))
