"""Moving base, such as a ship: the inertial forces on a crane that stands on it, in the axes of the base.

A vector r of the base is (surge, sway, heave) + R r in the world, with R = Rz(yaw) Ry(pitch) Rx(roll): yaw about the
vertical first, then pitch about the new y, then roll about the new x, all right-handed. A crane's state stays relative
to the base. In those axes the force per unit of mass on a mass at r with velocity v is

    f = Rᵀ(-g ẑ - a₀) - w' × r - w × (w × r) - 2 w × v,

a₀ the acceleration of the base's origin, w its angular velocity. The excess of f over gravity along the base's own
z, (0, 0, -g), is `imposed_acceleration`: it vanishes for a base at rest, and its power is what the base supplies to the
crane. A base at rest is None everywhere, at no cost.
"""

from typing import NamedTuple

from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic, routine
from crane_sim.trajectories.base_motion import MountedBase, base_motion_at

Vector = tuple[float, float, float]


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


def cross(a, b):
    """Return the vector product (3,) of a and b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a, b):
    """Return the scalar product of the vectors (3,) a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def rotation(roll, pitch, yaw):
    """Return the rows of R = Rz(yaw) Ry(pitch) Rx(roll), which takes vectors of the base to the world."""
    (sr, cr), (sp, cp), (sy, cy) = sincos(roll), sincos(pitch), sincos(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def angular_motion(angles, rates, seconds):
    """Return (angular velocity, its derivative) in base axes, from (roll, pitch, yaw) and their derivatives."""
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
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rows
    return xx * a[0] + yx * a[1] + zx * a[2], xy * a[0] + yy * a[1] + zy * a[2], xz * a[0] + yz * a[1] + zz * a[2]


@generic
def base_kinematics_at(base, gravity, t):
    """Return the BaseKinematics at time t [s], gravity [m/s²] acting along -z of the world; None for a base at rest."""
    return _base_kinematics_at(base, gravity, t)


@routine
def _base_kinematics_at(base, gravity, t):
    x, v, a = base_motion_at(base, t)
    rows = rotation(x[3], x[4], x[5])
    turn, turn_rate = angular_motion((x[3], x[4], x[5]), (v[3], v[4], v[5]), (a[3], a[4], a[5]))
    px, py, pz = rotate_to_base(rows, (-a[0], -a[1], -a[2] - gravity))
    return BaseKinematics(rotate_to_base(rows, v), (px, py, pz + gravity), turn, turn_rate)


@base_kinematics_at.register(type(None))
def _(base, gravity, t):
    return None


@base_kinematics_at.register(MountedBase)
def _(base, gravity, t):
    return mounted_kinematics(base, gravity, _base_kinematics_at(base.vessel, gravity, t))


@routine
def mounted_kinematics(base, gravity, vessel):
    """Return the BaseKinematics of a base mounted on a vessel with these, gravity [m/s²] along -z of the world.

    At the lever arm r the velocity is v + ω × r and the acceleration a + α × r + ω × (ω × r).
    """
    w, w_dot, r = vessel.angular_velocity, vessel.angular_acceleration, base.position
    vx, vy, vz = cross(w, r)
    nx, ny, nz = cross(w, (vx, vy, vz))
    ax, ay, az = cross(w_dot, r)
    u, f = vessel.velocity, vessel.imposed
    felt = (f[0] - ax - nx, f[1] - ay - ny, f[2] - az - nz - gravity)
    px, py, pz = rotate_to_base(base.rows, felt)
    return BaseKinematics(
        rotate_to_base(base.rows, (u[0] + vx, u[1] + vy, u[2] + vz)),
        (px, py, pz + gravity),
        rotate_to_base(base.rows, w),
        rotate_to_base(base.rows, w_dot),
    )


@generic
def imposed_acceleration(base, r, v):
    """Return the imposed acceleration (3,) [m/s²] in addition to gravity along the base's z: zero for a base at rest.

    Args:
        base: see `base_kinematics_at`.
        r, v: position [m] of a mass and its velocity [m/s] relative to the base, (3,), in the axes of the base.
    """
    return 0.0, 0.0, 0.0


@imposed_acceleration.register(BaseKinematics)
def _(base, r, v):
    x, y, z = cross(base.angular_velocity, r)
    dx, dy, dz = cross(base.angular_velocity, (x + 2.0 * v[0], y + 2.0 * v[1], z + 2.0 * v[2]))
    ex, ey, ez = cross(base.angular_acceleration, r)
    return base.imposed[0] - dx - ex, base.imposed[1] - dy - ey, base.imposed[2] - dz - ez


@generic
def add_imposed(base, mass, force, r, v):
    """Return the force (3,) [N] plus what the base imposes on a mass; other arguments of `imposed_acceleration`."""
    return force


@add_imposed.register(BaseKinematics)
def _(base, mass, force, r, v):
    x, y, z = imposed_acceleration(base, r, v)
    return force[0] + mass * x, force[1] + mass * y, force[2] + mass * z


@generic
def airspeed(base, r, v):
    """Return the velocity (3,) [m/s] through the air, which rests in the world; arguments of `imposed_acceleration`."""
    return v


@airspeed.register(BaseKinematics)
def _(base, r, v):
    x, y, z = cross(base.angular_velocity, r)
    return base.velocity[0] + x + v[0], base.velocity[1] + y + v[1], base.velocity[2] + z + v[2]


@generic
def turned_about_z(base, angle):
    """Return the base in axes that are turned by an angle [rad] about its z."""
    return base


@turned_about_z.register(BaseKinematics)
def _(base, angle):
    s, c = sincos(angle)
    velocity, imposed = to_turned_axes(base.velocity, s, c), to_turned_axes(base.imposed, s, c)
    w, w_dot = to_turned_axes(base.angular_velocity, s, c), to_turned_axes(base.angular_acceleration, s, c)
    return BaseKinematics(velocity, imposed, w, w_dot)


@turned_about_z.register(BaseState)
def _(base, angle):
    s, c = sincos(angle)
    velocity, w = to_turned_axes(base.velocity, s, c), to_turned_axes(base.angular_velocity, s, c)
    return BaseState(velocity, w, to_turned_axes(base.up, s, c), base.height)


def to_turned_axes(a, s, c):
    """Return the vector a (3,) in axes turned about z by an angle whose sine and cosine are s and c."""
    return c * a[0] + s * a[1], c * a[1] - s * a[0], a[2]


@generic
def pose_at(base, t):
    """Return the base's Pose at time t [s], None where it rests."""
    x, _, _ = base_motion_at(base, t)
    return Pose(rotation(x[3], x[4], x[5]), (x[0], x[1], x[2]))


@pose_at.register(type(None))
def _(base, t):
    return None


@pose_at.register(MountedBase)
def _(base, t):
    x, _, _ = base_motion_at(base.vessel, t)
    rows, (first, second, third) = rotation(x[3], x[4], x[5]), base.rows
    columns = (
        (first[0], second[0], third[0]),
        (first[1], second[1], third[1]),
        (first[2], second[2], third[2]),
    )
    return Pose(
        (product_row(rows[0], columns), product_row(rows[1], columns), product_row(rows[2], columns)),
        (
            x[0] + dot(rows[0], base.position),
            x[1] + dot(rows[1], base.position),
            x[2] + dot(rows[2], base.position),
        ),
    )


def product_row(row, columns):
    """Return a row (3,) of a product of matrices, from a row of the first and the columns of the second."""
    return dot(row, columns[0]), dot(row, columns[1]), dot(row, columns[2])


@generic
def to_world(pose, r):
    """Return the point r (3,) [m] of the base in the world."""
    return r


@to_world.register(Pose)
def _(pose, r):
    (x, y, z), (a, b, c) = pose.origin, pose.rows
    return x + dot(a, r), y + dot(b, r), z + dot(c, r)


@generic
def to_base(pose, a):
    """Return the vector a (3,) of the world in the axes of the base."""
    return a


@to_base.register(Pose)
def _(pose, a):
    return rotate_to_base(pose.rows, a)


@generic
def base_state(base, t, angle):
    """Return the BaseState at time t [s] in axes turned by an angle [rad] about the base's z; None where it rests."""
    kinematics, pose, (s, c) = base_kinematics_at(base, 0.0, t), pose_at(base, t), sincos(angle)
    velocity, w = to_turned_axes(kinematics.velocity, s, c), to_turned_axes(kinematics.angular_velocity, s, c)
    return BaseState(velocity, w, to_turned_axes(pose.rows[2], s, c), pose.origin[2])


@base_state.register(type(None))
def _(base, t, angle):
    return None


def added_energy(base, gravity, mass, r, v):
    """Return (kinetic, potential) energy [J] of a mass in the world less those relative to the base.

    Args:
        base: BaseState.
        gravity: m/s².
        mass: kg.
        r, v: its position [m] and velocity [m/s] relative to the base (3,), in the axes of `base`.
    """
    x, y, z = cross(base.angular_velocity, r)
    u = (base.velocity[0] + x, base.velocity[1] + y, base.velocity[2] + z)
    return mass * (dot(u, v) + 0.5 * dot(u, u)), mass * gravity * (base.height + dot(base.up, r) - r[2])


def added_spin(base, tensor, own):
    """Return the kinetic energy [J] of a body's turning in the world less that relative to the base.

    Args:
        base: BaseState.
        tensor: (a, b, d (3,)) of the inertia tensor a 1 + b d dᵀ [kg m²], in the axes of `base`.
        own: angular velocity relative to the base (3,) [rad/s].
    """
    a, b, d = tensor
    w = base.angular_velocity
    along = dot(d, w)
    return a * (dot(w, own) + 0.5 * dot(w, w)) + b * along * (dot(d, own) + 0.5 * along)
