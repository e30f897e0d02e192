"""A crane: support x cable x payload and their effects, put together.

State x = (support state, payload state), then the energy supplied [J] when the crane is metered, then four floats of
the joints' friction where there is some.

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
    rope_tension,
    swing_angles,
    winch_power,
)
from crane_sim.models.effects import (
    LinearFriction,
    PaperFriction,
    PayloadDrag,
    PayloadForce,
    QuadraticFriction,
    add_drag,
    swing_moments,
)
from crane_sim.models.energy_meter import Meter, metered_like, metered_state, reading
from crane_sim.models.loads import PointLoad
from crane_sim.models.moving_base import (
    BaseState,
    add_imposed,
    added_energy,
    airspeed,
    base_kinematics_at,
    base_state,
    pose_at,
    to_base,
    to_turned_axes,
    to_world,
    turned_about_z,
)
from crane_sim.models.rotating_frame import frame_acceleration, inertial_velocity
from crane_sim.models.single_rope.joint_friction import (
    JointFriction,
    add_joint_friction,
    append_friction_rates,
    append_friction_states,
    hold_joints,
    keep_friction_states,
)
from crane_sim.models.stops import Stops
from crane_sim.models.supports import (
    actuated_joints,
    add_yaw_moment,
    drive_power,
    efforts_from_row,
    forward_kinematics,
    joint_accelerations,
    joint_coordinates,
    state_from_joints,
    support_acceleration,
    support_base_energy,
    support_kinetic,
    support_polyline,
    support_polyline_size,
    support_potential,
    tip_acceleration,
    with_base,
    with_wind,
    yaw,
)
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.wind_load import add_wind, airflow_at
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.inputs import value_at
from crane_sim.trajectories.wind import Wind

SwingFriction = QuadraticFriction | LinearFriction | PaperFriction


class Crane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    support: Any  # a Knuckle or a DrivenPoint, see `crane_sim.models.supports`
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
    payload_acceleration: tuple[float, float, float]  # second rates of change of the payload's coordinates
    tension: float
    tip_force: tuple[float, float, float]  # N, of rope and swing joints on the tip
    efforts: Any  # on the joints (nu,): of drives, base, friction of joints and of the swing
    base: Any  # BaseKinematics in the axes of the support's frame, None for a base at rest
    flow: Any  # of the wind in those axes, None without
    driven: Any  # N m, N, efforts (nu,) of drives, base and wind alone


@generic
def add_swing_friction(friction, rope_state, force, reaction, tau, support):
    """Return (force on the payload, reaction on the tip, joint efforts) with the swing joints' friction added.

    The friction is internal: what it pulls on the payload it pushes on the tip, and the couple between the two turns
    the support about the vertical (the swing angles are measured in its frame).
    """
    s1, c1, c2, w1, w2 = swing_angles(rope_state)
    a1, a2 = swing_moments(friction, rope_state.n, w1, w2)
    nx, inverse = rope_state.n[0], -1.0 / rope_state.length
    fx = inverse * a2 * c2
    fy = inverse * (a1 * c1 - a2 * s1 * nx)
    fz = inverse * (a1 * s1 + a2 * c1 * nx)
    couple = rope_state.length * (rope_state.n[1] * fx - nx * fy)
    force = (force[0] + fx, force[1] + fy, force[2] + fz)
    return force, (reaction[0] - fx, reaction[1] - fy, reaction[2] - fz), add_yaw_moment(support, tau, couple)


@add_swing_friction.register(type(None))
def _(friction, rope_state, force, reaction, tau, support):
    return force, reaction, tau


@generic
def friction_power(friction, rope_state):
    """Return the power [W] that the swing joints' friction takes out, negative."""
    _, _, _, w1, w2 = swing_angles(rope_state)
    a1, a2 = swing_moments(friction, rope_state.n, w1, w2)
    return -a1 * w1 - a2 * w2


@friction_power.register(type(None))
def _(friction, rope_state):
    return 0.0


@generic
def add_payload_force(payload_force, force, p, t, xs):
    """Return the force (3,) [N] plus that on the payload at time t, in the axes of the support's frame."""
    return force


@add_payload_force.register(PayloadForce)
def _(payload_force, force, p, t, xs):
    s, c = sincos(yaw(p.support, xs))
    world = value_at(payload_force.x, t), value_at(payload_force.y, t), value_at(payload_force.z, t)
    x, y, z = to_turned_axes(to_base(pose_at(p.base, t), world), s, c)
    return force[0] + x, force[1] + y, force[2] + z


def base_of(p, t, xs):
    """Return the base at time t in the axes of the support's frame, None where it rests."""
    return turned_about_z(base_kinematics_at(p.base, p.gravity, t), yaw(p.support, xs))


def solve_motion(p, t, x, tau):
    """Return the Motion of crane p at time t in state x under joint efforts tau."""
    xs, xc = x[0], x[1]
    pose = hold_joints(p.friction, forward_kinematics(p.support, xs), x)
    rope_state = rope_kinematics(pose, xc)
    position, velocity, w = xc[:3], xc[3:], pose.yaw_rate
    base, moving = base_of(p, t, xs), inertial_velocity(position, velocity, w)
    force = add_imposed(base, p.load.mass, (0.0, 0.0, -p.load.mass * p.gravity), position, moving)
    flow, air = airflow_at(p.wind, p.base, t, yaw(p.support, xs)), airspeed(base, position, moving)
    force = add_payload_force(p.force, add_drag(p.drag, force, air), p, t, xs)
    force = add_wind(flow, p.load.windage, force, position, air)
    driven = with_wind(p.support, with_base(p.support, tau, base, pose), flow, base, pose)
    tau = add_joint_friction(p.friction, driven, rope_state, x)
    force, reaction, tau = add_swing_friction(p.swing_friction, rope_state, force, (0.0, 0.0, 0.0), tau, p.support)
    tension = rope_tension(p.cable, p, pose, rope_state, tau, force, reaction)
    nx, ny, nz = tension * rope_state.n[0], tension * rope_state.n[1], tension * rope_state.n[2]
    tip = (reaction[0] + nx, reaction[1] + ny, reaction[2] + nz)
    qdd = support_acceleration(p.support, pose, p.gravity, tau, tip)
    _, w_dot = tip_acceleration(p.support, pose, qdd)
    inverse = 1.0 / p.load.mass
    inertial = ((force[0] - nx) * inverse, (force[1] - ny) * inverse, (force[2] - nz) * inverse)
    payload_acceleration = frame_acceleration(inertial, position, velocity, w, w_dot)
    return CraneMotion(pose, rope_state, qdd, payload_acceleration, tension, tip, tau, base, flow, driven)


@system.rate_entries.register(Crane)
def _(p):
    return ((0, 3), (6, 3))


@system.rhs.register(Crane)
def _(p, t, x, u):
    xs, xc = x[0], x[1]
    tau = system.effort(u, p, t, x)
    motion = solve_motion(p, t, x, tau)
    derivative = (*xs[3:], *motion.support_acceleration), (*xc[3:], *motion.payload_acceleration)
    derivative = append_power(p.energy_meter, derivative, p, t, x, tau, motion)
    return append_friction_rates(p.friction, derivative, x, motion.rope_state.rate)


@generic
def append_power(meter, derivative, p, t, x, tau, motion):
    """Return the derivative of a state of two parts, with the supplied power appended where the crane is metered."""
    return derivative


@append_power.register(Meter)
def _(meter, derivative, p, t, x, tau, motion):
    return (derivative[0], derivative[1], supplied_power(p, t, x, tau, motion))


@system.power.register(Crane)
def _(p, t, x, u):
    tau = system.effort(u, p, t, x)
    return supplied_power(p, t, x, tau, solve_motion(p, t, x, tau))


def supplied_power(p, t, x, tau, motion):
    """Return the power [W] that drives, imposed motions, forces and losses supply; motion: by `solve_motion`."""
    position, moving = x[1][:3], inertial_velocity(x[1][:3], x[1][3:], motion.pose.yaw_rate)
    air = airspeed(motion.base, position, moving)
    force = add_payload_force(p.force, add_drag(p.drag, (0.0, 0.0, 0.0), air), p, t, x[0])
    force = add_wind(motion.flow, p.load.windage, force, position, air)
    (fx, fy, fz), (vx, vy, vz) = add_imposed(motion.base, p.load.mass, force, position, moving), moving
    joints = drive_power(p.support, driven_efforts(p.friction, p, x, tau, motion), motion.pose, motion.tip_force)
    tau = add_joint_friction(p.friction, tau, motion.rope_state, x)
    joints = joints + winch_power(p.cable, tau, motion.rope_state, motion.tension)
    return joints + fx * vx + fy * vy + fz * vz + friction_power(p.swing_friction, motion.rope_state)


@generic
def driven_efforts(friction, p, x, tau, motion):
    """Return the joint efforts (nu,) of drives, friction of the joints, base and wind."""
    tau = add_joint_friction(friction, tau, motion.rope_state, x)
    tau = with_base(p.support, tau, motion.base, motion.pose)
    return with_wind(p.support, tau, motion.flow, motion.base, motion.pose)


@driven_efforts.register(type(None))
def _(friction, p, x, tau, motion):
    return motion.driven


@system.project.register(Crane)
def _(p, x):
    pose = forward_kinematics(p.support, x[0])
    projected = metered_like(p.energy_meter, x, (x[0], project_to_rope(p.cable, pose, x[1])))
    return keep_friction_states(p.friction, x, projected, rope_kinematics(pose, x[1]))


@system.tensions.register(Crane)
def _(p, t, x, u, rows, i, first):
    rows[i, first] = solve_motion(p, t, x, system.effort(u, p, t, x)).tension


@system.saturate.register(Crane)
def _(p, u):
    return limit_winch(p.cable, p.friction, u)


@system.joints.register(Crane)
def _(p, x):
    return joint_coordinates(p.support, p, x)


@system.actuated_joints.register(Crane)
def _(p, x):
    return actuated_joints(p.support, p, x)


@system.efforts_from_row.register(Crane)
def _(p, row):
    return efforts_from_row(p.support, p, row)


@system.state.register(Crane)
def _(p, t, q, v):
    return append_friction_states(p.friction, metered_state(p.energy_meter, state_from_joints(p.support, p, q, v)), v)


@system.acceleration.register(Crane)
def _(p, t, x, u):
    return joint_accelerations(p.support, p, solve_motion(p, t, x, system.effort(u, p, t, x)))


@system.kinetic.register(Crane)
def _(p, x):
    pose = forward_kinematics(p.support, x[0])
    vx, vy, vz = inertial_velocity(x[1][:3], x[1][3:], pose.yaw_rate)
    return support_kinetic(p.support, pose) + 0.5 * p.load.mass * (vx * vx + vy * vy + vz * vz)


@system.potential.register(Crane)
def _(p, x):
    pose = forward_kinematics(p.support, x[0])
    energy = support_potential(p.support, pose, p.gravity) + p.gravity * p.load.mass * x[1][2]
    return add_rope_energy(p.cable, energy, rope_kinematics(pose, x[1]).length)


@system.base_energy.register(Crane)
def _(p, t, x):
    return base_energy_of(base_state(p.base, t, yaw(p.support, x[0])), p, x)


@generic
def base_energy_of(base, p, x):
    """Return (kinetic, potential) energy [J] in the world less those relative to the base; `base`: `base_state`."""
    return 0.0, 0.0


@base_energy_of.register(BaseState)
def _(base, p, x):
    pose = forward_kinematics(p.support, x[0])
    moving = inertial_velocity(x[1][:3], x[1][3:], pose.yaw_rate)
    kinetic, potential = added_energy(base, p.gravity, p.load.mass, x[1][:3], moving)
    others = support_base_energy(p.support, base, pose, p.gravity)
    return kinetic + others[0], potential + others[1]


@system.point_count.register(Crane)
def _(p):
    return 1 + support_polyline_size(p.support)


@system.tip_index.register(Crane)
def _(p):
    return support_polyline_size(p.support) - 1


@system.points.register(Crane)
def _(p, t, x, out):
    angle, pose = yaw(p.support, x[0]), pose_at(p.base, t)
    c, s = cos(angle), sin(angle)
    for i, (a, b, z) in enumerate((*support_polyline(p.support, x[0]), x[1][:3])):
        out[i, 0], out[i, 1], out[i, 2] = to_world(pose, (c * a - s * b, s * a + c * b, z))


@system.with_meter.register(Crane)
def _(p, held):
    lossy = any(part is not None for part in (p.swing_friction, p.drag, p.force, p.wind, p.friction))
    imposed = isinstance(p.cable, MotionRope) or isinstance(p.support, DrivenPoint) or p.base is not None
    return p._replace(energy_meter=Meter()) if lossy or imposed or not held else p


@system.energy_supplied.register(Crane)
def _(p, x):
    return reading(p.energy_meter, x)
