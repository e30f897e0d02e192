"""Outputs of a crane with elastic falls: joint coordinates, falls_energies, tensions, points, and its events.

Joint coordinates are the support's, the falls' common length where a winch changes it, the position of the load's
centre of mass in the axes of the base, and its attitude, a quaternion (w, x, y, z).
"""

import numpy as np

from crane_sim import system
from crane_sim.models.contact.forces import count_contact_modes
from crane_sim.models.falls.contact_events import (
    contact_guard,
    describe_contact,
    fill_contact,
    switch_contact,
    total_normal_force,
)
from crane_sim.models.falls.crane import (
    FallsCrane,
    body_state,
    fall_state,
    kinematics_of,
    solve_dynamics,
    sum_falls,
    taut_fall,
)
from crane_sim.models.falls.load_exchange import apply_exchange, describe_body_exchange
from crane_sim.models.guards import LOWER, TAUT, Guard, decode, encode, smaller_guard
from crane_sim.models.moving_base import pose_at, to_world
from crane_sim.models.stops import Stops, describe_length_event, describe_stop, length_guard
from crane_sim.models.supports.backlash import describe_drive
from crane_sim.models.supports.hoist import hoist_modes, hoist_reflected_mass
from crane_sim.models.supports.joint_modes import any_joint_sticks, initialize_modes, sticking_guard, support_guard
from crane_sim.models.supports.reeved_hoist import winch_energy
from crane_sim.models.supports.support import (
    compute_posture,
    drive_count,
    friction_state_count,
    polyline_size,
    read_state,
    to_joint_order,
)
from crane_sim.models.suspended.exchange import count_exchanges, exchange_guard, load_of
from crane_sim.models.suspended.joints import fill_coordinates
from crane_sim.models.suspended.layout import contact_index, layout_of, rope_length, winch_index
from crane_sim.models.suspended.load_dynamics import align_quaternion, kinetic_energy, load_base_energy
from crane_sim.models.suspended.outputs import support_added_energy, support_energies, write_polyline
from crane_sim.models.suspended.winch import smallest_winch_guard
from crane_sim.models.wind_kink import pressed_point, pressed_point_of
from crane_sim.numerics.jit import routine

system.contact_force.register(FallsCrane)(total_normal_force)


@system.project_in_place.register(FallsCrane)
@routine
def normalise(p, x):
    """Give the quaternion its length 1, and take from its rates what is not across it."""
    nq, first, _ = layout_of(p)
    align_quaternion(x, first + 3, nq + first + 3)


@system.joints.register(FallsCrane)
def joint_arrays(p, x):
    """Return (q, v), arrays (nj,)."""
    nq, _, _ = layout_of(p)
    return to_joint_order(p.support, x[:nq]), to_joint_order(p.support, x[nq : 2 * nq])


@system.state.register(FallsCrane)
def initial_state(p, t, q, v):
    """Return the state, an array, with the modes that follow from positions and velocities."""
    nq, _, _ = layout_of(p)
    others = count_contact_modes(p.contact) + drive_count(p.support) + friction_state_count(p.support)
    x = np.zeros(contact_index(p) + others)
    fill_coordinates(p, x, q, v)
    count_exchanges(p, t, x)
    initialize_fall_modes(p, x)
    if hoist_modes(p.hoist) > 0:
        x[winch_index(p)] = np.sign(rope_length(p, x)[1])
    fill_contact(p, t, x)
    initialize_modes(p.support, x, read_state(p.support, x, nq))
    return x


@routine
def initialize_fall_modes(p, x):
    """Set each fall's mode to that of its elongation."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        x[modes + i] = 1.0 if min(fall.spring, fall.tension) > 0.0 else 0.0


@system.acceleration.register(FallsCrane)
def joint_accelerations(p, t, x, u):
    """Return the second derivatives (nj,) of the joint coordinates."""
    nq, _, _ = layout_of(p)
    return to_joint_order(p.support, system.rhs(p, t, x, u)[nq : 2 * nq])


@system.link_count.register(FallsCrane)
def count_links(p):
    """Return the number of falls."""
    return len(p.falls.offset)


@system.tensions.register(FallsCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all falls [N]."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for k in range(len(p.falls.offset)):
        fall = taut_fall(p.contact, fall_state(p.falls, k, *kinematics))
        rows[i, first + k] = x[modes + k] * fall.tension


@routine
def falls_energies(p, base, x):
    """Return (kinetic, potential) energy [J] relative to the base, and those that it adds; base: BaseState or None."""
    (_, _, modes), kinematics, body = layout_of(p), kinematics_of(p, x), load_of(p, x)
    pose, _, load, (length, rate) = kinematics
    wound, _ = winch_energy(p.hoist, length, rate, p.gravity)
    moving, sprung = support_energies(p.support, pose, p.gravity)
    kinetic = moving + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate + wound
    kinetic += kinetic_energy(body, load)
    potential = sprung + body.mass * p.gravity * load.position[2]
    for i in range(len(p.falls.offset)):
        spring, rest = fall_state(p.falls, i, *kinematics).spring, length + p.falls.offset[i]
        potential += x[modes + i] * 0.5 * spring * spring * rest / p.falls.axial_stiffness[i]
    first, second = support_added_energy(base, pose, p.gravity), load_base_energy(base, body, load, p.gravity)
    return kinetic, potential, first[0] + second[0], first[1] + second[1]


@system.point_count.register(FallsCrane)
def count_points(p):
    """Return the number of points of support and load."""
    return polyline_size(p.support) + 1


@system.points.register(FallsCrane)
def write_points(p, t, x, out):
    """Write support and load in the world into out (N, 3)."""
    (nq, first, _), base = layout_of(p), pose_at(p.base, t)
    i = write_polyline(compute_posture(p.support, read_state(p.support, x, nq)), base, out)
    out[i, 0], out[i, 1], out[i, 2] = to_world(base, (x[first], x[first + 1], x[first + 2]))


@pressed_point.register(FallsCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    return pressed_point_of(load_of(p, x), body_state(p, x))


@system.guard.register(FallsCrane)
def smallest_guard(p, t, x, u, work):
    """Return (the smallest guard, its number, evaluations): falls, support, winch, exchanges and contact."""
    best = exchange_guard(p, falls_guard(p, x), t, x)
    best, n = sticking_joints_guard(p, t, x, u, best)
    value, number, more = contact_guard(p, t, x, reeved_guard(p, t, x, u, best))
    return value, number, n + more


@routine
def reeved_guard(p, t, x, u, best):
    """Return the smaller one of `best` and the guard of the winch's stick and slip."""
    if hoist_modes(p.hoist) == 0:
        return best
    pull = sum_falls(p, x, *kinematics_of(p, x)).paid
    return smallest_winch_guard(p, best, x, system.effort(u, p, t, x), pull)


@routine
def sticking_joints_guard(p, t, x, u, best):
    """Return (guard, evaluations): the smallest one of `best` and of the guards of joints that friction holds."""
    if not any_joint_sticks(p.support, read_state(p.support, x, layout_of(p)[0])):
        return best, 0
    solved = solve_dynamics(p, t, x, system.effort(u, p, t, x))
    return sticking_guard(p.support, best, solved.pose.state, solved), 1


@routine
def falls_guard(p, x):
    """Return the smallest guard and its number: taut and slack falls, and the stops of a run."""
    (_, _, modes), best, kinematics = layout_of(p), stops_guard(p, x), kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        value = fall.tension if x[modes + i] > 0.0 else -min(fall.spring, fall.tension)
        best = smaller_guard(best, value, encode(Guard.LINK, i))
    return best


def stops_guard(p, x):
    """Return the smallest guard of what ends a run: the limits of the support and of the falls' length."""
    if p.stops is None:
        return 1e300, encode(Guard.LENGTH, LOWER)
    best = length_guard(p.stops, *rope_length(p, x))
    return support_guard(p.support, best, read_state(p.support, x, layout_of(p)[0]))


def switch(p, t, x, number):
    """Return (state after an event of contact, load or falls, the event, whether the run goes on)."""
    kind, _, _ = decode(number)
    if p.contact is not None and kind == Guard.CONTACT:
        return switch_contact(p, t, x, number)
    if p.exchange is not None and kind == Guard.PAYLOAD:
        return apply_exchange(p, t, x)
    return switch_fall(p, x, number)


@routine
def switch_fall(p, x, number):
    """Return (the state with the fall's other mode, the event, whether the run goes on)."""
    nq, _, modes = layout_of(p)
    kind, i, _ = decode(number)
    if kind != Guard.LINK:
        return x, number, False
    y = x.copy()
    y[modes + i] = 1.0 - x[modes + i]
    if modes > 2 * nq:  # a slack rope loses what its spring held against the damper
        y[2 * nq] += falls_energies(p, None, y)[1] - falls_energies(p, None, x)[1]
    return y, encode(Guard.LINK, i, int(y[modes + i])), True


@system.describe_event.register(FallsCrane)
def describe_event(p, number):
    """Return texts (what an event was, what a user can change)."""
    kind, i, outcome = decode(number)
    if kind == Guard.BACKLASH:
        return describe_drive(p.support, i, outcome), ""
    if kind == Guard.LINK:
        return f"fall {i + 1} {'pulls' if outcome == TAUT else 'went slack'}", ""
    if kind == Guard.CONTACT:
        return describe_contact(p.contact, i, outcome), ""
    if kind == Guard.PAYLOAD and p.exchange is not None:
        return describe_body_exchange(p, i, outcome)
    if kind == Guard.LENGTH:
        return describe_length_event(
            "shortest fall" if i == LOWER else "falls' rope", "hoist", i, (p.stops or Stops()).shortest
        )
    return describe_stop(p.support, p.stops or Stops(), number)
