"""Normal forces of a rigid contact: they keep closed points on the surface, or hold the load.

The closed points' normal forces λ are unilateral, and more than three of them are statically
indeterminate. Of all that hold the load those with the least sum of squares are taken. They are
linear in the position, λ_i = y₀ + y₁ r_y - y₂ r_x: the limit of equal springs as their stiffness
grows. So there are never more than three unknowns y, which follow from the accelerations (z'', α_x,
α_y) of the surface less those of the load alone. With one or two closed points the normal forces
themselves are the unknowns.

While the load slips, each normal force has its friction, proportional to it. A load that sticks,
with three or more closed points, moves as the surface does. The holding friction acts on the
surface, below the centre of mass: the normal forces take what its moment leaves of the tilting
moment, so that a tall load tips. It is distributed over the points in proportion to their normal
forces, f_i = λ_i (a + b ẑ × ρ_i) with ρ_i from the centre of pressure; the load slips where one
|f_i| exceeds μ λ_i.

Accelerations that keep a gap g at zero leave rounding and the steps' errors to add up; the
surface's acceleration less 2 γ g' + γ² g is asked for in its place (J. Baumgarte, Comput. Methods
Appl. Mech. Eng. 1, 1972, 1-16).
"""

from math import sqrt
from typing import NamedTuple

from crane_sim.models.contact.surface import Wrench, add_force, contact_point, unit_normal_force
from crane_sim.models.moving_base import rotate_to_base
from crane_sim.multibody.vectors import (
    IDENTITY,
    ZERO,
    add,
    combine,
    cross,
    dot,
    multiply,
    scale,
    subtract,
)
from crane_sim.numerics.jit import routine

NONE = Wrench(ZERO, ZERO)
RATE = 10.0  # 1/s, γ: slow beside falls and slip, so that it costs no steps


class NormalForces(NamedTuple):
    """What presses on the load at one instant."""

    closed: int  # number of closed points
    unknowns: tuple[float, float, float]  # y
    wrench: Wrench  # of all forces


def is_closed(x, first, i):
    """Return whether mode number i of those that begin at x[first] is set."""
    return x[first + i] > 0.5


def closed_count(contact, x, first):
    """Return the number of closed points in state x, whose contact modes begin at index `first`."""
    count = 0
    for i in range(len(contact.points)):
        count += is_closed(x, first, i)
    return count


def shares(count, place, lever):
    """Return the factors (3,) of the unknowns in the normal force of closed point `place`."""
    if count > 2:
        return 1.0, lever[1], -lever[0]
    return (1.0, 0.0, 0.0) if place == 0 else (0.0, 1.0, 0.0)


def unit_wrenches(contact, x, first, scene, count, rough):
    """Return the wrenches (3) of the unknowns, each 1.

    Arguments of `slipping_forces`; rough: 1 with friction.
    """
    (moved, state), place, wrenches = scene, 0, (NONE, NONE, NONE)
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            point = contact_point(contact, i, moved, state)
            fx, fy, fz = unit_normal_force(contact.surface, point)
            parts = zip(wrenches, shares(count, place, point.lever), strict=True)
            force, place = (rough * fx, rough * fy, fz), place + 1
            wrenches = tuple(
                [add_force(wrench, factor, point.lever, force) for wrench, factor in parts]
            )
    return wrenches


def lift_of(load, state, wrench):
    """Return (z'', α_x, α_y) of the load under a wrench."""
    x, y, _ = turn_of(load, state, wrench.moment)
    return wrench.force[2] / load.mass, x, y


def turn_of(load, state, moment):
    """Return the angular acceleration (3,) under a moment (3,), both in the axes of the base."""
    return multiply(state.rows, multiply(load.inverse_inertia, rotate_to_base(state.rows, moment)))


def required_changes(contact, x, first, scene, count, lift, smooth):
    """Return (rows (3) that act on (z'', α_x, α_y), what they must give (3,)).

    Arguments of `closing_forces`.
    """
    (moved, state), place = scene, 0
    if count > 2:
        back = add(lift, scale(smooth, correction(contact, x, first, scene)))
        return IDENTITY, scale(-1.0, back)
    omega = multiply(state.rows, state.omega)
    row, other, missing, more = ZERO, ZERO, 0.0, 0.0
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            point = contact_point(contact, i, moved, state)
            across = 1.0, point.lever[1], -point.lever[0]
            back = cross(omega, cross(omega, point.lever))[2] + RATE * (
                2.0 * point.velocity[2] + RATE * point.gap
            )
            needed = -dot(across, lift) - smooth * back
            if place == 0:
                row, missing = across, needed
            else:
                other, more = across, needed
            place += 1
    return (row, other, ZERO), (missing, more, 0.0)


def correction(contact, x, first, scene):
    """Return 2 γ g' + γ² g (3,) of the gap's plane g₀ + g₁ r_y - g₂ r_x.

    It is the plane through three or more closed points.
    """
    sums, (moved, state) = ZERO, scene
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            point = contact_point(contact, i, moved, state)
            back = RATE * (2.0 * point.velocity[2] + RATE * point.gap)
            sums = add(sums, scale(back, shares(3, 0, point.lever)))
    return plane_through(contact, x, first, scene, sums)


def plane_through(contact, x, first, scene, sums):
    """Return y (3,) of the plane y₀ + y₁ r_y - y₂ r_x with given sums over closed points.

    The sums are those of its products with (1, r_y, -r_x).
    """
    columns = ZERO, ZERO, ZERO
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            factors = shares(3, 0, contact_point(contact, i, scene[0], scene[1]).lever)
            parts = zip(columns, factors, strict=True)
            columns = tuple([add(column, scale(factor, factors)) for column, factor in parts])
    return solve_three(columns, sums)


def solve_three(columns, right):
    """Return the solution (3,) of a 3 × 3 system with these columns."""
    a, b, c = columns
    scale = 1.0 / dot(a, cross(b, c))
    return (
        scale * dot(right, cross(b, c)),
        scale * dot(a, cross(right, c)),
        scale * dot(a, cross(b, right)),
    )


def solve_unknowns(count, rows, columns, b):
    """Return y (3,) with rows · columns y = b, of which `count`, at most 3, are unknown."""
    p, q, _ = products = [multiply(rows, column) for column in columns]
    if count == 1:
        return b[0] / p[0], 0.0, 0.0
    if count == 2:
        scale = 1.0 / (p[0] * q[1] - q[0] * p[1])
        return scale * (b[0] * q[1] - q[0] * b[1]), scale * (p[0] * b[1] - b[0] * p[1]), 0.0
    return solve_three(products, b)


@routine
def closing_forces(contact, load, x, first, scene, lift, smooth):
    """Return the NormalForces that keep closed points on the surface.

    Args:
        contact, load: parameters.
        x, first: state and the index of its first contact mode.
        scene: (Displacement of the surface, BodyState of the load).
        lift: (z'', α_x, α_y) of the load alone, relative to the surface; or velocities, which they
            bring to zero.
        smooth: 1 for accelerations, with friction; 0 for velocities, which jump without.
    """
    count = closed_count(contact, x, first)
    wrenches = unit_wrenches(contact, x, first, scene, count, smooth)
    columns = [lift_of(load, scene[1], wrench) for wrench in wrenches]
    rows, missing = required_changes(contact, x, first, scene, count, lift, smooth)
    y = solve_unknowns(count, rows, columns, missing)
    forces, moments = zip(*wrenches, strict=True)
    return NormalForces(count, y, Wrench(combine(forces, y), combine(moments, y)))


@routine
def holding_accelerations(contact, x, first, scene):
    """Return the accelerations (centre (3,), α (3,)) of a load that moves as the surface.

    They are in the axes of the base.
    """
    moved, state = scene
    back, omega = correction(contact, x, first, scene), multiply(state.rows, state.omega)
    slip, damping = subtract(state.velocity, moved.velocity), 2.0 * RATE
    (ax, ay, az), (vx, vy, _) = moved.acceleration, slip
    return (ax - damping * vx, ay - damping * vy, az - back[0]), (
        -back[1],
        -back[2],
        -damping * omega[2],
    )


def surface_level(contact, scene):
    """Return r_z [m] of the surface from the load's centre of mass."""
    point = contact_point(contact, 0, scene[0], scene[1])
    return point.lever[2] - point.gap


@routine
def holding_forces(contact, load, x, first, scene, free):
    """Return the NormalForces that hold the load.

    Three or more points are closed; free: as in `add_contact`.
    """
    state, (centre, alpha) = scene[1], holding_accelerations(contact, x, first, scene)
    force = scale(load.mass, subtract(centre, free[0]))
    turn = multiply(load.inertia, subtract(rotate_to_base(state.rows, alpha), free[1]))
    wrench = Wrench(force, multiply(state.rows, turn))
    (fx, fy, fz), (mx, my, _), level = force, wrench.moment, surface_level(contact, scene)
    # less the moment of the friction, which acts on the surface
    sums = fz, mx + level * fy, my - level * fx
    y = plane_through(contact, x, first, scene, sums)
    return NormalForces(closed_count(contact, x, first), y, wrench)


def normal_force_on(normal_forces, place, lever):
    """Return the normal force [N] on a closed point, the one with number `place`."""
    return dot(shares(normal_forces.closed, place, lever), normal_forces.unknowns)


def least_normal_force(contact, x, first, scene, normal_forces):
    """Return the smallest normal force [N] on a closed point."""
    least, place = 1e300, 0
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            lever = contact_point(contact, i, scene[0], scene[1]).lever
            least, place = min(least, normal_force_on(normal_forces, place, lever)), place + 1
    return least


def normal_force_moments(contact, x, first, scene, normal_forces):
    """Return Σ λ, Σ λ r_x, Σ λ r_y and Σ λ (r_x² + r_y²)."""
    place, total, sx, sy, polar = 0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            lever = contact_point(contact, i, scene[0], scene[1]).lever
            normal_force = normal_force_on(normal_forces, place, lever)
            total, sx, sy = (
                total + normal_force,
                sx + normal_force * lever[0],
                sy + normal_force * lever[1],
            )
            polar, place = (
                polar + normal_force * (lever[0] * lever[0] + lever[1] * lever[1]),
                place + 1,
            )
    return total, sx, sy, polar


@routine
def required_friction(contact, x, first, scene, normal_forces):
    """Return the coefficient of friction needed to hold the load by these NormalForces.

    It is 1e300 if they pull.
    """
    total, sx, sy, polar = normal_force_moments(contact, x, first, scene, normal_forces)
    if not total > 0.0:
        return 1e300
    cx, cy, (fx, fy, _) = sx / total, sy / total, normal_forces.wrench.force
    turn = (normal_forces.wrench.moment[2] - (cx * fy - cy * fx)) / (
        polar - total * (cx * cx + cy * cy)
    )
    worst = 0.0
    for i in range(len(contact.points)):
        if is_closed(x, first, i):
            lever = contact_point(contact, i, scene[0], scene[1]).lever
            ax, ay = fx / total - turn * (lever[1] - cy), fy / total + turn * (lever[0] - cx)
            worst = max(worst, sqrt(ax * ax + ay * ay))
    return worst
