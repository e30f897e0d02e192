"""Contact events of a load on falls: points touch, bounce, lift off; the load sticks and slips.

A point of a rigid contact touches where it is below the surface and comes nearer, by a little more
than rounding: one that has just lifted off, or bounced, is there without coming nearer. A compliant
one touches where its normal force would be positive.
"""

from typing import Any

import numpy as np

from crane_sim.models.carrier.exchange import load_of
from crane_sim.models.carrier.layout import contact_index, layout_of
from crane_sim.models.contact.forces import add_contact, compliant_normal_force, slipping_forces
from crane_sim.models.contact.impacts import (
    NEAR,
    PARTS,
    collide,
    impulse_work,
    settle,
    sum_wrenches,
)
from crane_sim.models.contact.rigid import (
    closed_count,
    holding_forces,
    is_closed,
    least_normal_force,
    normal_force_on,
    required_friction,
)
from crane_sim.models.contact.surface import (
    RigidContact,
    Wrench,
    contact_point,
    displacement_at,
    slip_speed,
)
from crane_sim.models.falls.crane import body_state, kinematics_of, load_acceleration, sum_falls
from crane_sim.models.guards import BOUNCES, LEAVES, TOUCHES, Guard, decode, encode, smaller_guard
from crane_sim.models.loads import coordinate_velocity
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.suspended.crane import load_force
from crane_sim.models.wind_load import airflow_at
from crane_sim.multibody.attitude import quaternion_rate
from crane_sim.multibody.vectors import ZERO, multiply, scale, subtract
from crane_sim.numerics.jit import routine

DEPTH, APPROACH = 1e-10, 1e-8  # m, m/s: beyond both of them a point touches
AT_REST = 1e-6  # m/s: a load that is given no deeper than NEAR and no faster is closed there
# part of the friction that may hold a load which comes to stick, so that it does not slip at once
GRIP = 0.99


@routine
def load_alone(p, t, x):
    """Return the load's accelerations without contact, see `load_acceleration`."""
    kinematics = kinematics_of(p, x)
    load, pull = kinematics[2], sum_falls(p, x, *kinematics)
    body, base = load_of(p, x), base_kinematics_at(p.base, p.gravity, t)
    given = load_force(p, body, t, airflow_at(p.wind, p.base, t, 0.0), base, load)
    return load_acceleration(p, body, base, load, pull, given)


def fill_contact(p, t, x):
    """Set the modes of contact in state x to those of positions and velocities."""
    contact, first = p.contact, contact_index(p)
    if contact is None:
        return
    load, moved, n = (
        body_state(p, x),
        displacement_at(contact.surface.motion, t),
        len(contact.points),
    )
    for i in range(n):
        x[first + i] = 1.0 if is_touching(contact, contact_point(contact, i, moved, load)) else 0.0
    if isinstance(contact, RigidContact):
        x[first + n] = 1.0 if slip_guard(p, t, x, (moved, load), load_alone(p, t, x)) < 0.0 else 0.0


def is_touching(contact, point):
    """Return whether a point of a load in a given state touches; on a rigid surface it rests."""
    if isinstance(contact, RigidContact):
        return point.gap <= NEAR and abs(point.velocity[2]) <= AT_REST
    return min(-point.gap, compliant_normal_force(contact, point)) > 0.0


def total_normal_force(p, t, x):
    """Return the normal force [N] on the load."""
    if p.contact is None:
        return 0.0
    load, free = body_state(p, x), load_alone(p, t, x)
    return add_contact(
        p.contact, load_of(p, x), t, x, contact_index(p), load, free
    ).normal_forces.wrench.force[2]


def contact_guard(p, t, x, best):
    """Return (value, number, evaluations) of the smaller one of `best` and the contact's guard.

    `best` is (value, number).
    """
    contact, first = p.contact, contact_index(p)
    if contact is None:
        return best[0], best[1], 0
    if isinstance(contact, RigidContact):
        return rigid_guard(p, t, x, best)
    load, moved = body_state(p, x), displacement_at(contact.surface.motion, t)
    for i in range(len(contact.points)):
        point = contact_point(contact, i, moved, load)
        normal_force = compliant_normal_force(contact, point)
        value = (
            normal_force
            if is_closed(x, first, i)
            else -min(-contact.stiffness * point.gap, normal_force)
        )
        best = smaller_guard(best, value, encode(Guard.CONTACT, i))
    return best[0], best[1], 0


@routine
def rigid_guard(p, t, x, best):
    """Return the result of `contact_guard` for a rigid contact."""
    contact, first, load, place, body = (
        p.contact,
        contact_index(p),
        body_state(p, x),
        0,
        load_of(p, x),
    )
    n, moved = len(contact.points), displacement_at(contact.surface.motion, t)
    for i in range(n):
        if not is_closed(x, first, i):
            point = contact_point(contact, i, moved, load)
            value = max(point.gap + DEPTH, point.velocity[2] + APPROACH)
            best = smaller_guard(best, value, encode(Guard.CONTACT, i))
    if closed_count(contact, x, first) == 0:
        return best[0], best[1], 0
    scene, free = (moved, load), load_alone(p, t, x)
    if is_closed(x, first, n):
        normal_forces = holding_forces(contact, body, x, first, scene, free)
        spare = (
            1.0
            - required_friction(contact, x, first, scene, normal_forces) / contact.surface.friction
        )
    else:
        normal_forces = slipping_forces(contact, body, x, first, scene, free)
        spare = slip_guard(p, t, x, scene, free)
    best = smaller_guard(best, spare, encode(Guard.CONTACT, n))
    for i in range(n):
        if is_closed(x, first, i):
            lever = contact_point(contact, i, moved, load).lever
            best = smaller_guard(
                best, normal_force_on(normal_forces, place, lever), encode(Guard.CONTACT, i)
            )
            place += 1
    return best[0], best[1], 1


def slip_guard(p, t, x, scene, free):
    """Return the guard of a load that slips: negative where it is slow and friction can hold it."""
    contact, first, fastest, surface = p.contact, contact_index(p), 0.0, p.contact.surface
    if closed_count(contact, x, first) < 3 or surface.friction == 0.0:
        return 1e300
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            fastest = max(fastest, slip_speed(contact_point(contact, i, scene[0], scene[1])))
    if fastest >= surface.slip_velocity:
        return fastest / surface.slip_velocity - 1.0
    forces = holding_forces(contact, load_of(p, x), x, first, scene, free)
    needed = required_friction(contact, x, first, scene, forces) / surface.friction - GRIP
    needed = max(needed, -least_normal_force(contact, x, first, scene, forces))
    return max(needed, fastest / surface.slip_velocity - 1.0)


def switch_contact(p, t, x, number):
    """Return (state after an event of contact, the event, whether the model goes on)."""
    (_, i, _), y, first = decode(number), x.copy(), contact_index(p)
    if isinstance(p.contact, RigidContact):
        return y, encode(Guard.CONTACT, i, switch_rigid(p, t, x, y, i)), True
    y[first + i] = 1.0 - x[first + i]
    return y, encode(Guard.CONTACT, i, TOUCHES if y[first + i] > 0.5 else LEAVES), True


def switch_rigid(p, t, x, y, i):
    """Change y, a copy of state x, by the event of rigid point i or of the slip.

    Return the outcome.
    """
    first, n = contact_index(p), len(p.contact.points)
    if i == n:
        outcome = LEAVES if is_closed(x, first, n) else TOUCHES
        y[first + n] = 1.0 - x[first + n]
        if outcome == TOUCHES:
            stop_slip(p, t, x, y)
    elif is_closed(x, first, i):
        outcome = LEAVES
        y[first + i] = 0.0
        if closed_count(p.contact, y, first) < 3:
            y[first + n] = 0.0
    else:
        strike(p, t, x, y)
        outcome = TOUCHES if is_closed(y, first, i) else BOUNCES
    return outcome


@routine
def stop_slip(p, t, x, y):
    """Give the load in y the velocity of the surface."""
    before, body, moved = (
        body_state(p, x),
        load_of(p, x),
        displacement_at(p.contact.surface.motion, t),
    )
    force = scale(body.mass, subtract(moved.velocity, before.velocity))
    moment = scale(-1.0, multiply(before.rows, multiply(body.inertia, before.omega)))
    after = before._replace(velocity=moved.velocity, omega=ZERO)
    write_jump(p, y, before, after, Wrench(force, moment))


@routine
def strike(p, t, x, y):
    """Give the load in y its velocities after an impact, and its points their modes."""
    contact, first, before, body = p.contact, contact_index(p), body_state(p, x), load_of(p, x)
    n, moved = len(contact.points), displacement_at(contact.surface.motion, t)
    touching = np.zeros(n)
    for i in range(n):
        if is_closed(x, first, i) or contact_point(contact, i, moved, before).gap <= NEAR:
            touching[i] = 1.0
    after, impulse = collide(contact, body, moved, before, touching)
    for i in range(n):
        parting = (
            contact_point(contact, i, moved, after).velocity[2] > PARTS * contact.rest_velocity
        )
        y[first + i] = 0.0 if parting else touching[i]
    y[first + n] = 0.0
    settled, rest = settle(contact, body, y, first, moved, after)
    write_jump(p, y, before, settled, sum_wrenches(impulse, rest))


@routine
def write_jump(p, y, before, after, impulse):
    """Write the load's velocities after a jump into y, and the impulses' work into the meter."""
    nq, first, modes = layout_of(p)
    i = nq + first
    y[i], y[i + 1], y[i + 2] = coordinate_velocity(after)
    y[i + 3], y[i + 4], y[i + 5], y[i + 6] = quaternion_rate(before.quaternion, after.omega)
    if modes > 2 * nq:
        y[2 * nq] += impulse_work(impulse, before, after, ZERO)


def describe_contact(contact: Any, point: int, outcome: int) -> str:
    """Return the text of an event of contact."""
    # or what it lets go
    place = "surface" if contact.surface.motion is None or contact.changes is not None else "deck"
    if point == len(contact.points):
        return f"the load {'sticks to' if outcome == TOUCHES else 'slips on'} the {place}"
    return f"contact point {point + 1} {('leaves', 'touches', 'bounces off')[outcome]} the {place}"
