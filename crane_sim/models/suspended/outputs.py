"""Outputs of a suspended crane: energies, tensions, points; its guards, and the stops that end its runs."""

from crane_sim import system
from crane_sim.models.cables.chain_3d import align
from crane_sim.models.guards import Guard, decode, encode, smaller_guard
from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import added_energy, pose_at, to_world
from crane_sim.models.stops import WINCH, Stops, describe_cable_event, describe_stop, length_guard
from crane_sim.models.supports.backlash import describe_drive, drive_energies
from crane_sim.models.supports.hoist import hoist_reflected_mass
from crane_sim.models.supports.joint_modes import any_joint_sticks, sticking_guard, support_guard
from crane_sim.models.supports.reeved_hoist import winch_energy
from crane_sim.models.supports.support import bare_tip, compute_posture, polyline, polyline_size, read_state, yaw
from crane_sim.models.supports.support_dynamics import (
    compute_dynamics,
    energy_by_base,
    kinetic_energy,
    potential_energy,
)
from crane_sim.models.suspended import load_dynamics
from crane_sim.models.suspended.crane import SuspendedCrane, fill_directions, next_node, solve_dynamics
from crane_sim.models.suspended.exchange import describe_exchange, exchange_guard, load_of
from crane_sim.models.suspended.layout import layout_of, rope_length
from crane_sim.models.suspended.load_dynamics import align_quaternion, load_base_energy, load_state
from crane_sim.models.suspended.torsion import MAX_TWIST, add_twist_energy, twist_motion, twist_of
from crane_sim.models.suspended.winch import fall_guard, smallest_winch_guard, winch_sticks
from crane_sim.models.wind_kink import pressed_point, pressed_point_of
from crane_sim.multibody.vectors import ZERO, add, dot, scale
from crane_sim.numerics.jit import routine


@system.project_in_place.register(SuspendedCrane)
@routine
def straighten(p, x):
    """Give unit vectors and quaternion their length 1, and take from their rates what is not across them."""
    nq, first, _ = layout_of(p)
    for i in range(first, first + 3 * len(p.cable.masses), 3):
        (x[i], x[i + 1], x[i + 2]), (x[nq + i], x[nq + i + 1], x[nq + i + 2]) = align(x, i, nq + i)
    if isinstance(p.load, RigidLoad):
        align_quaternion(x, nq - 4, 2 * nq - 4)


@system.link_count.register(SuspendedCrane)
def count_links(p):
    """Return the number of links."""
    return len(p.cable.masses)


@system.tensions.register(SuspendedCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    work = system.workspace(p)
    solve_dynamics(p, t, x, system.effort(u, p, t, x), work)
    for k in range(len(work.tension)):
        rows[i, first + k] = work.tension[k]


@routine
def suspended_energies(p, base, x):
    """Return (kinetic, potential) energy [J] relative to the base, and those that it adds in the world.

    Args:
        p: the crane.
        base: of `base_state` in its own axes, None at rest.
        x: state.
    """
    (nq, _, _), body = layout_of(p), load_of(p, x)
    links, (_, rate) = system.workspace(p).links, rope_length(p, x)
    fill_directions(p, x, links)
    pose = compute_posture(p.support, read_state(p.support, x, nq))
    wound, hung = winch_energy(p.hoist, links.lengths[0], rate, p.gravity)
    moving, sprung = support_energies(p.support, pose, p.gravity)
    kinetic = moving + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate + wound
    potential, added = sprung + hung, support_added_energy(base, pose, p.gravity)
    node, n = bare_tip(pose), len(links.squared_rates)
    for k in range(n):
        node = next_node(links, k, rate, node)
        rate = 0.0
        if k + 1 < n:
            mass = p.cable.masses[k]
            kinetic += 0.5 * mass * dot(node[1], node[1])
            potential += mass * p.gravity * node[0][2]
            more = mass_added_energy(base, p.gravity, mass, node)
            added = added[0] + more[0], added[1] + more[1]
    load = load_state(body, x, nq, node)
    more = load_base_energy(base, body, load, p.gravity)
    kinetic += load_dynamics.kinetic_energy(body, load)
    potential += body.mass * p.gravity * load.position[2]
    twist = twist_of(p.torsion, links, load, yaw(p.support, pose.state.q), pose.yaw_rate)
    potential = add_twist_energy(twist, p.torsion, potential)
    return kinetic, potential, added[0] + more[0], added[1] + more[1]


def support_energies(support, pose, gravity):
    """Return (kinetic, potential) energy [J] of structure and drives, relative to the base."""
    kinetic, potential = drive_energies(support.drives, pose.state)
    dynamics = compute_dynamics(support, pose)
    return kinetic_energy(pose, dynamics) + kinetic, potential_energy(pose, dynamics, gravity) + potential


def support_added_energy(base, pose, gravity):
    """Return (kinetic, potential) energy [J] that a moving base adds to the support's masses."""
    return (0.0, 0.0) if base is None else energy_by_base(pose, base, gravity)


def mass_added_energy(base, gravity, mass, node):
    """Return (kinetic, potential) energy [J] that a moving base adds to a mass at a node (position, velocity)."""
    return (0.0, 0.0) if base is None else added_energy(base, gravity, mass, *node)


@system.point_count.register(SuspendedCrane)
def count_points(p):
    """Return the number of points of support and nodes."""
    return polyline_size(p.support) + len(p.cable.masses)


@system.points.register(SuspendedCrane)
@routine
def write_points(p, t, x, out):
    """Write support, nodes and the load's attachment in the world into out (N, 3)."""
    nq, _, _ = layout_of(p)
    links, base, (_, rate) = system.workspace(p).links, pose_at(p.base, t), rope_length(p, x)
    fill_directions(p, x, links)
    pose = compute_posture(p.support, read_state(p.support, x, nq))
    i, node = write_polyline(pose, base, out), bare_tip(pose)
    for k in range(len(links.squared_rates)):
        node = next_node(links, k, rate, node)
        out[i + k, 0], out[i + k, 1], out[i + k, 2] = to_world(base, node[0])


def write_polyline(pose, base, out):
    """Write the support's polyline in the world into the first rows of `out`, and return their number."""
    points = polyline(pose)
    for i, point in enumerate(points):
        out[i, 0], out[i, 1], out[i, 2] = to_world(base, point)
    return len(points)


@pressed_point.register(SuspendedCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    nq, first, _ = layout_of(p)
    node, (length, _) = bare_tip(compute_posture(p.support, read_state(p.support, x, nq)))[0], rope_length(p, x)
    for k in range(len(p.cable.masses)):
        length, i = length if k == 0 else p.cable.lengths[k], first + 3 * k
        node = add(node, scale(length, (x[i], x[i + 1], x[i + 2])))
    body = load_of(p, x)
    return pressed_point_of(body, load_state(body, x, nq, (node, ZERO)))


@system.guard.register(SuspendedCrane)
@routine
def smallest_guard(p, t, x, u, work):
    """Return (the smallest guard, its number, evaluations): limits of support and first length, slack links."""
    (nq, _, _), (length, rate), stops, acceleration = layout_of(p), rope_length(p, x), p.stops, 0.0
    best = exchange_guard(p, length_guard(stops, length, rate), t, x)
    state, tau = read_state(p.support, x, nq), system.effort(u, p, t, x)
    best = twist_guard(p, support_guard(p.support, best, state), x, work.links)
    forces = stops.taut > 0.0 or winch_sticks(p, x) or any_joint_sticks(p.support, state)
    if forces:
        solved = solve_dynamics(p, t, x, tau, work)
        acceleration = solved.length
        best = sticking_guard(p.support, best, solved.pose.state, solved)
    if stops.taut > 0.0:
        for k in range(len(work.tension)):
            best = smaller_guard(best, work.tension[k], encode(Guard.LINK, k))
        best = fall_guard(p, best, x, acceleration, work.tension)
    value, number = smallest_winch_guard(p, best, x, tau, work.tension[0])
    return value, number, int(forces)


def twist_guard(p, best, x, links):
    """Return the smaller one of `best` and the guard of the rope's twist; `links` is filled."""
    if p.torsion is None:
        return best
    nq, _, _ = layout_of(p)
    fill_directions(p, x, links)
    load = load_state(p.load, x, nq, (ZERO, ZERO))
    twist, _ = twist_motion(links, load, yaw(p.support, read_state(p.support, x, nq).q), 0.0)
    return smaller_guard(best, MAX_TWIST - abs(twist), encode(Guard.TWIST, 0))


@system.describe_event.register(SuspendedCrane)
def describe_event(p, number):
    """Return texts (what an event was, what a user can change)."""
    kind, link, outcome = decode(number)
    if p.overhead is not None and (kind in (Guard.LINK, Guard.LENGTH) or (kind == Guard.FRICTION and link == WINCH)):
        return describe_cable_event(number, (p.stops or Stops()).shortest)
    if kind == Guard.BACKLASH:
        return describe_drive(p.support, link, outcome), ""
    if kind == Guard.PAYLOAD and p.exchange is not None:
        return describe_exchange(p.exchange, link, outcome, system.fall_count(p) == 0)
    if kind == Guard.TWIST:
        return "the rope is twisted by almost a turn", "change what turns the payload, or rope.torsion.stiffness"
    if kind == Guard.LINK and system.fall_count(p) > 0:
        what = f"link {link + 1}" if link else "the rope over the sheaves"
        what = "a fall of the reeving" if link >= len(p.cable.masses) else what
        return f"{what} went slack", "change what moves rope or base, or take elastic `falls`, which can go slack"
    if kind == Guard.LINK and link > 0:
        return (
            f"link {link + 1} went slack, and a rigid link must be taut",
            "take rope.slack: allow if the links are rods",
        )
    return describe_stop(p.support, p.stops or Stops(), number)
