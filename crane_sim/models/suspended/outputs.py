"""Outputs of a suspended crane: suspended_energies, tensions, points, efforts; and the stops that end its runs."""

from crane_sim import system
from crane_sim.models.attitude import align_quaternion
from crane_sim.models.cables.chain_3d import align
from crane_sim.models.energy_meter import Meter
from crane_sim.models.guards import Guard, decode, encode, friction_event, smaller_guard
from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import added_energy, base_state, pose_at, to_world
from crane_sim.models.stops import WINCH, Stops, describe_stop, length_guard
from crane_sim.models.supports.backlash import describe_drive, drive_energies, mean_of_drives
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.hoist import MotionHoist, PrescribedHoist, hoist_entry, hoist_reflected_mass, limit_hoist
from crane_sim.models.supports.joint_modes import (
    any_joint_sticks,
    friction_state_index,
    mode_after_guard,
    sticking_guard,
    support_guard,
    with_support_switching,
)
from crane_sim.models.supports.reeved_hoist import ReevedHoist, winch_energy
from crane_sim.models.supports.support import (
    bare_tip,
    compute_dynamics,
    compute_posture,
    coordinate_count,
    energy_by_base,
    kinetic_energy,
    own_count,
    polyline,
    polyline_size,
    potential_energy,
    read_state,
    takes_energy,
    yaw,
)
from crane_sim.models.suspended.crane import (
    SuspendedCrane,
    fill_directions,
    first_length,
    next_node,
    solve_dynamics,
    suspended_layout,
    suspended_power,
)
from crane_sim.models.suspended.exchange import (
    current_load,
    describe_exchange,
    exchange_guard,
    with_exchange_switching,
)
from crane_sim.models.suspended.impulses import exchange_load
from crane_sim.models.suspended.load_dynamics import load_base_energy, load_state, turning_energy
from crane_sim.models.suspended.torsion import MAX_TWIST, ZERO, Torsion, add_twist_energy, twist_motion, twist_of
from crane_sim.models.suspended.winch import (
    after_winch_guard,
    fall_guard,
    suspended_winch_guard,
    winch_sticks,
    winch_switching,
)
from crane_sim.models.wind_kink import pressed_point, pressed_point_of, wind_kink_guard, with_kink_switching
from crane_sim.numerics.jit import generic, routine


@system.project.register(SuspendedCrane)
def _(p, x):
    straighten(p, x)
    return x


@system.project_in_place.register(SuspendedCrane)
def _(p, x):
    straighten(p, x)


@routine
def straighten(p, x):
    """Give unit vectors and quaternion their length 1, and take from their rates what is not across them."""
    nq, first, _ = suspended_layout(p)
    for i in range(first, first + 3 * len(p.cable.masses), 3):
        (x[i], x[i + 1], x[i + 2]), (x[nq + i], x[nq + i + 1], x[nq + i + 2]) = align(x, i, nq + i)
    normalise_attitude(p.load, x, nq)


@generic
def normalise_attitude(load, x, nq):
    """Put the load's own coordinates back on what they hold."""


@normalise_attitude.register(RigidLoad)
def _(load, x, nq):
    i, v = nq - 4, 2 * nq - 4
    (x[i], x[i + 1], x[i + 2], x[i + 3]), (x[v], x[v + 1], x[v + 2], x[v + 3]) = align_quaternion(x, i, v)


@system.link_count.register(SuspendedCrane)
def _(p):
    return len(p.cable.masses)


@system.tensions.register(SuspendedCrane)
def _(p, t, x, u, rows, i, first):
    work = system.workspace(p)
    solve_dynamics(p, t, x, system.effort(u, p, t, x), work)
    for k in range(len(work.tension)):
        rows[i, first + k] = work.tension[k]


@system.power.register(SuspendedCrane)
def _(p, t, x, u):
    work = system.workspace(p)
    return suspended_power(p, t, x, solve_dynamics(p, t, x, system.effort(u, p, t, x), work), work)


@routine
def suspended_energies(p, base, x):
    """Return (kinetic, potential) energy [J] relative to the base, and those that it adds in the world.

    Args:
        p: the crane.
        base: of `base_state` in its own axes, None at rest.
        x: state.
    """
    nq, _, end = suspended_layout(p)
    body = current_load(p.exchange, p.load, x, end)
    links, (_, rate) = system.workspace(p).links, first_length(p.hoist, p, x, nq)
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
            mass, (_, _, z), (vx, vy, vz) = p.cable.masses[k], node[0], node[1]
            kinetic += 0.5 * mass * (vx * vx + vy * vy + vz * vz)
            potential += mass * p.gravity * z
            more = mass_added_energy(base, p.gravity, mass, node)
            added = added[0] + more[0], added[1] + more[1]
    load = load_state(body, x, nq, node)
    (vx, vy, vz), more = load.velocity, load_base_energy(base, body, load, p.gravity)
    kinetic += 0.5 * body.mass * (vx * vx + vy * vy + vz * vz) + turning_energy(body, load)
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


@generic
def mass_added_energy(base, gravity, mass, node):
    """Return (kinetic, potential) energy [J] that a moving base adds to a mass at a node (position, velocity)."""
    return added_energy(base, gravity, mass, node[0], node[1])


@mass_added_energy.register(type(None))
def _(base, gravity, mass, node):
    return 0.0, 0.0


@system.kinetic.register(SuspendedCrane)
def _(p, x):
    return suspended_energies(p, None, x)[0]


@system.potential.register(SuspendedCrane)
def _(p, x):
    return suspended_energies(p, None, x)[1]


@system.base_energy.register(SuspendedCrane)
def _(p, t, x):
    _, _, kinetic, potential = suspended_energies(p, base_state(p.base, t, 0.0), x)
    return kinetic, potential


@system.point_count.register(SuspendedCrane)
def _(p):
    return polyline_size(p.support) + len(p.cable.masses)


@system.tip_index.register(SuspendedCrane)
def _(p):
    return polyline_size(p.support) - 1


@system.points.register(SuspendedCrane)
def _(p, t, x, out):
    write_points(p, t, x, out)


@routine
def write_points(p, t, x, out):
    """Write support, nodes and the load's attachment in the world into out (N, 3)."""
    nq, _, _ = suspended_layout(p)
    links, base, (_, rate) = system.workspace(p).links, pose_at(p.base, t), first_length(p.hoist, p, x, nq)
    fill_directions(p, x, links)
    state, i = read_state(p.support, x, nq), 0
    for point in polyline(p.support, state):
        out[i, 0], out[i, 1], out[i, 2] = to_world(base, point)
        i += 1
    node = bare_tip(compute_posture(p.support, state))
    for k in range(len(links.squared_rates)):
        node = next_node(links, k, rate, node)
        out[i + k, 0], out[i + k, 1], out[i + k, 2] = to_world(base, node[0])


def support_entries(support, row, i):
    """Return the entries, from row[i] on, of the support's actuated joints, as a tuple."""
    entries = tuple(row[i + k] for k in support.structure.mechanism().actuated)
    return mean_of_drives(support.drives, row, i, entries, own_count(support))


def effort_entries(support, row):
    """Return the support's entries of a row of efforts, as a tuple."""
    return tuple(row[k] for k in range(len(support.structure.mechanism().actuated)))


@system.actuated_joints.register(SuspendedCrane)
def _(p, x):
    (nq, _, _), i = suspended_layout(p), coordinate_count(p.support)
    q = (*support_entries(p.support, x, 0), *hoist_entry(p.hoist, x, i))
    return q, (*support_entries(p.support, x, nq), *hoist_entry(p.hoist, x, nq + i))


@system.efforts_from_row.register(SuspendedCrane)
def _(p, row):
    support = effort_entries(p.support, row)
    return (*support, *hoist_entry(p.hoist, row, len(support)))


@system.saturate.register(SuspendedCrane)
def _(p, u):
    return limit_hoist(p.hoist, u)


@system.with_meter.register(SuspendedCrane)
def _(p, held):
    lossy = p.drag is not None or p.force is not None or p.wind is not None or p.exchange is not None
    lossy = lossy or takes_energy(p.support) or p.torsion is not None
    imposed = isinstance(p.hoist, PrescribedHoist | MotionHoist | ReevedHoist)
    imposed = imposed or isinstance(p.support.structure, DrivenPoint) or p.base is not None
    return p._replace(energy_meter=Meter()) if lossy or imposed or not held else p


@system.energy_supplied.register(SuspendedCrane)
def _(p, x):
    nq, _, end = suspended_layout(p)
    return x[2 * nq] if end > 2 * nq else 0.0


@system.switching.register(SuspendedCrane)
def _(p):
    switching = with_support_switching(p.support, winch_switching(p.hoist, p.stops))
    return with_kink_switching(p.wind, with_exchange_switching(p.exchange, switching))


@system.kink_guard.register(SuspendedCrane)
def _(p, value, t0, x0, t, x):
    return wind_kink_guard(p.wind, p, value, t0, x0, t, x)


@pressed_point.register(SuspendedCrane)
def _(p, x):
    nq, first, end = suspended_layout(p)
    pose, body = compute_posture(p.support, read_state(p.support, x, nq)), current_load(p.exchange, p.load, x, end)
    (px, py, pz), (length, _) = bare_tip(pose)[0], first_length(p.hoist, p, x, nq)
    for k in range(len(p.cable.masses)):
        length, i = length if k == 0 else p.cable.lengths[k], first + 3 * k
        px, py, pz = px + length * x[i], py + length * x[i + 1], pz + length * x[i + 2]
    return pressed_point_of(body, load_state(body, x, nq, ((px, py, pz), (0.0, 0.0, 0.0))))


@system.guard.register(SuspendedCrane)
def _(p, t, x, u, work):
    return suspended_guard(p, t, x, u, work)


@routine
def suspended_guard(p, t, x, u, work):
    """Return (the smallest guard, its number, evaluations): limits of support and first length, slack links."""
    nq, _, end = suspended_layout(p)
    (length, rate), stops, acceleration = first_length(p.hoist, p, x, nq), p.stops, 0.0
    best = exchange_guard(p.exchange, length_guard(stops, length, rate), t, x, end)
    xs, tau = read_state(p.support, x, nq), system.effort(u, p, t, x)
    best = support_guard(p.support, best, xs)
    best = twist_guard(p.torsion, best, p, x, work.links)
    forces = stops.taut > 0.0 or winch_sticks(p, x) or any_joint_sticks(p.support, xs)
    if forces:
        solved = solve_dynamics(p, t, x, tau, work)
        acceleration = solved.length
        best = sticking_guard(p.support, best, solved.pose.state, solved)
    if stops.taut > 0.0:
        for k in range(len(work.tension)):
            best = smaller_guard(best, work.tension[k], encode(Guard.LINK, k))
        best = fall_guard(p.hoist, best, p, x, (length, rate, acceleration), work.tension)
    value, number = suspended_winch_guard(p, best, x, tau, work.tension)
    return value, number, int(forces)


@generic
def twist_guard(torsion, best, p, x, links):
    """Return the smaller one of `best` and the guard of the rope's twist; `links` is filled."""
    return best


@twist_guard.register(Torsion)
def _(torsion, best, p, x, links):
    nq, _, _ = suspended_layout(p)
    fill_directions(p, x, links)
    load = load_state(p.load, x, nq, (ZERO, ZERO))
    twist, _ = twist_motion(links, load, yaw(p.support, read_state(p.support, x, nq).q), 0.0)
    return smaller_guard(best, MAX_TWIST - abs(twist), encode(Guard.TWIST, 0))


@system.apply_reset_map.register(SuspendedCrane)
def _(p, t, x, u, number):
    kind, joint, _ = decode(number)
    if kind == Guard.FRICTION:
        tau = system.effort(u, p, t, x)
        x, number = after_winch_guard(p, t, x, tau) if joint == WINCH else after_joint_guard(p, t, x, tau, joint)
        return x, number, True
    return exchange_load(p.exchange, p, t, x, number)


@routine
def after_joint_guard(p, t, x, tau, joint):
    """Return (state, number of the event) after the guard of the friction of a support's joint has failed."""
    nq, _, _ = suspended_layout(p)
    x, k, work = x.copy(), friction_state_index(p.support, x, joint), system.workspace(p)
    mode_before = x[k]
    x[nq + joint], x[k] = (0.0 if mode_before != 0.0 else x[nq + joint]), 0.0
    solved = solve_dynamics(p, t, x, tau, work)
    x[k] = mode_after_guard(p.support, joint, mode_before, solved)
    return x, friction_event(joint, x[k])


@system.describe_event.register(SuspendedCrane)
def _(p, number):
    kind, link, outcome = decode(number)
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
