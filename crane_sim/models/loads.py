"""Loads at the lower end of a cable: a point mass, or a rigid body that hangs from one point.

A rigid body with mass m, inertia I about its centre of mass C and attachment r (C to the point P
where it hangs), under the pull -T n of the last link, moves by

    I α = -T (r × n) - Ω × I Ω,    a_P = a_C + α × r + ω × (ω × r),

so the mobility of P along n is 1/m + (r × n) · I⁻¹ (r × n), and no angle appears. ω is relative to
the base, Ω = ω + w with the base's angular velocity w. The body's own axes are used for all that
turns, the base's for all that moves.
"""

from typing import Any, NamedTuple

from crane_sim.files.types import Positive
from crane_sim.models.effects import add_drag
from crane_sim.models.moving_base import (
    added_energy,
    airspeed,
    imposed_acceleration,
    pose_at,
    rotate_to_base,
    to_base,
)
from crane_sim.models.wind_load import Windage, add_wind
from crane_sim.multibody.attitude import align, angular_velocity, quaternion_acceleration, rotation
from crane_sim.multibody.vectors import (
    ZERO,
    Matrix,
    Vector,
    add,
    cross,
    dot,
    multiply,
    scale,
    subtract,
)
from crane_sim.trajectories.inputs import value_at


class PointLoad(NamedTuple):
    """The payload, a point mass."""

    mass: Positive  # kg, of the payload
    windage: Windage | None = None  # area and drag in the `wind`; left out: no wind acts on it


class RigidLoad(NamedTuple):
    """A payload that is a rigid body; vectors are in its axes from its centre of mass."""

    mass: float  # kg
    inertia: Matrix  # kg m², rows of the inertia tensor about the centre of mass
    inverse_inertia: Matrix  # 1/(kg m²), rows of its inverse
    attachment: Vector  # m, from the centre of mass to the point from which the body hangs
    windage: Windage | None = None  # area and drag in the wind
    pressure_centre: Vector = (0.0, 0.0, 0.0)  # m, where the wind presses


class PointState(NamedTuple):
    """Kinematics of a point mass relative to the base."""

    position: Vector  # m
    velocity: Vector  # m/s


class BodyState(NamedTuple):
    """Kinematics of a rigid body relative to the base.

    Where its parts are exchanged, its coordinates are those of a point that stays the same: where
    the centre of mass of the first load was, so that no coordinate jumps.
    """

    position: Vector  # m, of the centre of mass
    velocity: Vector  # m/s
    rows: tuple[Vector, Vector, Vector]  # of R, which takes vectors of the body to the base
    omega: Vector  # rad/s, in the body's axes
    quaternion: tuple[float, float, float, float]
    centre: Any = None  # (3,) m, of mass, from the point of the coordinates, in the body's axes;
    # None: it is that point
    number: Any = None  # of the load, where loads are exchanged


def load_coordinates(load):
    """Return the number of coordinates that the load adds to those of the cable."""
    return 0 if isinstance(load, PointLoad) else 4


def quaternion_at(x, i, v):
    """Return (unit quaternion, rate across it) nearest to those that begin at x[i] and x[v]."""
    return align((x[i], x[i + 1], x[i + 2], x[i + 3]), (x[v], x[v + 1], x[v + 2], x[v + 3]))


def align_quaternion(x, i, v):
    """Give the quaternion at x[i] length 1, and make its rate at x[v] perpendicular to it."""
    (x[i], x[i + 1], x[i + 2], x[i + 3]), (x[v], x[v + 1], x[v + 2], x[v + 3]) = quaternion_at(
        x, i, v
    )


def load_state(load, x, nq, end):
    """Return the load's kinematics.

    Args:
        load: its parameters.
        x, nq: state of the crane and its number of coordinates; the load's own are the last ones.
        end: (position [m], velocity [m/s]) of the cable's lower end relative to the base, each
            (3,).
    """
    if isinstance(load, PointLoad):
        return PointState(*end)
    quaternion, rate = quaternion_at(x, nq - 4, 2 * nq - 4)
    rows, omega = rotation(quaternion), angular_velocity(quaternion, rate)
    lever, moves = multiply(rows, load.attachment), multiply(rows, cross(omega, load.attachment))
    return BodyState(subtract(end[0], lever), subtract(end[1], moves), rows, omega, quaternion)


def from_centre(state, point):
    """Return a load's point (3,) from its centre of mass, given from that of its coordinates.

    Both are in the load's axes.
    """
    return point if state.centre is None else subtract(point, state.centre)


def coordinate_velocity(state):
    """Return the velocity (3,) [m/s] of the load's coordinates, in the axes of the base."""
    if state.centre is None:
        return state.velocity
    return subtract(state.velocity, multiply(state.rows, cross(state.omega, state.centre)))


def coordinate_acceleration(state, centre, alpha):
    """Return the acceleration of the load's coordinates, from those of its centre of mass.

    These are the centre's (3,) [m/s²], and α (3,) in the load's axes.
    """
    if state.centre is None:
        return centre
    turning = add(cross(alpha, state.centre), cross(state.omega, cross(state.omega, state.centre)))
    return subtract(centre, multiply(state.rows, turning))


def centre_acceleration(load, base, state, force, gravity):
    """Return the centre's acceleration (3,) [m/s²] relative to the base under a force (3,) [N]."""
    x, y, z = imposed_acceleration(base, state.position, state.velocity)
    return x + force[0] / load.mass, y + force[1] / load.mass, z + force[2] / load.mass - gravity


def end_mobility(load, state, n):
    """Return the mobility [1/kg] of the load's attachment along n (3,), both in base axes.

    n is a unit vector.
    """
    if isinstance(load, PointLoad):
        return 1.0 / load.mass
    moment = cross(load.attachment, rotate_to_base(state.rows, n))
    return 1.0 / load.mass + dot(moment, multiply(load.inverse_inertia, moment))


def end_acceleration_across(load, state, n, tension):
    """Return the attachment's acceleration (3,) [m/s²] across the last link by that link's pull.

    The link is along n.
    """
    if isinstance(load, PointLoad):
        return ZERO
    own = rotate_to_base(state.rows, n)
    whole = cross(multiply(load.inverse_inertia, cross(load.attachment, own)), load.attachment)
    across = subtract(whole, scale(dot(own, whole), own))
    return scale(-tension, multiply(state.rows, across))


def absolute_spin(base, state):
    """Return (Ω, w' + w × ω), both (3,) in the body's axes; `base`: by `base_kinematics_at`."""
    if base is None:
        return state.omega, ZERO
    w = base.angular_velocity
    carried = add(base.angular_acceleration, cross(w, multiply(state.rows, state.omega)))
    return add(state.omega, rotate_to_base(state.rows, w)), rotate_to_base(state.rows, carried)


def end_acceleration_free(load, base, state, acc, moment):
    """Return the attachment's acceleration (3,) [m/s²] without the cable's pull.

    Args:
        load, base, state: parameters, base, kinematics of the load.
        acc: of its centre of mass (3,), in the axes of the base.
        moment: on it (3,) [N m], in its own axes.
    """
    if isinstance(load, PointLoad):
        return acc
    alpha, omega, r = angular_acceleration(load, base, state, moment), state.omega, load.attachment
    return add(acc, multiply(state.rows, add(cross(alpha, r), cross(omega, cross(omega, r)))))


def angular_acceleration(load, base, state, moment):
    """Return α (3,) [rad/s²] under a moment (3,) [N m], both in the body's axes."""
    whole, carried = absolute_spin(base, state)
    gyroscopic = cross(whole, multiply(load.inertia, whole))
    return subtract(multiply(load.inverse_inertia, subtract(moment, gyroscopic)), carried)


def write_load_acceleration(load, base, state, pull, out, first):
    """Write the second derivatives of the load's own coordinates into `out`, from `first` on.

    Args:
        load, base, state: parameters, base, kinematics of the load.
        pull: direction (3,) and tension [N] of the last link, other moments (3,) [N m] on the load
            in its own axes.
        out, first: array, and index of the first one in it.
    """
    if isinstance(load, PointLoad):
        return
    n, tension, moment = pull
    levers = cross(load.attachment, rotate_to_base(state.rows, n))
    alpha = angular_acceleration(load, base, state, subtract(moment, scale(tension, levers)))
    second = quaternion_acceleration(state.quaternion, state.omega, alpha)
    out[first], out[first + 1], out[first + 2], out[first + 3] = second


def wind_on_load(flow, base, load, state):
    """Return force (3,) [N] and moment (3,) [N m] of the wind.

    The moment is in the load's axes, and 0 on a point mass.

    `flow` is an Airflow, None without wind.
    """
    if flow is None:
        return ZERO, ZERO
    if isinstance(load, PointLoad):
        air = airspeed(base, state.position, state.velocity)
        return add_wind(flow, load.windage, ZERO, state.position, air), ZERO
    r = load.pressure_centre
    position = add(state.position, multiply(state.rows, r))
    velocity = add(state.velocity, multiply(state.rows, cross(state.omega, r)))
    force = add_wind(flow, load.windage, ZERO, position, airspeed(base, position, velocity))
    return force, cross(r, rotate_to_base(state.rows, force))


def moment_power(load, state, moment):
    """Return the power [W] of a moment (3,) on the load, in its axes."""
    return 0.0 if isinstance(load, PointLoad) else dot(state.omega, moment)


def imposed_load_power(base, load, state):
    """Return the power [W] that the base supplies to the load, also by turning a rigid one."""
    if base is None:
        return 0.0
    acc = imposed_acceleration(base, state.position, state.velocity)
    power = load.mass * dot(acc, state.velocity)
    if isinstance(load, PointLoad):
        return power
    alone = angular_acceleration(load, None, state, ZERO)
    change = subtract(angular_acceleration(load, base, state, ZERO), alone)
    return power + dot(state.omega, multiply(load.inertia, change))


def load_energies(base, load, state, gravity):
    """Return the energies [J] of the load.

    Returns:
        kinetic and potential energy relative to the base, and those that the base, a BaseState or
        None, adds.
    """
    kinetic, potential = (
        0.5 * load.mass * dot(state.velocity, state.velocity),
        load.mass * gravity * state.position[2],
    )
    if isinstance(load, RigidLoad):
        kinetic += 0.5 * dot(state.omega, multiply(load.inertia, state.omega))
    if base is None:
        return kinetic, potential, 0.0, 0.0
    added, lifted = added_energy(base, gravity, load.mass, state.position, state.velocity)
    if isinstance(load, RigidLoad):
        w = rotate_to_base(state.rows, base.angular_velocity)
        carried = multiply(load.inertia, w)
        added += dot(state.omega, carried) + 0.5 * dot(w, carried)
    return kinetic, potential, added, lifted


def load_force(p, body, t, flow, base, load):
    """Return force (3,) [N] and moment (3,) [N m] of air, wind and given forces on the load.

    The moment is in the load's axes.

    Args:
        p: the crane.
        body: parameters of its load.
        t, flow, base, load: time [s], wind in the base's axes, base and kinematics of the load.
    """
    air = airspeed(base, load.position, load.velocity)
    force = add_given_force(p.force, add_drag(p.drag, ZERO, air), p.base, t)
    wind, moment = wind_on_load(flow, base, body, load)
    return add(force, wind), moment


def add_given_force(given, force, base, t):
    """Return the force (3,) [N] plus the given one on the payload at time t, in base axes."""
    if given is None:
        return force
    whole = value_at(given.x, t), value_at(given.y, t), value_at(given.z, t)
    return add(force, to_base(pose_at(base, t), whole))
