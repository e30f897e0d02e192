"""Outputs of a crane with elastic falls: joint coordinates, falls_energies, tensions, points, and its events.

Joint coordinates are the support's, the falls' common length where a winch changes it, the position of the load's
centre of mass in the axes of the base, and its attitude, a quaternion (w, x, y, z).
"""

import numpy as np

from crane_sim import system
from crane_sim.models.attitude import align_quaternion
from crane_sim.models.contact.forces import count_contact_modes
from crane_sim.models.energy_meter import Meter
from crane_sim.models.falls.contact_events import (
    contact_guard,
    describe_contact,
    fill_contact,
    switch_contact,
    total_normal_force,
)
from crane_sim.models.falls.crane import (
    FallsCrane,
    body_of,
    body_state,
    common_length,
    contact_index,
    exchange_index,
    fall_state,
    falls_layout,
    falls_power,
    kinematics_of,
    solve_dynamics,
    taut_fall,
    winch_index,
)
from crane_sim.models.falls.load_exchange import describe_body_exchange, exchange_body
from crane_sim.models.falls.winch import after_friction_guard, falls_winch_guard
from crane_sim.models.guards import LOWER, TAUT, Guard, decode, encode, smaller_guard
from crane_sim.models.moving_base import base_state, pose_at, to_world
from crane_sim.models.stops import Stops, describe_length_event, describe_stop, length_guard
from crane_sim.models.supports.backlash import describe_drive
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.friction import friction_of, step_control_of
from crane_sim.models.supports.hoist import (
    MotionHoist,
    PrescribedHoist,
    hoist_entry,
    hoist_modes,
    hoist_reflected_mass,
    limit_hoist,
)
from crane_sim.models.supports.joint_modes import (
    any_joint_sticks,
    initialize_modes,
    sticking_guard,
    support_guard,
    switch_drive,
    with_support_switching,
)
from crane_sim.models.supports.reeved_hoist import ReevedHoist, winch_energy
from crane_sim.models.supports.support import (
    coordinate_count,
    drive_count,
    friction_state_count,
    polyline,
    polyline_size,
    read_state,
    takes_energy,
    to_coordinate_order,
    to_joint_order,
)
from crane_sim.models.suspended.exchange import count_exchanges, exchange_guard, with_exchange_switching
from crane_sim.models.suspended.load_dynamics import load_base_energy, turning_energy
from crane_sim.models.suspended.outputs import effort_entries, support_added_energy, support_energies, support_entries
from crane_sim.models.wind_kink import pressed_point, pressed_point_of, wind_kink_guard, with_kink_switching
from crane_sim.numerics.jit import generic, routine
from crane_sim.system import EVENT_LOG_CAPACITY, Switching


@system.project.register(FallsCrane)
def _(p, x):
    normalise(p, x)
    return x


@system.project_in_place.register(FallsCrane)
def _(p, x):
    normalise(p, x)


@routine
def normalise(p, x):
    """Give the quaternion its length 1, and take from its rates what is not across it."""
    nq, first, _ = falls_layout(p)
    i, v = first + 3, nq + first + 3
    (x[i], x[i + 1], x[i + 2], x[i + 3]), (x[v], x[v + 1], x[v + 2], x[v + 3]) = align_quaternion(x, i, v)


@system.joints.register(FallsCrane)
def _(p, x):
    nq, _, _ = falls_layout(p)
    return to_joint_order(p.support, x[:nq]), to_joint_order(p.support, x[nq : 2 * nq])


@system.state.register(FallsCrane)
def _(p, t, q, v):
    nq, _, _ = falls_layout(p)
    x = np.zeros(
        contact_index(p) + count_contact_modes(p.contact) + drive_count(p.support) + friction_state_count(p.support)
    )
    positions, rates = to_coordinate_order(p.support, q), to_coordinate_order(p.support, v)
    for i in range(nq):
        x[i], x[nq + i] = positions[i], rates[i]
    count_exchanges(p.exchange, t, x, exchange_index(p))
    initialize_fall_modes(p, x)
    if hoist_modes(p.hoist) > 0:
        x[winch_index(p)] = np.sign(x[nq + coordinate_count(p.support)])
    fill_contact(p.contact, p, t, x)
    initialize_modes(p.support, x, read_state(p.support, x, nq))
    return x


@routine
def initialize_fall_modes(p, x):
    """Set each fall's mode to that of its elongation."""
    (_, _, modes), kinematics = falls_layout(p), kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        x[modes + i] = 1.0 if min(fall.spring, fall.tension) > 0.0 else 0.0


@system.acceleration.register(FallsCrane)
def _(p, t, x, u):
    nq, _, _ = falls_layout(p)
    return to_joint_order(p.support, system.rhs(p, t, x, u)[nq : 2 * nq])


@system.link_count.register(FallsCrane)
def _(p):
    return len(p.falls.offset)


@system.tensions.register(FallsCrane)
def _(p, t, x, u, rows, i, first):
    (_, _, modes), kinematics = falls_layout(p), kinematics_of(p, x)
    for k in range(len(p.falls.offset)):
        fall = taut_fall(p.contact, fall_state(p.falls, k, *kinematics))
        rows[i, first + k] = x[modes + k] * fall.tension


@system.contact_force.register(FallsCrane)
def _(p, t, x):
    return total_normal_force(p.contact, p, t, x)


@system.power.register(FallsCrane)
def _(p, t, x, u):
    return falls_power(p, t, x, solve_dynamics(p, t, x, system.effort(u, p, t, x)))


@routine
def falls_energies(p, base, x):
    """Return (kinetic, potential) energy [J] relative to the base, and those that it adds; base: BaseState or None."""
    nq, _, modes = falls_layout(p)
    kinematics = kinematics_of(p, x)
    pose, _, load, (length, rate) = kinematics
    (vx, vy, vz), body = load.velocity, body_of(p, x)
    m = body.mass
    wound, _ = winch_energy(p.hoist, length, rate, p.gravity)
    moving, sprung = support_energies(p.support, pose, p.gravity)
    kinetic = moving + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate + wound
    kinetic += 0.5 * m * (vx * vx + vy * vy + vz * vz) + turning_energy(body, load)
    potential = sprung + m * p.gravity * load.position[2]
    for i in range(len(p.falls.offset)):
        spring, rest = fall_state(p.falls, i, *kinematics).spring, length + p.falls.offset[i]
        potential += x[modes + i] * 0.5 * spring * spring * rest / p.falls.axial_stiffness[i]
    first, second = support_added_energy(base, pose, p.gravity), load_base_energy(base, body, load, p.gravity)
    return kinetic, potential, first[0] + second[0], first[1] + second[1]


@system.kinetic.register(FallsCrane)
def _(p, x):
    return falls_energies(p, None, x)[0]


@system.potential.register(FallsCrane)
def _(p, x):
    return falls_energies(p, None, x)[1]


@system.base_energy.register(FallsCrane)
def _(p, t, x):
    _, _, kinetic, potential = falls_energies(p, base_state(p.base, t, 0.0), x)
    return kinetic, potential


@system.point_count.register(FallsCrane)
def _(p):
    return polyline_size(p.support) + 1


@system.tip_index.register(FallsCrane)
def _(p):
    return polyline_size(p.support) - 1


@system.points.register(FallsCrane)
def _(p, t, x, out):
    nq, first, _ = falls_layout(p)
    base, i = pose_at(p.base, t), 0
    for point in polyline(p.support, read_state(p.support, x, nq)):
        out[i, 0], out[i, 1], out[i, 2] = to_world(base, point)
        i += 1
    out[i, 0], out[i, 1], out[i, 2] = to_world(base, (x[first], x[first + 1], x[first + 2]))


@system.actuated_joints.register(FallsCrane)
def _(p, x):
    (nq, _, _), i = falls_layout(p), coordinate_count(p.support)
    q = (*support_entries(p.support, x, 0), *hoist_entry(p.hoist, x, i))
    return q, (*support_entries(p.support, x, nq), *hoist_entry(p.hoist, x, nq + i))


@system.efforts_from_row.register(FallsCrane)
def _(p, row):
    support = effort_entries(p.support, row)
    return (*support, *hoist_entry(p.hoist, row, len(support)))


@system.saturate.register(FallsCrane)
def _(p, u):
    return limit_hoist(p.hoist, u)


@system.with_meter.register(FallsCrane)
def _(p, held):
    lossy = p.drag is not None or p.force is not None or p.wind is not None or np.any(p.falls.relaxation)
    lossy = lossy or p.contact is not None or p.exchange is not None or takes_energy(p.support)
    imposed = isinstance(p.hoist, PrescribedHoist | MotionHoist | ReevedHoist)
    imposed = imposed or isinstance(p.support.structure, DrivenPoint) or p.base is not None
    return p._replace(energy_meter=Meter()) if lossy or imposed or not held else p


@system.energy_supplied.register(FallsCrane)
def _(p, x):
    nq, _, modes = falls_layout(p)
    return x[2 * nq] if modes > 2 * nq else 0.0


@system.switching.register(FallsCrane)
def _(p):
    switching = with_support_switching(
        p.support, Switching(EVENT_LOG_CAPACITY, 0, step_control_of(friction_of(p.hoist)))
    )
    return with_kink_switching(p.wind, with_exchange_switching(p.exchange, switching))


@system.kink_guard.register(FallsCrane)
def _(p, value, t0, x0, t, x):
    return wind_kink_guard(p.wind, p, value, t0, x0, t, x)


@pressed_point.register(FallsCrane)
def _(p, x):
    return pressed_point_of(body_of(p, x), body_state(p, x))


@system.guard.register(FallsCrane)
def _(p, t, x, u, work):
    best = exchange_guard(p.exchange, falls_guard(p, x), t, x, exchange_index(p))
    best, n = sticking_joints_guard(p, t, x, u, best)
    best = falls_winch_guard(p.hoist, best, p, t, x, u)
    value, number, more = contact_guard(p.contact, p, t, x, best)
    return value, number, n + more


@routine
def sticking_joints_guard(p, t, x, u, best):
    """Return (guard, evaluations): the smallest one of `best` and of the guards of joints that friction holds."""
    if not any_joint_sticks(p.support, read_state(p.support, x, falls_layout(p)[0])):
        return best, 0
    solved = solve_dynamics(p, t, x, system.effort(u, p, t, x))
    return sticking_guard(p.support, best, solved.pose.state, solved), 1


@routine
def falls_guard(p, x):
    """Return the smallest guard and its number: taut and slack falls, and the stops of a run."""
    nq, _, modes = falls_layout(p)
    best = stops_guard(p.stops, p, x, nq)
    kinematics = kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        value = fall.tension if x[modes + i] > 0.0 else -min(fall.spring, fall.tension)
        best = smaller_guard(best, value, encode(Guard.LINK, i))
    return best


@generic
def stops_guard(stops, p, x, nq):
    """Return the smallest guard of what ends a run: the limits of the support and of the falls' length."""
    return 1e300, encode(Guard.LENGTH, LOWER)


@stops_guard.register(Stops)
def _(stops, p, x, nq):
    length, rate = common_length(p.hoist, p, x, nq)
    best = length_guard(stops, length, rate)
    return support_guard(p.support, best, read_state(p.support, x, nq))


@system.apply_reset_map.register(FallsCrane)
def _(p, t, x, u, number):
    kind, joint, _ = decode(number)
    if kind == Guard.CONTACT:
        return switch_contact(p.contact, p, t, x, number)
    if kind == Guard.PAYLOAD:
        return exchange_body(p.exchange, p, t, x, number)
    if kind == Guard.FRICTION:
        x, number = after_friction_guard(p.hoist, p, t, x, system.effort(u, p, t, x), joint)
        return x, number, True
    return switch_fall(p, x, number)


@routine
def switch_fall(p, x, number):
    """Return (the state with the fall's other mode, the event, whether the model goes on)."""
    nq, _, modes = falls_layout(p)
    kind, i, _ = decode(number)
    if kind != Guard.LINK:
        return switch_drive(p.support, x, read_state(p.support, x, nq), number)
    y = x.copy()
    y[modes + i] = 1.0 - x[modes + i]
    if modes > 2 * nq:  # a slack rope loses what its spring held against the damper
        y[2 * nq] += falls_energies(p, None, y)[1] - falls_energies(p, None, x)[1]
    return y, encode(Guard.LINK, i, int(y[modes + i])), True


@system.describe_event.register(FallsCrane)
def _(p, number):
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
