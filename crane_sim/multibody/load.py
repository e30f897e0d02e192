"""A load at the lower end of a rope: a point mass, or a rigid body that hangs from one of its points.

A body with mass m, inertia I about its centre C and attachment r (from C to the point P where it hangs), under the
pull -T n of the last link, a force f on C and a moment M, moves by

    m a_C = f - T n,    I α = M - T r × n - Ω × I Ω,    a_P = a_C + α × r + Ω × (Ω × r),

Ω its absolute angular velocity. So the mobility of P along n is 1/m + (r × n) · I⁻¹ (r × n), and no angle appears.
"""

from typing import Any, NamedTuple

from crane_sim.multibody import linear
from crane_sim.multibody.attitude import Quaternion, angular_velocity, quaternion_acceleration, rotation
from crane_sim.multibody.chain import across
from crane_sim.multibody.tree import BaseMotion
from crane_sim.multibody.vectors import ZERO, Matrix, Vector, add, combine, cross, dot, multiply, scale, subtract


class PointLoad(NamedTuple):
    """A point mass."""

    mass: Any  # kg


class RigidLoad(NamedTuple):
    """A rigid body; vectors in its own axes, from its centre of mass."""

    mass: Any  # kg
    inertia: Matrix  # kg m²
    attachment: Vector  # m, r


Load = PointLoad | RigidLoad


class LoadMotion(NamedTuple):
    """Attitude and absolute rotation of a body at one instant."""

    attitude: Quaternion
    rows: Matrix  # R: vectors of the body in the base's axes
    omega: Vector  # rad/s, Ω in the body's axes


class LoadForce(NamedTuple):
    """What acts on a load besides the rope and gravity."""

    force: Vector = ZERO  # N, on the centre of mass, in the base's axes
    moment: Vector = ZERO  # N m, in the body's axes


def to_body(rows: Matrix, a: Vector) -> Vector:
    """Return a vector of the base's axes in the body's."""
    return combine(rows, a)


def move_load(attitude: Quaternion, rate: Quaternion, base: BaseMotion) -> LoadMotion:
    """Return the motion of a body with this attitude and its rate, both relative to the base."""
    rows = rotation(attitude)
    return LoadMotion(attitude, rows, add(angular_velocity(attitude, rate), to_body(rows, base.angular_velocity)))


def attitude_acceleration(load: RigidLoad, motion: LoadMotion, base: BaseMotion, moment: Vector) -> Quaternion:
    """Return the attitude's second derivative relative to the base under a moment [N m], in the body's axes."""
    w = to_body(motion.rows, base.angular_velocity)
    omega = subtract(motion.omega, w)
    carried = subtract(to_body(motion.rows, base.angular_acceleration), cross(omega, w))
    alpha = subtract(angular_acceleration(load, motion, moment), carried)
    return quaternion_acceleration(motion.attitude, omega, alpha)


def end_mobility(load: Load, motion: LoadMotion | None, n: Vector) -> Any:
    """Return the mobility [1/kg] of the attachment along the unit vector n, in the base's axes."""
    if isinstance(load, PointLoad) or motion is None:
        return 1.0 / load.mass
    lever = cross(load.attachment, to_body(motion.rows, n))
    return 1.0 / load.mass + dot(lever, _solve_inertia(load, lever))


def end_acceleration(load: Load, motion: LoadMotion | None, given: LoadForce) -> Vector:
    """Return the attachment's acceleration [m/s²] without the rope, in the base's axes."""
    centre = scale(1.0 / load.mass, given.force)
    if isinstance(load, PointLoad) or motion is None:
        return centre
    alpha, r, w = angular_acceleration(load, motion, given.moment), load.attachment, motion.omega
    return add(centre, multiply(motion.rows, add(cross(alpha, r), cross(w, cross(w, r)))))


def end_acceleration_across(load: Load, motion: LoadMotion | None, n: Vector, tension: Any) -> Vector:
    """Return the attachment's acceleration [m/s²] across the last link that the pull of that link causes."""
    if isinstance(load, PointLoad) or motion is None:
        return ZERO
    own = to_body(motion.rows, n)
    turning = cross(_solve_inertia(load, cross(load.attachment, own)), load.attachment)
    return multiply(motion.rows, scale(-tension, across(own, turning)))


def angular_acceleration(load: RigidLoad, motion: LoadMotion, moment: Vector) -> Vector:
    """Return α [rad/s²] under a moment [N m], both in the body's axes."""
    w = motion.omega
    return _solve_inertia(load, subtract(moment, cross(w, multiply(load.inertia, w))))


def pull_moment(load: RigidLoad, motion: LoadMotion, n: Vector, tension: Any) -> Vector:
    """Return the moment [N m] of the rope's pull about the centre of mass, in the body's axes."""
    return scale(-tension, cross(load.attachment, to_body(motion.rows, n)))


def _solve_inertia(load: RigidLoad, moment: Vector) -> Vector:
    x, y, z = linear.solve(linear.factor(load.inertia), moment)
    return x, y, z
