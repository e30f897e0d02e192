"""A rigid load on n elastic falls below any support: equations of motion.

Fall i leads from the point a_i, fixed in the support's frame and given from its tip, to b_i of the load, given from its
centre of mass in its own axes. Of its unstretched length L_i = l + δ_i the winch drives l, common to all. With the
distance ℓ_i of the two points and the elongation e_i = ℓ_i - L_i it pulls with

    T_i = (EA_i / L_i) (e_i + τ e_i'),

and a slack one with nothing. The rope on the drum is unstretched, so that a winch that pays out loses T + T²/(2 EA) for
each metre: what the rope pulls, and the energy of the strain that goes with it. A rope over sheaves takes that sum over
the falls for the pull of all of its parts (`supports.reeving`): sheaves turn with l', the stretch of a fall moves none.

State: one array [support, (l), r, q, and their rates, (energy supplied), modes] with the position r of the centre of
mass and the attitude q (unit quaternion) in the axes of the base; a mode is 1 for a taut fall, 0 for a slack one. The
mode of a winch with friction, the number of exchanges of the load, where it has any, and the modes of contact stand
behind the falls'. Loads that are
exchanged have the coordinates r of the first one's centre of mass, a point that stays fixed in their axes.
The falls' forces are functions of the state: contact concerns the load alone.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.models.attitude import align_quaternion, angular_velocity_of, quaternion_acceleration, rotation_of
from crane_sim.models.contact.forces import add_contact
from crane_sim.models.contact.rigid import NormalForces
from crane_sim.models.contact.surface import CompliantContact, RigidContact, wrench_power
from crane_sim.models.effects import PayloadDrag, PayloadForce
from crane_sim.models.energy_meter import Meter, meter_size
from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import (
    base_kinematics_at,
    cross,
    dot,
    imposed_acceleration,
    rotate_to_base,
    to_turned_axes,
)
from crane_sim.models.stops import Stops
from crane_sim.models.supports.backlash import drive_accelerations, play_power
from crane_sim.models.supports.hoist import Hoist, hoist_coordinates, hoist_modes
from crane_sim.models.supports.joint_modes import write_friction_rates
from crane_sim.models.supports.reeved_hoist import ReevedHoist, winch_mode, winch_power, winch_response
from crane_sim.models.supports.support import (
    Dynamics,
    Posture,
    Support,
    accelerations,
    arm_of,
    bare_tip,
    base_efforts,
    compute_dynamics,
    compute_posture,
    coordinate_count,
    drive_power,
    joint_efforts,
    net_efforts,
    prescribed_accelerations,
    read_state,
    tip_efforts,
    wind_efforts,
    yaw_efforts,
)
from crane_sim.models.suspended.crane import load_force
from crane_sim.models.suspended.exchange import Exchange, body_of_coordinates, current_load, exchange_modes
from crane_sim.models.suspended.load_dynamics import (
    BodyState,
    add,
    angular_acceleration,
    coordinate_acceleration,
    from_centre,
    imposed_load_power,
    multiply,
    subtract,
)
from crane_sim.models.wind_load import airflow_at
from crane_sim.multibody import linear
from crane_sim.multibody.tree import to_tree_axes
from crane_sim.multibody.vectors import scale
from crane_sim.numerics.jit import generic, routine
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


class Fall(NamedTuple):
    """One fall at one instant, in the axes of the base."""

    n: tuple[float, float, float]  # unit vector from the load's point to the support's
    lever: tuple[float, float, float]  # m, of the load's point from its centre of mass
    top: tuple[float, float, float]  # m, of the support's point from the tip, in the support's frame
    spring: float  # N, EA e / L, also where it is slack
    tension: float  # N, with the damping, also where it is slack
    damping: float  # W, that the damper takes while taut
    rate: float  # m/s, of the elongation


class Pull(NamedTuple):
    """Sum over the falls."""

    force: tuple[float, float, float]  # N, on the load, in the axes of the base
    moment: tuple[float, float, float]  # N m, on the load about its centre of mass, in the axes of the base
    couple: float  # N m, on the support about the vertical through the tip
    paid: float  # N, Σ T + T²/(2 EA): on the length
    damping: float  # W, that dampers take


class FallsSolution(NamedTuple):
    """Motion and forces at one instant."""

    pose: Posture  # of the support
    dynamics: Dynamics
    support: Any  # accelerations of its coordinates
    length: float  # m/s², acceleration of the falls' common length
    centre: tuple[float, float, float]  # m/s², of the load
    alpha: tuple[float, float, float]  # rad/s², of the load, in its own axes
    load: BodyState
    pull: Pull
    given: Any  # by `load_force`
    tip_force: tuple[float, float, float]  # N, of all falls on the tip, in the tree's axes
    tau: Any  # efforts on the coordinates of drives, springs, base, wind and falls
    net: Any  # what accelerates the coordinates: `net_efforts`
    command: Any  # efforts of the drives
    base: Any
    normal_forces: Any  # of contact, None without


def falls_layout(p):
    """Return (number nq of coordinates, index of the load's first one, index of the first mode)."""
    first = coordinate_count(p.support) + hoist_coordinates(p.hoist)
    nq = first + 7
    return nq, first, 2 * nq + meter_size(p.energy_meter)


def winch_index(p):
    """Return the index of the winch's mode, where it has friction."""
    return falls_layout(p)[2] + len(p.falls.offset)


def exchange_index(p):
    """Return the index of the number of exchanges, where the model has it."""
    return winch_index(p) + hoist_modes(p.hoist)


@generic
def common_length(hoist, p, x, nq):
    """Return (unstretched length [m] of the falls, its rate [m/s])."""
    i = coordinate_count(p.support)
    return x[i], x[nq + i]


@common_length.register(type(None))
def _(hoist, p, x, nq):
    return p.falls.length, 0.0


def body_state(p, x):
    """Return the load's kinematics in state x."""
    nq, first, _ = falls_layout(p)
    quaternion, rate = align_quaternion(x, first + 3, nq + first + 3)
    i = nq + first
    position, velocity = (x[first], x[first + 1], x[first + 2]), (x[i], x[i + 1], x[i + 2])
    omega = angular_velocity_of(quaternion, rate)
    state = BodyState(position, velocity, rotation_of(quaternion), omega, quaternion)
    return body_of_coordinates(p.exchange, p.load, x, exchange_index(p), state)


def body_of(p, x):
    """Return the parameters of the load in state x."""
    return current_load(p.exchange, p.load, x, exchange_index(p))


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


@generic
def taut_fall(contact, fall):
    """Return a taut fall as it pulls."""
    return fall


@taut_fall.register(RigidContact)
@taut_fall.register(CompliantContact)
def _(contact, fall):
    return without_push(fall)


def without_push(fall):
    """Return the fall, a slack one where it would push: less than a step's guards see, beside a load that is held."""
    if fall.tension >= 0.0:
        return fall
    return Fall(fall.n, fall.lever, fall.top, fall.spring, 0.0, -fall.spring * fall.rate, fall.rate)


def sum_falls(p, x, pose, tip, load):
    """Return the Pull of all falls; arguments of `fall_state`."""
    nq, _, modes = falls_layout(p)
    force, moment, couple, paid, damping = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0
    length = common_length(p.hoist, p, x, nq)
    for i in range(len(p.falls.offset)):
        taut = x[modes + i]
        fall = taut_fall(p.contact, fall_state(p.falls, i, pose, tip, load, length))
        tension = taut * fall.tension
        pull = tension * fall.n[0], tension * fall.n[1], tension * fall.n[2]
        force, moment = add(force, pull), add(moment, cross(fall.lever, pull))
        fx, fy, _ = to_turned_axes(pull, *pose.heading)
        couple -= fall.top[0] * fy - fall.top[1] * fx
        strain = taut * fall.spring * fall.spring / (2.0 * p.falls.axial_stiffness[i])
        paid += tension + strain
        damping += taut * fall.damping
    return Pull(force, moment, couple, paid, damping)


def kinematics_of(p, x):
    """Return what `fall_state` takes besides the falls and a number, in state x."""
    nq, _, _ = falls_layout(p)
    pose = compute_posture(p.support, read_state(p.support, x, nq))
    return pose, bare_tip(pose), body_state(p, x), common_length(p.hoist, p, x, nq)


@routine
def solve_dynamics(p, t, x, tau):
    """Return motion and forces at time t in state x under joint efforts tau."""
    nq, _, _ = falls_layout(p)
    pose, base = compute_posture(p.support, read_state(p.support, x, nq)), base_kinematics_at(p.base, p.gravity, t)
    load, body, turn = body_state(p, x), body_of(p, x), pose.kinematics.turn
    pull, flow = sum_falls(p, x, pose, bare_tip(pose), load), airflow_at(p.wind, p.base, t, 0.0)
    given = load_force(p, body, t, flow, base, load)
    dynamics = compute_dynamics(p.support, pose)
    efforts = linear.add(joint_efforts(p.support, pose, tau), base_efforts(pose, base))
    efforts = linear.add(efforts, wind_efforts(pose, flow, base))
    efforts = linear.add(efforts, yaw_efforts(pose, pull.couple))
    tip_force = scale(-1.0, to_tree_axes(turn, pull.force))
    net = linear.add(net_efforts(dynamics, p.gravity, efforts), tip_efforts(pose, tip_force))
    qdd = accelerations(dynamics, net, prescribed_accelerations(p.support, pose, tau))
    motion, at = (*common_length(p.hoist, p, x, nq), p.gravity), (nq + coordinate_count(p.support), winch_index(p))
    inv_mass, bias_acc = winch_response(p.hoist, t, tau, x, at, motion)
    free, length = load_acceleration(p, body, base, load, pull, given), bias_acc + inv_mass * pull.paid
    centre, alpha, normal_forces = add_contact(p.contact, body, t, x, contact_index(p), load, free)
    return FallsSolution(
        pose, dynamics, qdd, length, centre, alpha, load, pull, given, tip_force, efforts, net, tau, base, normal_forces
    )


def load_acceleration(p, body, base, load, pull, given):
    """Return the load's accelerations without contact: (centre (3,) in the base's axes, α (3,) in its own).

    `given` is by `load_force`.
    """
    force, moment = given
    ax, ay, az = add(pull.force, force)
    imposed, m = imposed_acceleration(base, load.position, load.velocity), body.mass
    centre = imposed[0] + ax / m, imposed[1] + ay / m, imposed[2] + az / m - p.gravity
    alpha = angular_acceleration(body, base, load, add(moment, rotate_to_base(load.rows, pull.moment)))
    return centre, alpha


def contact_index(p):
    """Return the index of the first mode of contact."""
    return exchange_index(p) + exchange_modes(p.exchange)


@system.rhs_into.register(FallsCrane)
def _(p, t, x, u, out, work):
    write_falls_derivative(p, t, x, u, out)


@routine
def write_falls_derivative(p, t, x, u, out):
    """Write the time derivative of the state into `out`."""
    nq, first, modes = falls_layout(p)
    tau = system.effort(u, p, t, x)
    solved, ns = solve_dynamics(p, t, x, tau), coordinate_count(p.support)
    for i in range(nq):
        out[i] = x[nq + i]
    for i in range(len(solved.support)):
        out[nq + i] = solved.support[i]
    if first > ns:
        out[nq + ns] = solved.length
    i = nq + first
    out[i], out[i + 1], out[i + 2] = coordinate_acceleration(solved.load, solved.centre, solved.alpha)
    second = quaternion_acceleration(solved.load.quaternion, solved.load.omega, solved.alpha)
    out[i + 3], out[i + 4], out[i + 5], out[i + 6] = second
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    for k, drive_acc in enumerate(drive_accelerations(p.support.drives, solved.command, solved.pose.state)):
        out[nq + len(solved.support) + k] = drive_acc
    write_friction_rates(p.support, solved.pose.state, out)
    if modes > 2 * nq:
        out[2 * nq] = falls_power(p, t, x, solved)


def falls_power(p, t, x, solved):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    (nq, _, _), body = falls_layout(p), body_of(p, x)
    load, pull, motion = solved.load, solved.pull, (*common_length(p.hoist, p, x, nq), solved.length)
    given, moment = solved.given
    power = drive_power(solved.pose, solved.tau, solved.tip_force)
    power += play_power(p.support.drives, solved.command, solved.pose.state)
    mode = winch_mode(p.hoist, x, winch_index(p))
    winch = winch_power(p.hoist, solved.command, mode, motion, pull.paid, p.gravity)
    power += winch + imposed_load_power(solved.base, body, load)
    power += dot(given, load.velocity) + dot(moment, load.omega)
    return add_contact_power(solved.normal_forces, load, power - pull.damping - pull.couple * solved.pose.yaw_rate)


@generic
def add_contact_power(normal_forces, load, power):
    """Return the sum of `power` [W] and the power of contact."""
    return power


@add_contact_power.register(NormalForces)
def _(normal_forces, load, power):
    return power + wrench_power(normal_forces.wrench, load)
