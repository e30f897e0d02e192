"""Moving base, such as a ship: the inertial forces on a crane that stands on it, in base axes.

A vector r of the base is (surge, sway, heave) + R r in the world, with R = Rz(yaw) Ry(pitch)
Rx(roll): yaw about the vertical first, then pitch about the new y, then roll about the new x, all
right-handed. A crane's state stays relative to the base. In those axes the force per unit of mass
on a mass at r with velocity v is

    f = Rᵀ(-g ẑ - a₀) - w' × r - w × (w × r) - 2 w × v,

a₀ the acceleration of the base's origin, w its angular velocity. The excess of f over gravity along
the base's own z, (0, 0, -g), is `imposed_acceleration`: it vanishes for a base at rest, and its
power is what the base supplies to the crane. A base at rest is None everywhere, at no cost.
"""

from typing import Any, NamedTuple

from crane_sim.multibody.vectors import (
    Vector,
    add,
    combine,
    cross,
    dot,
    multiply,
    scale,
    subtract,
    to_turned_axes,
)
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine
from crane_sim.trajectories.base_motion import MountedBase, base_motion_at


class Pose(NamedTuple):
    """Pose of the base in the world."""

    rows: tuple[Vector, Vector, Vector]  # of R
    origin: Vector  # m, the base's origin in the world


class BaseKinematics(NamedTuple):
    """Motion of the base at one instant, in the axes of the base."""

    velocity: Vector  # m/s, of the origin
    imposed: Vector  # m/s², acceleration of a mass at rest in the origin, gravity along z left out
    angular_velocity: Vector  # rad/s
    angular_acceleration: Vector  # rad/s², which is the same in the world


class BaseState(NamedTuple):
    """Velocity and height of the base, in its own axes or in axes rotated about its z."""

    velocity: Vector  # m/s, of the origin
    angular_velocity: Vector  # rad/s
    up: Vector  # the world's vertical
    height: float  # m, of the origin in the world


def rotation(roll, pitch, yaw):
    """Return the rows of R = Rz(yaw) Ry(pitch) Rx(roll), which takes base vectors to the world."""
    (sr, cr), (sp, cp), (sy, cy) = sincos(roll), sincos(pitch), sincos(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def angular_motion(angles, rates, seconds):
    """Return (angular velocity, its derivative) in base axes, from (roll, pitch, yaw) and rates.

    `rates` and `seconds` are the first and second derivatives of the angles.
    """
    (sr, cr), (sp, cp) = sincos(angles[0]), sincos(angles[1])
    r, p, y = rates
    turn = (r - y * sp, p * cr + y * sr * cp, y * cr * cp - p * sr)
    rate = (
        seconds[0] - seconds[2] * sp - y * p * cp,
        seconds[1] * cr - p * r * sr + seconds[2] * sr * cp + y * (r * cr * cp - p * sr * sp),
        seconds[2] * cr * cp - y * (r * sr * cp + p * cr * sp) - seconds[1] * sr - p * r * cr,
    )
    return turn, rate


def rotate_to_base(rows, a):
    """Return Rᵀ a (3,), the world's vector a in the axes of the base."""
    return combine(rows, a)


def base_kinematics_at(base, gravity, t) -> Any:
    """Return the BaseKinematics at time t [s], None for a base at rest.

    Gravity [m/s²] acts along -z of the world.
    """
    if base is None:
        return None
    if isinstance(base, MountedBase):
        return mounted_kinematics(base, gravity, vessel_kinematics(base.vessel, gravity, t))
    return vessel_kinematics(base, gravity, t)


@routine
def vessel_kinematics(base, gravity, t):
    """Return the BaseKinematics of a base that moves by itself."""
    x, v, a = base_motion_at(base, t)
    rows = rotation(x[3], x[4], x[5])
    turn, turn_rate = angular_motion((x[3], x[4], x[5]), (v[3], v[4], v[5]), (a[3], a[4], a[5]))
    px, py, pz = rotate_to_base(rows, (-a[0], -a[1], -a[2] - gravity))
    return BaseKinematics(rotate_to_base(rows, v), (px, py, pz + gravity), turn, turn_rate)


@routine
def mounted_kinematics(base, gravity, vessel):
    """Return the BaseKinematics of a base mounted on a vessel that moves as `vessel`.

    Gravity [m/s²] acts along -z of the world.

    At the lever arm r the velocity is v + ω × r and the acceleration a + α × r + ω × (ω × r).
    """
    w, w_dot, r = vessel.angular_velocity, vessel.angular_acceleration, base.position
    turning = cross(w, r)
    x, y, z = subtract(subtract(vessel.imposed, cross(w_dot, r)), cross(w, turning))
    px, py, pz = rotate_to_base(base.rows, (x, y, z - gravity))
    return BaseKinematics(
        rotate_to_base(base.rows, add(vessel.velocity, turning)),
        (px, py, pz + gravity),
        rotate_to_base(base.rows, w),
        rotate_to_base(base.rows, w_dot),
    )


def imposed_acceleration(base, r, v):
    """Return the imposed acceleration (3,) [m/s²] besides gravity along the base's z.

    It is zero for a base at rest.

    Args:
        base: see `base_kinematics_at`.
        r, v: position [m] of a mass and its velocity [m/s] relative to the base, (3,), in the axes
            of the base.
    """
    if base is None:
        return 0.0, 0.0, 0.0
    w = base.angular_velocity
    turning = cross(w, add(cross(w, r), scale(2.0, v)))
    return subtract(subtract(base.imposed, turning), cross(base.angular_acceleration, r))


def add_imposed(base, mass, force, r, v):
    """Return the force (3,) [N] plus what the base imposes on a mass.

    Other arguments as in `imposed_acceleration`.
    """
    return force if base is None else add(force, scale(mass, imposed_acceleration(base, r, v)))


def airspeed(base, r, v):
    """Return the velocity (3,) [m/s] through the air, which rests in the world.

    Arguments of `imposed_acceleration`.
    """
    return v if base is None else add(add(base.velocity, cross(base.angular_velocity, r)), v)


def turned_about_z(base, angle):
    """Return BaseKinematics or a BaseState in axes turned by an angle [rad] about the base's z."""
    return None if base is None else turned_by(base, *sincos(angle))


def turned_by(base: Any, s: Any, c: Any) -> Any:
    """Return BaseKinematics or a BaseState in axes turned about z.

    s and c are sine and cosine of the angle.
    """
    velocity, w = to_turned_axes(base.velocity, s, c), to_turned_axes(base.angular_velocity, s, c)
    if isinstance(base, BaseState):
        return BaseState(velocity, w, to_turned_axes(base.up, s, c), base.height)
    imposed, w_dot = (
        to_turned_axes(base.imposed, s, c),
        to_turned_axes(base.angular_acceleration, s, c),
    )
    return BaseKinematics(velocity, imposed, w, w_dot)


def pose_at(base: Any, t: Any) -> Any:
    """Return the base's Pose at time t [s], None where it rests."""
    if base is None:
        return None
    if isinstance(base, MountedBase):
        columns: Any = tuple(zip(*base.rows, strict=True))
        vessel = pose_at(base.vessel, t)
        rows: Any = tuple([multiply(columns, row) for row in vessel.rows])
        return Pose(rows, to_world(vessel, base.position))
    x, _, _ = base_motion_at(base, t)
    return Pose(rotation(x[3], x[4], x[5]), (x[0], x[1], x[2]))


def to_world(pose, r):
    """Return the point r (3,) [m] of the base in the world."""
    return r if pose is None else add(pose.origin, multiply(pose.rows, r))


def to_base(pose, a):
    """Return the vector a (3,) of the world in the axes of the base."""
    return a if pose is None else rotate_to_base(pose.rows, a)


def base_state(base, t, angle):
    """Return the BaseState at time t [s], None where the base rests.

    Its axes are turned by an angle [rad] about the base's z.
    """
    if base is None:
        return None
    kinematics, pose = base_kinematics_at(base, 0.0, t), pose_at(base, t)
    still = BaseState(
        kinematics.velocity, kinematics.angular_velocity, pose.rows[2], pose.origin[2]
    )
    return turned_about_z(still, angle)


def added_energy(base, gravity, mass, r, v):
    """Return (kinetic, potential) energy [J] of a mass in the world less those in the base.

    Args:
        base: BaseState.
        gravity: m/s².
        mass: kg.
        r, v: its position [m] and velocity [m/s] relative to the base (3,), in the axes of `base`.
    """
    u = add(base.velocity, cross(base.angular_velocity, r))
    return mass * (dot(u, v) + 0.5 * dot(u, u)), mass * gravity * (
        base.height + dot(base.up, r) - r[2]
    )


def added_spin(base, tensor, own):
    """Return the kinetic energy [J] of a body's turning in the world less that in the base.

    Args:
        base: BaseState.
        tensor: (a, b, d (3,)) of the inertia tensor a 1 + b d dᵀ [kg m²], in the axes of `base`.
        own: angular velocity relative to the base (3,) [rad/s].
    """
    a, b, d = tensor
    w = base.angular_velocity
    along = dot(d, w)
    return a * (dot(w, own) + 0.5 * dot(w, w)) + b * along * (dot(d, own) + 0.5 * along)
