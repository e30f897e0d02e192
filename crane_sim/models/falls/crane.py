"""A rigid load on n elastic falls below any support: equations of motion.

Fall i leads from the point a_i, fixed in the support's frame and given from its tip, to b_i of the
load, given from its centre of mass in its own axes. Of its unstretched length L_i = l + δ_i the
winch drives l, common to all. With the distance ℓ_i of the two points and the elongation e_i = ℓ_i
- L_i it pulls with

    T_i = (EA_i / L_i) (e_i + τ e_i'),

and a slack one with nothing. The rope on the drum is unstretched, so that a winch that pays out
loses T + T²/(2 EA) for each metre: what the rope pulls, and the energy of the strain that goes with
it. A rope over sheaves takes that sum over the falls for the pull of all of its parts
(`supports.reeving`): sheaves turn with l', the stretch of a fall moves none. The falls together
have `falls` times the number of ropes parts; lead lines of several ropes are one, of their sum.

State: one array [support, (l), r, q, and their rates, (energy supplied), modes] with the position r
of the centre of mass and the attitude q (unit quaternion) in the axes of the base; a mode is 1 for
a taut fall, 0 for a slack one. Other modes stand behind the falls' (`carrier.layout`). Loads that
are exchanged have the coordinates r of the first one's centre of mass, a point that stays fixed in
their axes.
The falls' forces are functions of the state: contact concerns the load alone. Joint coordinates are
the support's, l where a winch changes it, r, and q in the order (w, x, y, z).
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.models.carrier.dynamics import (
    SupportMotion,
    carrier_energies,
    move_support,
    posture_of,
    support_power,
    winch_power,
    winch_response,
    write_common_rates,
    write_polyline,
)
from crane_sim.models.carrier.exchange import Exchange, body_of_coordinates, load_of
from crane_sim.models.carrier.layout import contact_index, layout_of, rope_length
from crane_sim.models.contact.forces import add_contact
from crane_sim.models.contact.surface import CompliantContact, RigidContact, wrench_power
from crane_sim.models.effects import PayloadDrag, PayloadForce
from crane_sim.models.energy_meter import Meter
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.loads import (
    BodyState,
    RigidLoad,
    align_quaternion,
    angular_acceleration,
    centre_acceleration,
    coordinate_acceleration,
    from_centre,
    imposed_load_power,
    load_energies,
    load_force,
    quaternion_at,
)
from crane_sim.models.moving_base import base_kinematics_at, pose_at, rotate_to_base, to_world
from crane_sim.models.stops import Stops
from crane_sim.models.supports.hoist import Hoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.support import Support, arm_of, bare_tip
from crane_sim.models.wind_kink import pressed_point, pressed_point_of
from crane_sim.models.wind_load import airflow_at
from crane_sim.multibody import linear
from crane_sim.multibody.attitude import angular_velocity, quaternion_acceleration, rotation
from crane_sim.multibody.tree import to_tree_axes
from crane_sim.multibody.vectors import (
    Vector,
    add,
    cross,
    dot,
    multiply,
    scale,
    subtract,
    to_turned_axes,
)
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.wind import Wind


class Falls(NamedTuple):
    """Elastic ropes between support and load, arrays of n."""

    top: Any  # (n, 3) m, from the tip, in the support's frame
    bottom: Any  # (n, 3) m, from the first load's centre of mass, in its axes
    length: float  # m, unstretched, where no winch changes it
    offset: Any  # (n,) m, added to that length
    axial_stiffness: Any  # (n,) N, EA of all parts of the fall together
    relaxation: Any  # (n,) s, τ of the damping


class FallsCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    support: Support
    falls: Falls
    load: RigidLoad  # its attachment is where loads that are exchanged meet
    hoist: Hoist | ReevedHoist | None = None
    gravity: float = 9.81  # m/s²
    drag: PayloadDrag | None = None
    energy_meter: Meter | None = None
    base: AnyBase | None = None
    force: PayloadForce | None = None
    stops: Stops | None = None
    wind: Wind | None = None
    contact: RigidContact | CompliantContact | None = None
    exchange: Exchange | None = None  # of the load

    def hanging_coordinates(self):
        """Return the number of coordinates of the load: its position and its attitude."""
        return 7

    def cable_modes(self):
        """Return the number of falls, each of which has a mode."""
        return len(self.falls.offset)

    def fixed_length(self):
        """Return the unstretched length [m] of the falls, where no hoist changes it."""
        return self.falls.length


class Fall(NamedTuple):
    """One fall at one instant, in the axes of the base."""

    n: Vector  # unit vector from the load's point to the support's
    lever: Vector  # m, of the load's point from its centre of mass
    top: Vector  # m, of the support's point from the tip, in the support's frame
    spring: float  # N, EA e / L, also where it is slack
    tension: float  # N, with the damping, also where it is slack
    damping: float  # W, that the damper takes while taut
    rate: float  # m/s, of the elongation


class Pull(NamedTuple):
    """Sum over the falls."""

    force: Vector  # N, on the load, in the axes of the base
    moment: Vector  # N m, on the load about its centre of mass, in the axes of the base
    couple: float  # N m, on the support about the vertical through the tip
    paid: float  # N, Σ T + T²/(2 EA): on the length
    damping: float  # W, that dampers take


class FallsSolution(NamedTuple):
    """Motion and forces at one instant."""

    support: SupportMotion
    length: Any  # m/s², acceleration of the falls' common length
    paid: Any  # N, pull of all falls on their length
    centre: Vector  # m/s², of the load
    alpha: Vector  # rad/s², of the load, in its own axes
    load: BodyState
    pull: Pull
    given: Any  # by `load_force`
    base: Any
    normal_forces: Any  # of contact, None without


def body_state(p, x):
    """Return the load's kinematics in state x."""
    nq, first, _ = layout_of(p)
    quaternion, rate = quaternion_at(x, first + 3, nq + first + 3)
    i = nq + first
    position, velocity = (x[first], x[first + 1], x[first + 2]), (x[i], x[i + 1], x[i + 2])
    state = BodyState(
        position, velocity, rotation(quaternion), angular_velocity(quaternion, rate), quaternion
    )
    return body_of_coordinates(p, x, state)


def fall_state(falls, i, pose, tip, load, length):
    """Return Fall number i.

    Args:
        falls, i: the falls, number of this one.
        pose: posture of the support.
        tip: (position, velocity) of the tip relative to the base.
        load: BodyState.
        length: (unstretched length without the offset, its rate).
    """
    top = falls.top[i, 0], falls.top[i, 1], falls.top[i, 2]
    arm = arm_of(pose, top)
    bottom = from_centre(load, (falls.bottom[i, 0], falls.bottom[i, 1], falls.bottom[i, 2]))
    lever, moves = multiply(load.rows, bottom), multiply(load.rows, cross(load.omega, bottom))
    dx, dy, dz = subtract(add(tip[0], arm), add(load.position, lever))
    vx, vy, vz = subtract(tip[1], add(load.velocity, moves))
    vx, vy = vx - pose.yaw_rate * arm[1], vy + pose.yaw_rate * arm[0]
    distance, rest = sqrt(dx * dx + dy * dy + dz * dz), length[0] + falls.offset[i]
    n, stiffness = (dx / distance, dy / distance, dz / distance), falls.axial_stiffness[i] / rest
    rate = n[0] * vx + n[1] * vy + n[2] * vz - length[1]
    spring, damping = stiffness * (distance - rest), stiffness * falls.relaxation[i] * rate
    return Fall(n, lever, top, spring, spring + damping, damping * rate, rate)


def taut_fall(contact, fall):
    """Return a taut fall as it pulls: beside a load that is held a slack one where it would push.

    It pushes by less than a step's guards see.
    """
    if contact is None:
        return fall
    return (
        fall
        if fall.tension >= 0.0
        else fall._replace(tension=0.0, damping=-fall.spring * fall.rate)
    )


def sum_falls(p, x, pose, tip, load, length):
    """Return the Pull of all falls; arguments of `fall_state`."""
    _, _, modes = layout_of(p)
    force, moment, couple, paid, damping = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0
    for i in range(len(p.falls.offset)):
        taut = x[modes + i]
        fall = taut_fall(p.contact, fall_state(p.falls, i, pose, tip, load, length))
        tension = taut * fall.tension
        pull = scale(tension, fall.n)
        force, moment = add(force, pull), add(moment, cross(fall.lever, pull))
        fx, fy, _ = to_turned_axes(pull, *pose.heading)
        couple -= fall.top[0] * fy - fall.top[1] * fx
        strain = taut * fall.spring * fall.spring / (2.0 * p.falls.axial_stiffness[i])
        paid += tension + strain
        damping += taut * fall.damping
    return Pull(force, moment, couple, paid, damping)


def kinematics_of(p, x):
    """Return what `fall_state` takes besides the falls and a number, in state x."""
    pose = posture_of(p, x)
    return pose, bare_tip(pose), body_state(p, x), rope_length(p, x)


@routine
def solve_dynamics(p, t, x, tau):
    """Return motion and forces at time t in state x under joint efforts tau."""
    base, body, kinematics = (
        base_kinematics_at(p.base, p.gravity, t),
        load_of(p, x),
        kinematics_of(p, x),
    )
    pose, _, load, _ = kinematics
    pull, flow = sum_falls(p, x, *kinematics), airflow_at(p.wind, p.base, t, 0.0)
    tip_force = scale(-1.0, to_tree_axes(pose.kinematics.turn, pull.force))
    support = move_support(p, t, pose, tau, flow, base, pull.couple, tip_force)
    inv_mass, bias_acc = winch_response(p, t, x, tau)
    given = load_force(p, body, t, flow, base, load)
    free = load_acceleration(p, body, base, load, pull, given)
    contact = add_contact(p.contact, body, t, x, contact_index(p), load, free)
    return FallsSolution(
        support,
        bias_acc + inv_mass * pull.paid,
        pull.paid,
        contact.centre,
        contact.alpha,
        load,
        pull,
        given,
        base,
        contact.normal_forces,
    )


def load_acceleration(p, body, base, load, pull, given):
    """Return the load's accelerations without contact.

    They are (centre (3,) in the base's axes, α (3,) in the load's own).

    `given` is by `load_force`.
    """
    force, moment = given
    centre = centre_acceleration(body, base, load, add(pull.force, force), p.gravity)
    alpha = angular_acceleration(
        body, base, load, add(moment, rotate_to_base(load.rows, pull.moment))
    )
    return centre, alpha


@system.rhs_into.register(FallsCrane)
@routine
def write_falls_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, _ = layout_of(p)
    solved, i = solve_dynamics(p, t, x, system.effort(u, p, t, x)), nq + first
    write_common_rates(p, x, solved, out)
    out[i], out[i + 1], out[i + 2] = coordinate_acceleration(
        solved.load, solved.centre, solved.alpha
    )
    second = quaternion_acceleration(solved.load.quaternion, solved.load.omega, solved.alpha)
    out[i + 3], out[i + 4], out[i + 5], out[i + 6] = second
    if p.energy_meter is not None:
        out[2 * nq] = falls_power(p, x, solved)


def falls_power(p, x, solved):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    load, pull, (force, moment) = solved.load, solved.pull, solved.given
    imposed = imposed_load_power(solved.base, load_of(p, x), load)
    power = support_power(p, solved) + (winch_power(p, x, solved) + imposed)
    power += dot(force, load.velocity) + dot(moment, load.omega)
    power = power - pull.damping - pull.couple * solved.support.pose.yaw_rate
    return power if p.contact is None else power + wrench_power(solved.normal_forces.wrench, load)


@system.project_in_place.register(FallsCrane)
@routine
def normalise(p, x):
    """Give the quaternion its length 1, and take from its rates what is not across it."""
    nq, first, _ = layout_of(p)
    align_quaternion(x, first + 3, nq + first + 3)


@routine
def initialize_fall_modes(p, x):
    """Set each fall's mode to that of its elongation."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        x[modes + i] = 1.0 if min(fall.spring, fall.tension) > 0.0 else 0.0


@system.tensions.register(FallsCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all falls [N]."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for k in range(len(p.falls.offset)):
        fall = taut_fall(p.contact, fall_state(p.falls, k, *kinematics))
        rows[i, first + k] = x[modes + k] * fall.tension


@routine
def falls_energies(p, base, x):
    """Return the energies [J] of the crane, see `carrier_energies`."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    pose, _, load, (length, _) = kinematics
    total = carrier_energies(p, base, x, pose)
    total = linear.add(total, load_energies(base, load_of(p, x), load, p.gravity))
    for i in range(len(p.falls.offset)):
        spring, rest = fall_state(p.falls, i, *kinematics).spring, length + p.falls.offset[i]
        stored = x[modes + i] * 0.5 * spring * spring * rest / p.falls.axial_stiffness[i]
        total = linear.add(total, (0.0, stored, 0.0, 0.0))
    return total


@system.points.register(FallsCrane)
def write_points(p, t, x, out):
    """Write support and load in the world into out (N, 3)."""
    (_, first, _), base = layout_of(p), pose_at(p.base, t)
    i = write_polyline(posture_of(p, x), base, out)
    out[i, 0], out[i, 1], out[i, 2] = to_world(base, (x[first], x[first + 1], x[first + 2]))


@pressed_point.register(FallsCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    return pressed_point_of(load_of(p, x), body_state(p, x))


@routine
def falls_guard(p, best, x):
    """Return the smaller one of `best` and the guards of taut and slack falls."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        value = fall.tension if x[modes + i] > 0.0 else -min(fall.spring, fall.tension)
        best = smaller_guard(best, value, encode(Guard.LINK, i))
    return best
