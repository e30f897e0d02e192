"""The surface that a load touches, the points by which it does, and their friction.

The surface is the plane z = height in the axes of the base, moved along these axes by a motion of
its own, such as that of a deck; it does not turn. A point at r from the load's centre of mass C
has, above it and relative to it,

    gap = C_z + r_z - height - s_z,    velocity = v_C + ω × r - s',

with the motion s. Friction is Coulomb's, smoothed at the slip velocity v_s so that slow slip has a
direction: a normal force N on a point that slips by (v_x, v_y) comes with -μ N (v_x, v_y) / √(v_x²
+ v_y² + v_s²).
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_sim.models.loads import from_centre
from crane_sim.multibody.vectors import ZERO, Vector, add, cross, dot, multiply, scale, subtract
from crane_sim.trajectories.base_motion import Base, axis_at


class Surface(NamedTuple):
    """A plane, horizontal in the axes of the base."""

    height: float  # m, above the base's origin
    friction: float  # -, coefficient of friction
    slip_velocity: float  # m/s, of the smoothing
    motion: Base | None = None  # whose first three axes displace it; None: it rests on the base


class PointChanges(NamedTuple):
    """What may touch after exchanges of the load; k of them."""

    points: Any  # (k + 1, n, 3) m, of each load, as of a contact
    heights: Any  # (k + 1,) m, of the surface


class RigidContact(NamedTuple):
    """Points that do not enter the surface; n of them."""

    points: Any  # (n, 3) m, from the first load's centre of mass, in its axes
    surface: Surface
    restitution: float  # -, of impulses (Poisson)
    rest_velocity: float  # m/s, of approach, up to which an impact has no restitution
    changes: PointChanges | None = None


class CompliantContact(NamedTuple):
    """Points on springs and dampers, which only press; n of them."""

    points: Any  # (n, 3) m, from the first load's centre of mass, in its axes
    surface: Surface
    stiffness: float  # N/m, of each point
    damping: float  # s/m, λ/k of Hunt and Crossley
    changes: PointChanges | None = None


class Displacement(NamedTuple):
    """Motion of the surface at one instant, in the axes of the base."""

    position: Vector  # m
    velocity: Vector  # m/s
    acceleration: Vector  # m/s²


class ContactPoint(NamedTuple):
    """One point at one instant, in the axes of the base."""

    lever: Vector  # m, from the load's centre of mass
    gap: float  # m, above the surface
    velocity: Vector  # m/s, relative to the surface


class Wrench(NamedTuple):
    """Force, and moment about the load's centre of mass, in base axes; or impulses of both."""

    force: Vector  # N
    moment: Vector  # N m


def count_contact_modes(contact):
    """Return the number of floats of the contact's modes.

    Each point has one, and a rigid contact one more for stick.
    """
    if contact is None:
        return 0
    return len(contact.points) + (1 if isinstance(contact, RigidContact) else 0)


def displacement_at(motion, t):
    """Return the Displacement of a surface at time t [s]."""
    if motion is None:
        return Displacement(ZERO, ZERO, ZERO)
    axes = [axis_at(motion, t, i) for i in range(3)]
    return Displacement(*zip(*axes, strict=True))


def place_of(contact, i, state):
    """Return (load's point i from its centre of mass (3,), in its axes; height of the surface)."""
    if contact.changes is None:
        return (
            contact.points[i, 0],
            contact.points[i, 1],
            contact.points[i, 2],
        ), contact.surface.height
    points, k = contact.changes.points, state.number
    return from_centre(
        state, (points[k, i, 0], points[k, i, 1], points[k, i, 2])
    ), contact.changes.heights[k]


def contact_point(contact, i, moved, state):
    """Return point i of a load; moved: the surface's Displacement, state: the load's BodyState."""
    own, height = place_of(contact, i, state)
    lever = multiply(state.rows, own)
    velocity = add(state.velocity, multiply(state.rows, cross(state.omega, own)))
    gap = state.position[2] + lever[2] - height - moved.position[2]
    return ContactPoint(lever, gap, subtract(velocity, moved.velocity))


def slip_speed(point):
    """Return the speed [m/s] of a point along the surface."""
    vx, vy, _ = point.velocity
    return sqrt(vx * vx + vy * vy)


def unit_normal_force(surface, point):
    """Return the force (3,) on a slipping point for each newton of its normal force."""
    vx, vy, _ = point.velocity
    drag = -surface.friction / sqrt(
        vx * vx + vy * vy + surface.slip_velocity * surface.slip_velocity
    )
    return drag * vx, drag * vy, 1.0


def add_force(wrench, factor, lever, force):
    """Return the sum of a wrench and of `factor` times a force [N] that acts at `lever` [m]."""
    applied = scale(factor, force)
    return Wrench(add(wrench.force, applied), add(wrench.moment, cross(lever, applied)))


def wrench_power(wrench, state):
    """Return the power [W] of a wrench on a load (BodyState), relative to the base."""
    return dot(wrench.force, state.velocity) + dot(wrench.moment, multiply(state.rows, state.omega))
