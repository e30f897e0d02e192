"""Impacts of a rigid contact: a load whose velocities jump where a point comes down.

All points that touch take part, by Poisson's law in two phases (F. Pfeiffer, Ch. Glocker: Multibody
Dynamics with Unilateral Contacts, 1996). Compression ends with no point approaching: its normal
impulses Λ ≥ 0 stop those that would. Expansion gives each point at least e Λ, more where it would
approach again. In both phases the tangential impulses are Coulomb's, |T| ≤ μ Λ, against the slip
that remains. Impulses are found by Gauss-Seidel sweeps over the points.

An approach no faster than the rest velocity has no expansion, nor has one after which energy would
have been gained, relative to the surface: with friction, Poisson's law does not exclude it. Points
that do not part then are closed, and what is left of their velocities is taken by the impulse that
needs the least energy.
"""

from math import sqrt

import numpy as np

from crane_sim.models.contact.rigid import NONE, closed_count, closing_forces, turn_of
from crane_sim.models.contact.surface import Wrench, add_force, contact_point, wrench_power
from crane_sim.models.moving_base import rotate_to_base
from crane_sim.multibody.vectors import add, cross, dot, multiply, scale
from crane_sim.numerics.jit import routine

NEAR = 1e-9  # m: a point takes part in an impact of another one below this gap
SWEEPS = 20_000  # at most
# change of a point's velocity in a sweep, relative to the largest before the phase
CONVERGED = 1e-15
PARTS = 1e-3  # of the rest velocity: a point that leaves more slowly is closed


def after_impulse(load, state, wrench):
    """Return the BodyState of the load after a wrench of impulses."""
    omega = add(state.omega, rotate_to_base(state.rows, turn_of(load, state, wrench.moment)))
    velocity = add(state.velocity, scale(1.0 / load.mass, wrench.force))
    return state._replace(velocity=velocity, omega=omega)


def mobility(load, state, lever, direction):
    """Return the mobility [1/kg] of a load's point along a unit vector, both in base axes."""
    arm = cross(lever, direction)
    return 1.0 / load.mass + dot(arm, turn_of(load, state, arm))


def relax_point(contact, load, point, state, impulses, i, least):
    """Correct the impulses (n, 3) of one point for its velocity; return the changes of both.

    They are the change (3,) of the impulses, and that of the velocity.
    """
    normal = mobility(load, state, point.lever, (0.0, 0.0, 1.0))
    along = mobility(load, state, point.lever, (1.0, 0.0, 0.0)) + mobility(
        load, state, point.lever, (0.0, 1.0, 0.0)
    )
    (x, y, z), (vx, vy, vz) = (impulses[i, 0], impulses[i, 1], impulses[i, 2]), point.velocity
    up = max(least, z - vz / normal)
    tx, ty, most = x - vx / along, y - vy / along, contact.surface.friction * up
    size = sqrt(tx * tx + ty * ty)
    if size > most:
        tx, ty = tx * most / size, ty * most / size
    impulses[i, 0], impulses[i, 1], impulses[i, 2] = tx, ty, up
    change = tx - x, ty - y, up - z
    return change, max(abs(change[2]) * normal, max(abs(change[0]), abs(change[1])) * along)


@routine
def relax(contact, load, moved, state, impulses, least, touching):
    """Return (BodyState after the impulses of one phase, their Wrench).

    Args:
        contact, load, moved, state: parameters, Displacement of the surface, BodyState before.
        impulses: (n, 3) to fill.
        least: (n,) normal impulses that are given in any case.
        touching: (n,) whether each point takes part.
    """
    total, fastest = NONE, 0.0
    impulses[:] = 0.0
    for i in range(len(touching)):
        if touching[i]:
            vx, vy, vz = contact_point(contact, i, moved, state).velocity
            fastest = max(fastest, max(abs(vz), max(abs(vx), abs(vy))))
    now, sweep, change = state, 0, 1e300
    while sweep < SWEEPS and change > CONVERGED * fastest:
        change, sweep = 0.0, sweep + 1
        for i in range(len(touching)):
            if touching[i]:
                point = contact_point(contact, i, moved, now)
                more, jump = relax_point(contact, load, point, now, impulses, i, least[i])
                total = add_force(total, 1.0, point.lever, more)
                now, change = after_impulse(load, state, total), max(change, jump)
    return now, total


def sum_wrenches(a, b):
    """Return the sum of two wrenches."""
    return Wrench(add(a.force, b.force), add(a.moment, b.moment))


def impulse_work(wrench, before, after, velocity):
    """Return the work [J] of impulses on a load, relative to axes with a velocity (3,)."""
    work = 0.5 * (wrench_power(wrench, before) + wrench_power(wrench, after))
    return work - dot(wrench.force, velocity)


@routine
def collide(contact, load, moved, state, touching):
    """Return (BodyState, Wrench of impulses) of an impact; arguments of `relax`."""
    n, approach = len(touching), 0.0
    impulses, least = np.zeros((n, 3)), np.zeros(n)
    for i in range(n):
        if touching[i]:
            approach = max(approach, -contact_point(contact, i, moved, state).velocity[2])
    pressed, compression = relax(contact, load, moved, state, impulses, least, touching)
    if contact.restitution == 0.0 or approach <= contact.rest_velocity:
        return pressed, compression
    for i in range(n):
        least[i] = contact.restitution * impulses[i, 2]
    after, expansion = relax(contact, load, moved, pressed, impulses, least, touching)
    total = sum_wrenches(compression, expansion)
    if impulse_work(total, state, after, moved.velocity) > 0.0:
        return pressed, compression
    return after, total


@routine
def settle(contact, load, x, first, moved, state):
    """Return (BodyState, Wrench of impulses) after the closed points' velocities are taken away."""
    if closed_count(contact, x, first) == 0:
        return state, NONE
    omega = multiply(state.rows, state.omega)
    lift = state.velocity[2] - moved.velocity[2], omega[0], omega[1]
    normal_forces = closing_forces(contact, load, x, first, (moved, state), lift, 0.0)
    return after_impulse(load, state, normal_forces.wrench), normal_forces.wrench
