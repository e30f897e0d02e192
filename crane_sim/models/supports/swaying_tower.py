"""Tower crane on a mast that bends: its top sways, with everything that slews on it.

The first bending modes of the mast are those of a rigid body on a universal joint with springs (a pseudo-rigid-body
model; Howell, Compliant Mechanisms, 2001, chapter 5), h below the jib. The mast turns by the angle a about the base's
x axis and then by b about its own y axis, and does not twist; all that slews turns by α about the mast. With w_i the
axes of α, a, b, a mass at x on the jib and ρ = (x, 0, h), all in the axes of the jib,

    w_α = (0, 0, 1),    w_a = (cos α cos b, -sin α cos b, sin b),    w_b = (sin α, cos α, 0),

its velocity is Σ (w_i × ρ) q_i', plus (r', 0, 0) of the trolley. All masses are on one line, so that with Σ m, Σ m x
and Σ m x² their equations are closed forms. The trolley's acceleration goes out of the mass matrix first, which leaves
a matrix (3, 3) of α, a and b. A slew that friction holds leaves that matrix, a trolley that it holds stays in it.

Efforts and coordinates stand in the order slew, trolley, a, b here, then the winch's.
"""

from typing import Any, NamedTuple

from crane_sim.models.moving_base import added_energy, cross, dot, imposed_acceleration
from crane_sim.models.rotating_frame import frame_acceleration
from crane_sim.models.supports import (
    add_imposed_efforts,
    add_yaw_moment,
    coordinate_count,
    drive_power,
    forward_kinematics,
    joint_constraint_efforts,
    joint_motion,
    support_acceleration,
    support_base_energy,
    support_guard,
    support_kinetic,
    support_polyline,
    support_polyline_size,
    support_potential,
    tip_acceleration,
    tip_mobility,
    trailing_count,
    yaw,
)
from crane_sim.models.supports.backlash import (
    joint_efforts,
    permute_to_coordinate_order,
    permute_to_joint_order,
    to_coordinate_order,
    to_joint_order,
)
from crane_sim.models.supports.tower_crane import TowerCrane
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_field

Vector = tuple[float, float, float]


class SwayingTower(NamedTuple):
    """Parameters of the support."""

    support: TowerCrane  # the rigid support, whose slew inertia the masses have
    masses: tuple[float, ...]  # kg, of what slews and of the mast's head, without the trolley
    places: tuple[float, ...]  # m, of these masses along the jib, from the tower's axis
    height: float  # m, h
    stiffness: float  # N m/rad, of either angle
    damping: float  # N m s/rad

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return self.support.coordinate(i)


class SwayState(NamedTuple):
    """State of the support."""

    inner: tuple[float, ...]  # of the rigid support
    angles: tuple[float, float]  # rad, a and b
    rates: tuple[float, float]  # rad/s


class SwayPosture(NamedTuple):
    """Kinematics of a state; vectors in the jib's axes unless they say otherwise."""

    tip: Vector  # m, in the support's frame, as the next two
    tip_velocity: Vector  # m/s
    yaw_rate: float  # rad/s, α'
    axes: tuple[Vector, Vector, Vector]  # the jib's axes in the support's frame
    up: Vector  # the base's z axis
    turns: tuple[Vector, Vector, Vector]  # w of α, a and b
    omega: Vector  # rad/s, of what slews
    bias: Vector  # rad/s², its derivative where α, a and b do not accelerate
    moments: Vector  # kg, kg m, kg m²: Σ m, Σ m x, Σ m x², the trolley's among them
    inverse: tuple[float, float, float, float, float, float]  # 1/(kg m²), of the matrix of α, a, b: (00, 01, 02, 11,
    # 12, 22)
    trolley: tuple[float, float]  # m, m/s, r and r'
    angles: tuple[float, float]  # rad, a and b
    rates: tuple[float, float]  # rad/s
    free: Any = None  # (slew, trolley), which of them friction does not hold; None: both are free


def combine(a, x, b, y, c, z):
    """Return x a + y b + z c (3,) of vectors a, b, c, each (3,), in the units of the products."""
    return x * a[0] + y * b[0] + z * c[0], x * a[1] + y * b[1] + z * c[1], x * a[2] + y * b[2] + z * c[2]


def to_frame(pose, a):
    """Return a vector (3,) of any unit in the axes of the support's frame, from the jib's."""
    return combine(pose.axes[0], a[0], pose.axes[1], a[1], pose.axes[2], a[2])


def to_jib(pose, a):
    """Return a vector (3,) of any unit in the axes of the jib, from the support's frame's."""
    return dot(pose.axes[0], a), dot(pose.axes[1], a), dot(pose.axes[2], a)


def jib_axes(s, c, a, b):
    """Return the jib's axes, unit vectors (3,) of the support's frame.

    Args:
        s, c: sine and cosine of the slew.
        a, b: angles of the mast [rad].
    """
    (sa, ca), (sb, cb) = sincos(a), sincos(b)
    x = tilted(c, s, sa, ca, sb, cb)
    y = tilted(-s, c, sa, ca, sb, cb)
    ahead = c * x[0] + s * x[1], c * x[1] - s * x[0], x[2]
    across = c * y[0] + s * y[1], c * y[1] - s * y[0], y[2]
    return ahead, across, cross(ahead, across)


def tilted(x, y, sa, ca, sb, cb):
    """Return the horizontal vector (x, y), of any unit, of the upright mast turned with it, in the axes of the base.

    Args:
        x, y: the vector.
        sa, ca, sb, cb: sines and cosines of the mast's angles a and b.
    """
    return cb * x, ca * y + sa * sb * x, sa * y - ca * sb * x


def moments_of(support, radius):
    """Return Σ m [kg], Σ m x [kg m] and Σ m x² [kg m²] with the trolley at a radius [m]."""
    mass = support.support.trolley.mass
    zeroth, first, second = mass, mass * radius, mass * radius * radius
    for i in range(len(support.masses)):
        m, x = support.masses[i], support.places[i]
        zeroth, first, second = zeroth + m, first + m * x, second + m * x * x
    return zeroth, first, second


def column(w, x, h):
    """Return w × ρ (3,) [m] of a mass at x [m], h [m] above the joint; of rates w [rad/s] its velocity [m/s]."""
    return w[1] * h, w[2] * x - w[0] * h, -w[1] * x


def product(v, w, moments, h):
    """Return Σ m (v × ρ) · (w × ρ) [kg m²] of axes v and w, each (3,); moments: of `moments_of`, h: height [m]."""
    at, slope = column(v, 0.0, h), (0.0, v[2], -v[1])
    other, other_slope = column(w, 0.0, h), (0.0, w[2], -w[1])
    mixed = dot(at, other_slope) + dot(slope, other)
    return moments[0] * dot(at, other) + moments[1] * mixed + moments[2] * dot(slope, other_slope)


def matrix_of_turns(support, turns, moments, trolley):
    """Return the matrix [kg m²] of α, a and b, its entries as of `SwayPosture.inverse`.

    Args:
        support: the support.
        turns, moments: of the posture.
        trolley: mass [kg] of a trolley whose acceleration is left out, 0 of one that is held.
    """
    h, mass, (e, a, b) = support.height, trolley * support.height**2, turns
    m00, m01, m02 = product(e, e, moments, h), product(e, a, moments, h), product(e, b, moments, h)
    m11 = product(a, a, moments, h) - mass * a[1] * a[1]
    m12 = product(a, b, moments, h) - mass * a[1] * b[1]
    m22 = product(b, b, moments, h) - mass * b[1] * b[1]
    return m00, m01, m02, m11, m12, m22


def inverse_of(matrix):
    """Return the inverse [1/(kg m²)] of the matrix of α, a and b."""
    m00, m01, m02, m11, m12, m22 = matrix
    c00, c01, c02 = m11 * m22 - m12 * m12, m02 * m12 - m01 * m22, m01 * m12 - m02 * m11
    scale = 1.0 / (m00 * c00 + m01 * c01 + m02 * c02)
    c11, c12, c22 = m00 * m22 - m02 * m02, m01 * m02 - m00 * m12, m00 * m11 - m01 * m01
    return scale * c00, scale * c01, scale * c02, scale * c11, scale * c12, scale * c22


def inverse_without_slew(matrix):
    """Return the inverse [1/(kg m²)] of the matrix of a and b, zeros for α, which is held."""
    _, _, _, m11, m12, m22 = matrix
    scale = 1.0 / (m11 * m22 - m12 * m12)
    return 0.0, 0.0, 0.0, scale * m22, -scale * m12, scale * m11


def with_sticking_joints(support, pose, free):
    """Return the posture whose joints friction holds where `free` of (slew, trolley) is False."""
    trolley = support.support.trolley.mass if free[1] else 0.0
    matrix = matrix_of_turns(support, pose.turns, pose.moments, trolley)
    inverse = inverse_of(matrix) if free[0] else inverse_without_slew(matrix)
    return replace_field(replace_field(pose, "inverse", inverse), "free", free)


@generic
def trolley_share(free):
    """Return 1.0 where the trolley moves freely along the jib, 0.0 where friction holds it."""
    return 1.0


@trolley_share.register(tuple)
def _(free):
    return 1.0 if free[1] else 0.0


def multiply_inverse(inverse, a):
    """Return the product (3,) [rad/s²] of `SwayPosture.inverse` and a vector (3,) of moments [N m]."""
    i00, i01, i02, i11, i12, i22 = inverse
    return (
        i00 * a[0] + i01 * a[1] + i02 * a[2],
        i01 * a[0] + i11 * a[1] + i12 * a[2],
        i02 * a[0] + i12 * a[1] + i22 * a[2],
    )


@forward_kinematics.register(SwayingTower)
def _(support, xs):
    (angle, radius, w, rate), (a, b), (da, db), h = xs.inner, xs.angles, xs.rates, support.height
    (s, c), (sa, ca), (sb, cb) = sincos(angle), sincos(a), sincos(b)
    axes = jib_axes(s, c, a, b)
    about_a, about_b = (c * cb, -s * cb, sb), (s, c, 0.0)
    omega = combine((0.0, 0.0, 1.0), w, about_a, da, about_b, db)
    change = combine((-s * cb, -c * cb, 0.0), w, (-c * sb, s * sb, cb), db, about_a, 0.0)
    bias = combine(change, da, (c, -s, 0.0), db * w, about_a, 0.0)
    up = s * sa - c * sb * ca, s * sb * ca + c * sa, cb * ca
    turns, moments = ((0.0, 0.0, 1.0), about_a, about_b), moments_of(support, radius)
    x, y, z = combine(axes[0], radius, axes[1], 0.0, axes[2], h)
    velocity = column(omega, radius, h)
    vx, vy, vz = combine(axes[0], velocity[0] + rate, axes[1], velocity[1], axes[2], velocity[2])
    moves = vx + w * y, vy - w * x, vz
    inverse, at = inverse_of(matrix_of_turns(support, turns, moments, support.support.trolley.mass)), (x, y, z - h)
    rest = (radius, rate), (a, b), (da, db), None
    return SwayPosture(at, moves, w, axes, up, turns, omega, bias, moments, inverse, *rest)


def accelerated(pose, x, h):
    """Return the acceleration (3,) [m/s²] of a mass that stands at x [m] on the jib where no coordinate accelerates."""
    omega, place = pose.omega, (x, 0.0, h)
    inward, size = dot(omega, place), dot(omega, omega)
    return combine(cross(pose.bias, place), 1.0, omega, inward, place, -size)


def coriolis(pose):
    """Return the acceleration (3,) [m/s²] that the trolley has besides by its rate."""
    _, rate = pose.trolley
    return 0.0, 2.0 * rate * pose.omega[2], -2.0 * rate * pose.omega[1]


def efforts_of_field(support, pose, at, slope, further):
    """Return efforts on slew [N m], trolley [N], a and b [N m] of accelerations of all masses times these.

    Args:
        support: the support.
        pose: its posture.
        at, slope: (3,) m/s² and 1/s², the acceleration at x on the jib is at + x slope.
        further: (3,) m/s², in addition on the trolley.
    """
    (zeroth, first, second), h = pose.moments, support.height
    mass, radius = support.support.trolley.mass, pose.trolley[0]
    slew, a, b = 0.0, 0.0, 0.0
    for i in range(3):
        w = pose.turns[i]
        own, change = column(w, 0.0, h), (0.0, w[2], -w[1])
        effort = zeroth * dot(own, at) + first * (dot(own, slope) + dot(change, at)) + second * dot(change, slope)
        effort += mass * dot(column(w, radius, h), further)
        slew, a, b = (effort if i == 0 else slew), (effort if i == 1 else a), (effort if i == 2 else b)
    return slew, mass * (at[0] + radius * slope[0] + further[0]), a, b


def add_efforts(tau, own):
    """Return efforts tau [N m, N, N m, N m, ...] plus those (4,) of the support's coordinates."""
    return (tau[0] + own[0], tau[1] + own[1], tau[2] + own[2], tau[3] + own[3], *tau[4:])


def efforts_at_rest(support, pose, gravity, tau, force):
    """Return the efforts (slew [N m], trolley [N], a, b [N m]) where no coordinate accelerates.

    Arguments are those of `support_acceleration`.
    """
    h, (radius, _) = support.height, pose.trolley
    at, slope = accelerated(pose, 0.0, h), accelerated(pose, 1.0, 0.0)
    x, y, z = coriolis(pose)
    down = combine(pose.up, -gravity, at, -1.0, at, 0.0)
    own = efforts_of_field(support, pose, down, (-slope[0], -slope[1], -slope[2]), (-x, -y, -z))
    pull = to_jib(pose, force)
    along = tau[1] + own[1] + pull[0]
    e, a, b = pose.turns
    return (
        tau[0] + own[0] + dot(column(e, radius, h), pull),
        along,
        tau[2] + own[2] + dot(column(a, radius, h), pull),
        tau[3] + own[3] + dot(column(b, radius, h), pull),
    )


@support_acceleration.register(SwayingTower)
def _(support, pose, gravity, tau, force):
    turning, along, about_a, about_b = efforts_at_rest(support, pose, gravity, tau, force)
    h, share, (_, a, b) = support.height, trolley_share(pose.free), pose.turns
    right = turning, about_a - h * a[1] * (share * along), about_b - h * b[1] * (share * along)
    slew, first, second = multiply_inverse(pose.inverse, right)
    trolley = along / support.support.trolley.mass - h * (a[1] * first + b[1] * second)
    return slew, share * trolley, first, second


@joint_constraint_efforts.register(SwayingTower)
def _(support, pose, gravity, tau, force, qdd):
    turning, along, _, _ = efforts_at_rest(support, pose, gravity, tau, force)
    (e, a, b), h, mass = pose.turns, support.height, support.support.trolley.mass
    coupled = product(e, a, pose.moments, h) * qdd[2] + product(e, b, pose.moments, h) * qdd[3]
    return turning - coupled, along - mass * h * (a[1] * qdd[2] + b[1] * qdd[3]), 0.0, 0.0


@tip_acceleration.register(SwayingTower)
def _(support, pose, qdd):
    h, radius, (e, a, b) = support.height, pose.trolley[0], pose.turns
    turning = combine(e, qdd[0], a, qdd[2], b, qdd[3])
    x, y, z = combine(accelerated(pose, radius, h), 1.0, coriolis(pose), 1.0, column(turning, radius, h), 1.0)
    inertial = to_frame(pose, (x + qdd[1], y, z))
    return frame_acceleration(inertial, pose.tip, pose.tip_velocity, pose.yaw_rate, qdd[0]), qdd[0]


@tip_mobility.register(SwayingTower)
def _(support, pose, n):
    h, radius, (e, a, b) = support.height, pose.trolley[0], pose.turns
    along, share = to_jib(pose, n), trolley_share(pose.free)
    levers = (
        dot(column(e, radius, h), along),
        dot(column(a, radius, h), along) - h * a[1] * (share * along[0]),
        dot(column(b, radius, h), along) - h * b[1] * (share * along[0]),
    )
    turning = dot(levers, multiply_inverse(pose.inverse, levers))
    return share * (along[0] * along[0] / support.support.trolley.mass) + turning


def motion_at(support, pose, x, rate):
    """Return (position [m], velocity [m/s]) of a mass at x [m] on the jib, in the frame's axes; rate: x' [m/s]."""
    px, py, pz = to_frame(pose, (x, 0.0, support.height))
    vx, vy, vz = column(pose.omega, x, support.height)
    return (px, py, pz - support.height), to_frame(pose, (vx + rate, vy, vz))


@add_imposed_efforts.register(SwayingTower)
def _(support, base, tau, pose):
    radius, rate = pose.trolley
    at = to_jib(pose, imposed_acceleration(base, *motion_at(support, pose, 0.0, 0.0)))
    unit = to_jib(pose, imposed_acceleration(base, *motion_at(support, pose, 1.0, 0.0)))
    slope = combine(unit, 1.0, at, -1.0, at, 0.0)
    whole = to_jib(pose, imposed_acceleration(base, *motion_at(support, pose, radius, rate)))
    further = combine(whole, 1.0, at, -1.0, slope, -radius)
    return add_efforts(tau, efforts_of_field(support, pose, at, slope, further))


@joint_efforts.register(SwayingTower)
def _(support, tau, pose):
    k, c = support.stiffness, support.damping
    first = -k * pose.angles[0] - c * pose.rates[0]
    return (tau[0], tau[1], first, -k * pose.angles[1] - c * pose.rates[1], *tau[2:])


@drive_power.register(SwayingTower)
def _(support, tau, pose, force):
    power = tau[0] * pose.yaw_rate + tau[1] * pose.trolley[1]  # without the springs, whose energy is potential
    power += (tau[2] + support.stiffness * pose.angles[0]) * pose.rates[0]
    return power + (tau[3] + support.stiffness * pose.angles[1]) * pose.rates[1]


@support_kinetic.register(SwayingTower)
def _(support, pose):
    (zeroth, first, second), h, rate = pose.moments, support.height, pose.trolley[1]
    at, slope = column(pose.omega, 0.0, h), (0.0, pose.omega[2], -pose.omega[1])
    energy = 0.5 * zeroth * dot(at, at) + first * dot(at, slope) + 0.5 * second * dot(slope, slope)
    return energy + support.support.trolley.mass * rate * (at[0] + 0.5 * rate)


@support_potential.register(SwayingTower)
def _(support, pose, gravity):
    zeroth, first, _ = pose.moments
    a, b = pose.angles
    height = first * pose.up[0] + zeroth * support.height * (pose.up[2] - 1.0)
    return gravity * height + 0.5 * support.stiffness * (a * a + b * b)


@support_base_energy.register(SwayingTower)
def _(support, base, pose, gravity):
    at = motion_at(support, pose, *pose.trolley)
    kinetic, potential = added_energy(base, gravity, support.support.trolley.mass, *at)
    for i in range(len(support.masses)):
        more = added_energy(base, gravity, support.masses[i], *motion_at(support, pose, support.places[i], 0.0))
        kinetic, potential = kinetic + more[0], potential + more[1]
    return kinetic, potential


@coordinate_count.register(SwayingTower)
def _(support):
    return 4


@trailing_count.register(SwayingTower)
def _(support):
    return 2


@to_joint_order.register(SwayingTower)
def _(support, row):
    return permute_to_joint_order(support, row)


@to_coordinate_order.register(SwayingTower)
def _(support, row):
    return permute_to_coordinate_order(support, row)


@joint_motion.register(SwayingTower)
def _(support, xs, i):
    return joint_motion(support.support, xs.inner, i)


@add_yaw_moment.register(SwayingTower)
def _(support, tau, couple):
    return (tau[0] + couple, *tau[1:])


@support_guard.register(SwayingTower)
def _(support, best, xs):
    return support_guard(support.support, best, xs.inner)


@yaw.register(SwayingTower)
def _(support, xs):
    return xs.inner[0]


@support_polyline.register(SwayingTower)
def _(support, xs):
    pose = forward_kinematics(support, xs)
    x, y, z = pose.axes[2]
    h = support.height
    return (h * x, h * y, h * (z - 1.0)), pose.tip


@support_polyline_size.register(SwayingTower)
def _(support):
    return 2
