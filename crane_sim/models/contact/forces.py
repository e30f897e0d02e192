"""Accelerations of a load under contact, rigid or compliant.

A compliant point presses with Hunt and Crossley's law for a linear spring, N = k δ (1 + c δ'), with
the depth δ below the surface (J. Appl. Mech. 42, 1975, 440-445): no jump at touch-down, and never a
pull, since the point is free from where 1 + c δ' has fallen to zero.
"""

from typing import Any, NamedTuple

from crane_sim.models.contact.rigid import (
    NONE,
    NormalForces,
    closed_count,
    closing_forces,
    holding_accelerations,
    holding_forces,
    is_closed,
    turn_of,
)
from crane_sim.models.contact.surface import (
    RigidContact,
    add_force,
    contact_point,
    displacement_at,
    unit_normal_force,
)
from crane_sim.models.moving_base import rotate_to_base
from crane_sim.multibody.vectors import ZERO, add, multiply, scale

OPEN = NormalForces(0, ZERO, NONE)


class ContactResult(NamedTuple):
    """Accelerations of a load with contact, and what presses on it, at one instant."""

    centre: tuple[float, float, float]  # m/s², acceleration of the centre of mass
    alpha: tuple[float, float, float]  # rad/s², in the load's axes
    normal_forces: Any  # `NormalForces`, None where contact is not modelled


def add_contact(contact, load, t, x, first, state, free):
    """Return the load's accelerations with contact.

    Args:
        contact, load: parameters.
        t, x, first: time [s], state, and the index of its first contact mode.
        state: BodyState of the load.
        free: accelerations of the load alone: of its centre (3,) [m/s²] in the axes of the base,
            and α (3,) in its own.
    """
    if contact is None:
        return ContactResult(free[0], free[1], None)
    if not isinstance(contact, RigidContact):
        return add_compliant_contact(contact, load, t, x, first, state, free)
    if closed_count(contact, x, first) == 0:
        return ContactResult(free[0], free[1], OPEN)
    moved = displacement_at(contact.surface.motion, t)
    if is_closed(x, first, len(contact.points)):
        forces = holding_forces(contact, load, x, first, (moved, state), free)
        centre, alpha = holding_accelerations(contact, x, first, (moved, state))
        return ContactResult(centre, rotate_to_base(state.rows, alpha), forces)
    normal_forces = slipping_forces(contact, load, x, first, (moved, state), free)
    return compute_contact_result(load, state, free, normal_forces)


def slipping_forces(contact, load, x, first, surface_and_body, free):
    """Return the NormalForces on a load that slips; arguments of `rigid.holding_forces`."""
    turn = multiply(surface_and_body[1].rows, free[1])
    lift = free[0][2] - surface_and_body[0].acceleration[2], turn[0], turn[1]
    return closing_forces(contact, load, x, first, surface_and_body, lift, 1.0)


def compute_contact_result(load, state, free, normal_forces):
    """Return the ContactResult of a load under normal forces; other arguments of `add_contact`."""
    force, moment = normal_forces.wrench
    own = rotate_to_base(state.rows, turn_of(load, state, moment))
    return ContactResult(
        add(free[0], scale(1.0 / load.mass, force)), add(free[1], own), normal_forces
    )


def add_compliant_contact(contact, load, t, x, first, state, free):
    """Return the result of `add_contact` for points on springs and dampers."""
    moved, wrench, count = displacement_at(contact.surface.motion, t), NONE, 0
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            point = contact_point(contact, i, moved, state)
            force = unit_normal_force(contact.surface, point)
            wrench, count = (
                add_force(wrench, compliant_normal_force(contact, point), point.lever, force),
                count + 1,
            )
    return compute_contact_result(load, state, free, NormalForces(count, ZERO, wrench))


def compliant_normal_force(contact, point):
    """Return the normal force [N] on a compliant point, also where it is free."""
    return -contact.stiffness * point.gap * (1.0 - contact.damping * point.velocity[2])
