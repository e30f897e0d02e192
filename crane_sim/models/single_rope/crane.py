"""A crane: support x cable x payload and their effects, put together.

State x = (support state, payload state), then the energy supplied [J] when the crane is metered,
then four floats of the joints' friction where there is some.

Outputs: joint coordinates, energies, accelerations, points in the world.
"""

from math import cos, sin
from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.models.cables.rope import (
    ForceRope,
    LockedRope,
    MotionRope,
    RopeKinematics,
    add_rope_energy,
    limit_winch,
    project_to_rope,
    rope_kinematics,
    swing_angles,
)
from crane_sim.models.effects import PayloadDrag, PayloadForce, SwingFriction, add_drag
from crane_sim.models.energy_meter import Meter, meter_entry
from crane_sim.models.loads import PointLoad
from crane_sim.models.moving_base import (
    add_imposed,
    added_energy,
    airspeed,
    base_kinematics_at,
    base_state,
    pose_at,
    to_base,
    to_world,
    turned_about_z,
)
from crane_sim.models.rotating_frame import frame_acceleration, inertial_velocity
from crane_sim.models.single_rope.joint_coordinates import (
    actuated_joints,
    efforts_from_row,
    joint_accelerations,
    joint_coordinates,
    state_from_joints,
)
from crane_sim.models.single_rope.joint_friction import (
    JointFriction,
    add_joint_friction,
    friction_rates,
    hold_joints,
    hold_rope,
    initial_friction_states,
)
from crane_sim.models.stops import Stops
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.wind_load import add_wind, airflow_at
from crane_sim.multibody.vectors import add, dot, scale, subtract, to_turned_axes
from crane_sim.numerics.elementary import sincos
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.inputs import value_at
from crane_sim.trajectories.wind import Wind


class Crane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    support: Any  # a Knuckle or a DrivenPoint
    cable: ForceRope | MotionRope | LockedRope
    load: PointLoad
    gravity: float = 9.81  # m/s²
    swing_friction: SwingFriction | None = None
    drag: PayloadDrag | None = None
    energy_meter: Meter | None = None
    base: AnyBase | None = None
    force: PayloadForce | None = None
    stops: Stops | None = None
    wind: Wind | None = None
    friction: JointFriction | None = None


class CraneMotion(NamedTuple):
    """Rope, accelerations and forces at one instant, from the state and the efforts."""

    pose: NamedTuple
    rope_state: RopeKinematics
    support_acceleration: tuple[float, float, float]  # joint accelerations of the support
    payload_acceleration: tuple[float, float, float]  # second rates of change of the payload's
    # coordinates
    tension: float
    tip_force: tuple[float, float, float]  # N, of rope and swing joints on the tip
    efforts: Any  # on the joints (nu,): of drives, base, friction of joints and of the swing
    base: Any  # BaseKinematics in the axes of the support's frame, None for a base at rest
    flow: Any  # of the wind in those axes, None without
    driven: Any  # N m, N, efforts (nu,) of drives, base and wind alone


def add_swing_friction(friction, rope_state, force, reaction, tau, support):
    """Return (force on payload, reaction on tip, joint efforts) with the swing joints' friction.

    The friction is internal: what it pulls on the payload it pushes on the tip, and the couple
    between the two turns the support about the vertical (the swing angles are measured in its
    frame).
    """
    if friction is None:
        return force, reaction, tau
    s1, c1, c2, w1, w2 = swing_angles(rope_state)
    a1, a2 = friction.moments(rope_state.n, w1, w2)
    nx, inverse = rope_state.n[0], -1.0 / rope_state.length
    pull = (
        inverse * a2 * c2,
        inverse * (a1 * c1 - a2 * s1 * nx),
        inverse * (a1 * s1 + a2 * c1 * nx),
    )
    couple = rope_state.length * (rope_state.n[1] * pull[0] - nx * pull[1])
    return add(force, pull), subtract(reaction, pull), support.add_yaw_moment(tau, couple)


def friction_power(friction, rope_state):
    """Return the power [W] that the swing joints' friction takes out, negative."""
    if friction is None:
        return 0.0
    _, _, _, w1, w2 = swing_angles(rope_state)
    a1, a2 = friction.moments(rope_state.n, w1, w2)
    return -a1 * w1 - a2 * w2


def add_payload_force(p, force, t, xs):
    """Return the force (3,) [N] plus that on the payload at time t, in the support's axes."""
    if p.force is None:
        return force
    s, c = sincos(p.support.yaw(xs))
    world = value_at(p.force.x, t), value_at(p.force.y, t), value_at(p.force.z, t)
    return add(force, to_turned_axes(to_base(pose_at(p.base, t), world), s, c))


def base_of(p, t, xs):
    """Return the base at time t in the axes of the support's frame, None where it rests."""
    return turned_about_z(base_kinematics_at(p.base, p.gravity, t), p.support.yaw(xs))


def solve_motion(p, t, x, tau):
    """Return the CraneMotion of crane p at time t in state x under joint efforts tau."""
    xs, xc = x[0], x[1]
    pose = hold_joints(p.friction, p.support.forward_kinematics(xs), x)
    rope_state = rope_kinematics(pose, xc)
    position, velocity, w = xc[:3], xc[3:], pose.yaw_rate
    base, moving = base_of(p, t, xs), inertial_velocity(position, velocity, w)
    force = add_imposed(base, p.load.mass, (0.0, 0.0, -p.load.mass * p.gravity), position, moving)
    flow, air = airflow_at(p.wind, p.base, t, p.support.yaw(xs)), airspeed(base, position, moving)
    force = add_payload_force(p, add_drag(p.drag, force, air), t, xs)
    force = add_wind(flow, p.load.windage, force, position, air)
    driven = p.support.add_base_efforts(tau, base, pose)
    driven = p.support.add_wind_efforts(driven, flow, base, pose)
    tau = add_joint_friction(p.friction, driven, rope_state, x)
    force, reaction, tau = add_swing_friction(
        p.swing_friction, rope_state, force, (0.0, 0.0, 0.0), tau, p.support
    )
    tension = p.cable.tension(p, pose, rope_state, tau, force, reaction)
    pull = scale(tension, rope_state.n)
    tip = add(reaction, pull)
    qdd = p.support.accelerations(pose, p.gravity, tau, tip)
    _, w_dot = p.support.tip_acceleration(pose, qdd)
    inertial = scale(1.0 / p.load.mass, subtract(force, pull))
    payload_acceleration = frame_acceleration(inertial, position, velocity, w, w_dot)
    return CraneMotion(
        pose, rope_state, qdd, payload_acceleration, tension, tip, tau, base, flow, driven
    )


@system.rate_entries.register(Crane)
def rate_entries(p):
    """Return the entries of support and payload."""
    return ((0, 3), (6, 3))


@system.rhs.register(Crane)
def state_derivative(p, t, x, u):
    """Return the derivative of the state."""
    tau = system.effort(u, p, t, x)
    motion = solve_motion(p, t, x, tau)
    power = () if p.energy_meter is None else (supplied_power(p, t, x, tau, motion),)
    rates = (*power, *friction_rates(p.friction, x, motion.rope_state.rate))
    return (
        (*x[0][3:], *motion.support_acceleration),
        (*x[1][3:], *motion.payload_acceleration),
        *rates,
    )


@system.power.register(Crane)
def external_power(p, t, x, u):
    """Return the power [W] under a source of efforts."""
    tau = system.effort(u, p, t, x)
    return supplied_power(p, t, x, tau, solve_motion(p, t, x, tau))


def supplied_power(p, t, x, tau, motion):
    """Return the power [W] of drives, imposed motions, forces and losses.

    `motion` is by `solve_motion`.
    """
    base, pose, flow, rope_state = motion.base, motion.pose, motion.flow, motion.rope_state
    position, moving = x[1][:3], inertial_velocity(x[1][:3], x[1][3:], pose.yaw_rate)
    air = airspeed(base, position, moving)
    force = add_payload_force(p, add_drag(p.drag, (0.0, 0.0, 0.0), air), t, x[0])
    force = add_imposed(
        base, p.load.mass, add_wind(flow, p.load.windage, force, position, air), position, moving
    )
    tau, driven = add_joint_friction(p.friction, tau, rope_state, x), motion.driven
    if p.friction is not None:
        driven = p.support.add_wind_efforts(
            p.support.add_base_efforts(tau, base, pose), flow, base, pose
        )
    joints = p.support.power(driven, pose, motion.tip_force) + p.cable.power(
        tau, rope_state, motion.tension
    )
    (fx, fy, fz), (vx, vy, vz) = force, moving
    return joints + fx * vx + fy * vy + fz * vz + friction_power(p.swing_friction, rope_state)


@system.project.register(Crane)
def project(p, x):
    """Return the state with what drives and friction hold exactly."""
    pose = p.support.forward_kinematics(x[0])
    xc = hold_rope(p.friction, x, project_to_rope(p.cable, pose, x[1]), rope_kinematics(pose, x[1]))
    return (x[0], xc, *x[2:])


@system.tensions.register(Crane)
def write_tension(p, t, x, u, rows, i, first):
    """Write the rope's tension [N]."""
    rows[i, first] = solve_motion(p, t, x, system.effort(u, p, t, x)).tension


system.saturate.register(Crane)(limit_winch)
system.joints.register(Crane)(joint_coordinates)
system.actuated_joints.register(Crane)(actuated_joints)
system.efforts_from_row.register(Crane)(efforts_from_row)


@system.state.register(Crane)
def initial_state(p, t, q, v):
    """Return the state, with no energy supplied yet."""
    parts = state_from_joints(p, q, v)
    return (*parts, *meter_entry(p.energy_meter, 0.0), *initial_friction_states(p.friction, v))


@system.acceleration.register(Crane)
def accelerations_of_crane(p, t, x, u):
    """Return the accelerations of the joints of support, rope and swing."""
    return joint_accelerations(p, solve_motion(p, t, x, system.effort(u, p, t, x)))


@system.kinetic.register(Crane)
def kinetic_energy(p, x):
    """Return the kinetic energy [J] of support and payload."""
    pose = p.support.forward_kinematics(x[0])
    moving = inertial_velocity(x[1][:3], x[1][3:], pose.yaw_rate)
    return p.support.kinetic(pose) + 0.5 * p.load.mass * dot(moving, moving)


@system.potential.register(Crane)
def potential_energy(p, x):
    """Return the potential energy [J] of support, payload and the rope's spring."""
    pose = p.support.forward_kinematics(x[0])
    energy = p.support.potential(pose, p.gravity) + p.gravity * p.load.mass * x[1][2]
    return add_rope_energy(p.cable, energy, rope_kinematics(pose, x[1]).length)


@system.base_energy.register(Crane)
def base_energy(p, t, x):
    """Return what a moving base adds to the energies of support and payload."""
    base = base_state(p.base, t, p.support.yaw(x[0]))
    if base is None:
        return 0.0, 0.0
    pose = p.support.forward_kinematics(x[0])
    moving = inertial_velocity(x[1][:3], x[1][3:], pose.yaw_rate)
    kinetic, potential = added_energy(base, p.gravity, p.load.mass, x[1][:3], moving)
    others = p.support.base_energy(base, pose, p.gravity)
    return kinetic + others[0], potential + others[1]


@system.point_count.register(Crane)
def point_count(p):
    """Return the number of points of support and payload."""
    return 1 + p.support.polyline_size()


@system.tip_index.register(Crane)
def tip_index(p):
    """Return the index of the support's last point."""
    return p.support.polyline_size() - 1


@system.points.register(Crane)
def write_points(p, t, x, out):
    """Write the points of support and payload."""
    angle, pose = p.support.yaw(x[0]), pose_at(p.base, t)
    c, s = cos(angle), sin(angle)
    for i, (a, b, z) in enumerate((*p.support.polyline(x[0]), x[1][:3])):
        out[i, 0], out[i, 1], out[i, 2] = to_world(pose, (c * a - s * b, s * a + c * b, z))


@system.with_meter.register(Crane)
def with_meter(p, held):
    """Return the crane with a meter where it loses energy, or motion is imposed on it."""
    lossy = any(
        part is not None for part in (p.swing_friction, p.drag, p.force, p.wind, p.friction)
    )
    imposed = (
        isinstance(p.cable, MotionRope) or isinstance(p.support, DrivenPoint) or p.base is not None
    )
    return p._replace(energy_meter=Meter()) if lossy or imposed or not held else p


@system.energy_supplied.register(Crane)
def energy_supplied(p, x):
    """Return the meter's reading [J]."""
    return 0.0 if p.energy_meter is None else x[2]
