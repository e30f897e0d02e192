"""Dynamics of a load at the cable's lower end: its coordinates, its mobility, what it does without the cable's pull.

A rigid body with mass m, inertia I about its centre of mass C and attachment r (C to the point P where it hangs), under
the pull -T n of the last link, moves by

    I α = -T (r × n) - Ω × I Ω,    a_P = a_C + α × r + ω × (ω × r),

so the mobility of P along n is 1/m + (r × n) · I⁻¹ (r × n), and no angle appears. ω is relative to the base, Ω = ω + w
with the base's angular velocity w. The body's own axes are used for all that turns, the base's for all that moves.
"""

from typing import NamedTuple

from crane_sim.models.attitude import (
    align_quaternion,
    angular_velocity_of,
    quaternion_acceleration,
    rotation_of,
)
from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import (
    BaseKinematics,
    BaseState,
    added_energy,
    airspeed,
    cross,
    dot,
    imposed_acceleration,
    rotate_to_base,
)
from crane_sim.models.wind_load import Airflow, add_wind
from crane_sim.numerics.jit import generic

Vector = tuple[float, float, float]


class PointState(NamedTuple):
    """Kinematics of a point mass relative to the base."""

    position: Vector  # m
    velocity: Vector  # m/s


class BodyState(NamedTuple):
    """Kinematics of a rigid body relative to the base."""

    position: Vector  # m, of the centre of mass
    velocity: Vector  # m/s
    rows: tuple[Vector, Vector, Vector]  # of R, which takes vectors of the body to the base
    omega: Vector  # rad/s, in the body's axes
    quaternion: tuple[float, float, float, float]


class ChangedBody(NamedTuple):
    """Kinematics of a rigid body whose parts are exchanged: coordinates are those of a point that stays the same.

    That point is where the centre of mass of the first load was, so that no coordinate jumps.
    """

    position: Vector  # m, of the centre of mass
    velocity: Vector  # m/s
    rows: tuple[Vector, Vector, Vector]  # of R, which takes vectors of the body to the base
    omega: Vector  # rad/s, in the body's axes
    quaternion: tuple[float, float, float, float]
    centre: Vector  # m, from the point to the centre of mass, in the body's axes
    number: int  # of the load


def multiply(rows, a):
    """Return the product (3,) of a matrix, given by its rows, and a vector."""
    return dot(rows[0], a), dot(rows[1], a), dot(rows[2], a)


def add(a, b):
    """Return the sum (3,) of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a, b):
    """Return the difference (3,) of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@generic
def load_coordinates(load):
    """Return the number of coordinates that the load adds to those of the cable."""
    return 0


@load_coordinates.register(RigidLoad)
def _(load):
    return 4


@generic
def load_state(load, x, nq, end):
    """Return the load's kinematics.

    Args:
        load: its parameters.
        x, nq: state of the crane and its number of coordinates; the load's own are the last ones.
        end: (position [m], velocity [m/s]) of the cable's lower end relative to the base, each (3,).
    """
    return PointState(end[0], end[1])


@load_state.register(RigidLoad)
def _(load, x, nq, end):
    quaternion, rate = align_quaternion(x, nq - 4, 2 * nq - 4)
    rows, omega = rotation_of(quaternion), angular_velocity_of(quaternion, rate)
    lever, moves = multiply(rows, load.attachment), multiply(rows, cross(omega, load.attachment))
    return BodyState(subtract(end[0], lever), subtract(end[1], moves), rows, omega, quaternion)


@generic
def from_centre(state, point):
    """Return a point (3,) of the load, given from that of its coordinates, from its centre of mass, in its axes."""
    return point


@from_centre.register(ChangedBody)
def _(state, point):
    return subtract(point, state.centre)


@generic
def coordinate_velocity(state):
    """Return the velocity (3,) [m/s] of the load's coordinates, in the axes of the base."""
    return state.velocity


@coordinate_velocity.register(ChangedBody)
def _(state):
    return subtract(state.velocity, multiply(state.rows, cross(state.omega, state.centre)))


@generic
def coordinate_acceleration(state, centre, alpha):
    """Return that of the load's coordinates, from its centre's (3,) [m/s²] and α (3,) in its own axes."""
    return centre


@coordinate_acceleration.register(ChangedBody)
def _(state, centre, alpha):
    turning = add(cross(alpha, state.centre), cross(state.omega, cross(state.omega, state.centre)))
    return subtract(centre, multiply(state.rows, turning))


@generic
def end_mobility(load, state, n):
    """Return the mobility [1/kg] of the load's attachment along the unit vector n (3,), in the axes of the base."""
    return 1.0 / load.mass


@end_mobility.register(RigidLoad)
def _(load, state, n):
    moment = cross(load.attachment, rotate_to_base(state.rows, n))
    return 1.0 / load.mass + dot(moment, multiply(load.inverse_inertia, moment))


@generic
def end_acceleration_across(load, state, n, tension):
    """Return the attachment's acceleration (3,) [m/s²] across the last link, along n, by the pull of that link."""
    return 0.0, 0.0, 0.0


@end_acceleration_across.register(RigidLoad)
def _(load, state, n, tension):
    own = rotate_to_base(state.rows, n)
    x, y, z = cross(multiply(load.inverse_inertia, cross(load.attachment, own)), load.attachment)
    along = own[0] * x + own[1] * y + own[2] * z
    across = multiply(state.rows, (x - along * own[0], y - along * own[1], z - along * own[2]))
    return -tension * across[0], -tension * across[1], -tension * across[2]


@generic
def absolute_spin(base, state):
    """Return (Ω, w' + w × ω), both (3,) in the body's axes; `base` as of `moving_base.base_kinematics_at`."""
    return state.omega, (0.0, 0.0, 0.0)


@absolute_spin.register(BaseKinematics)
def _(base, state):
    w = base.angular_velocity
    carried = add(base.angular_acceleration, cross(w, multiply(state.rows, state.omega)))
    return add(state.omega, rotate_to_base(state.rows, w)), rotate_to_base(state.rows, carried)


@generic
def end_acceleration_free(load, base, state, acc, moment):
    """Return the attachment's acceleration (3,) [m/s²] without the cable's pull.

    Args:
        load, base, state: parameters, base, kinematics of the load.
        acc: of its centre of mass (3,), in the axes of the base.
        moment: on it (3,) [N m], in its own axes.
    """
    return acc


@end_acceleration_free.register(RigidLoad)
def _(load, base, state, acc, moment):
    alpha, omega, r = angular_acceleration(load, base, state, moment), state.omega, load.attachment
    return add(acc, multiply(state.rows, add(cross(alpha, r), cross(omega, cross(omega, r)))))


def angular_acceleration(load, base, state, moment):
    """Return α (3,) [rad/s²] under a moment (3,) [N m], both in the body's axes."""
    whole, carried = absolute_spin(base, state)
    gyroscopic = cross(whole, multiply(load.inertia, whole))
    return subtract(multiply(load.inverse_inertia, subtract(moment, gyroscopic)), carried)


@generic
def write_load_acceleration(load, base, state, pull, out):
    """Write the second derivatives of the load's own coordinates to the end of the crane's in `out`.

    Args:
        load, base, state: parameters, base, kinematics of the load.
        pull: direction (3,) and tension [N] of the last link, other moments (3,) [N m] on the load in its own axes.
        out: (array, index of the first one).
    """


@write_load_acceleration.register(RigidLoad)
def _(load, base, state, pull, out):
    n, tension, moment = pull
    x, y, z = cross(load.attachment, rotate_to_base(state.rows, n))
    whole = moment[0] - tension * x, moment[1] - tension * y, moment[2] - tension * z
    alpha = angular_acceleration(load, base, state, whole)
    array, first = out
    second = quaternion_acceleration(state.quaternion, state.omega, alpha)
    array[first], array[first + 1], array[first + 2], array[first + 3] = second


@generic
def wind_on_load(flow, base, load, state):
    """Return force (3,) [N] and moment (3,) [N m, in the load's axes] of the wind; `flow`: Airflow, None without."""
    return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


@wind_on_load.register(Airflow)
def _(flow, base, load, state):
    return pressure_on(load, flow, base, state)


@generic
def pressure_on(load, flow, base, state):
    """Return the result of `wind_on_load` for a wind: on a point mass it has no moment."""
    air = airspeed(base, state.position, state.velocity)
    return add_wind(flow, load.windage, (0.0, 0.0, 0.0), state.position, air), (0.0, 0.0, 0.0)


@pressure_on.register(RigidLoad)
def _(load, flow, base, state):
    r = load.pressure_centre
    position = add(state.position, multiply(state.rows, r))
    velocity = add(state.velocity, multiply(state.rows, cross(state.omega, r)))
    force = add_wind(flow, load.windage, (0.0, 0.0, 0.0), position, airspeed(base, position, velocity))
    return force, cross(r, rotate_to_base(state.rows, force))


@generic
def moment_power(load, state, moment):
    """Return the power [W] of a moment (3,) on the load, in its axes."""
    return 0.0


@moment_power.register(RigidLoad)
def _(load, state, moment):
    return dot(state.omega, moment)


@generic
def turning_energy(load, state):
    """Return the kinetic energy [J] of the load's turning relative to the base."""
    return 0.0


@turning_energy.register(RigidLoad)
def _(load, state):
    return 0.5 * dot(state.omega, multiply(load.inertia, state.omega))


@generic
def imposed_turning_power(load, base, state):
    """Return the power [W] that the base's rotation supplies to the load's turning."""
    return 0.0


@imposed_turning_power.register(RigidLoad)
def _(load, base, state):
    return _turning_power(base, load, state)


@generic
def _turning_power(base, load, state):
    return 0.0


@_turning_power.register(BaseKinematics)
def _(base, load, state):
    alone = angular_acceleration(load, None, state, (0.0, 0.0, 0.0))
    change = subtract(angular_acceleration(load, base, state, (0.0, 0.0, 0.0)), alone)
    return dot(state.omega, multiply(load.inertia, change))


@generic
def imposed_load_power(base, load, state):
    """Return the power [W] that the base supplies to the load."""
    return 0.0


@imposed_load_power.register(BaseKinematics)
def _(base, load, state):
    acc = imposed_acceleration(base, state.position, state.velocity)
    return load.mass * dot(acc, state.velocity) + imposed_turning_power(load, base, state)


@generic
def load_base_energy(base, load, state, gravity):
    """Return (kinetic, potential) energy [J] of the load in the world less those relative to the base (BaseState)."""
    return 0.0, 0.0


@load_base_energy.register(BaseState)
def _(base, load, state, gravity):
    kinetic, potential = added_energy(base, gravity, load.mass, state.position, state.velocity)
    return kinetic + turning_base_energy(load, base, state), potential


@generic
def turning_base_energy(load, base, state):
    """Return the kinetic energy [J] of the load's turning in the world less that relative to the base."""
    return 0.0


@turning_base_energy.register(RigidLoad)
def _(load, base, state):
    w = rotate_to_base(state.rows, base.angular_velocity)
    carried = multiply(load.inertia, w)
    return dot(state.omega, carried) + 0.5 * dot(w, carried)
