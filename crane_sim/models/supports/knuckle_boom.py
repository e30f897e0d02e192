"""Knuckle-boom crane: a tower that slews, a boom and a jib that luff.

Model of Ambrosino, Dawans, Thierens, Garone, "Oscillation Reduction for Knuckle Cranes", with the misprints corrected,
in the slewing frame (e_r, e_t, e_z): neither the slew angle nor the swing angles appear, and the 6x6 solve of the
Lagrange form becomes one division (slew) and one 2x2 solve (boom, jib). alpha is the slew angle; beta and gamma are
the elevations of boom and jib, both from the horizontal.

Effect of a moving base on a knuckle-boom crane: additional efforts on its joints.

In the slewing frame (e_r, e_t, e_z) boom and jib are masses at their middles, on which the imposed acceleration acts,
and rods whose own inertia resists the rotation of the base. With an axial inertia I_a a rod's inertia tensor is
I 1 + (I_a - I) u uᵀ, u along the rod. Without one the model has inertia about the luffing axis
l = -e_t only, and so it does here: the tensor is I l lᵀ. The tower has an inertia about e_z only, I_t e_z e_zᵀ.
With Ω = w + ω, ω relative to the base, such a tensor a 1 + b d dᵀ, d fixed in the body, gives the body the moment

    -(a s + b [(d·s) d + (d·Ω) Ω × d - (d·ω) ω × d]),   s = w' + w × ω,

in addition to that at w = w' = 0.
"""

from math import cos, sin
from typing import Any, NamedTuple

from crane_sim.files.types import AngleRange, NonNegative, Positive
from crane_sim.models.effects import (
    BoomSpring,
    JibSpring,
    add_jib_spring,
    add_jib_spring_energy,
    add_spring,
    add_spring_energy,
)
from crane_sim.models.guards import Guard, encode, travel_guard
from crane_sim.models.moving_base import added_energy, added_spin, cross, dot, imposed_acceleration
from crane_sim.models.supports import (
    add_imposed_efforts,
    add_yaw_moment,
    drive_power,
    forward_kinematics,
    joint_loads,
    support_acceleration,
    support_base_energy,
    support_guard,
    support_kinetic,
    support_polyline,
    support_polyline_size,
    support_potential,
    tip_acceleration,
    tip_mobility,
    yaw,
)
from crane_sim.models.wind_load import RodWindage
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import lean_generic, lean_kernel, lean_routine


class Rod(NamedTuple):
    """Boom or jib: a rod whose centre of mass is at its middle."""

    length: Positive  # m, between its joints
    mass: NonNegative  # kg, evenly spread or not: its centre is at the middle
    inertia: NonNegative  # kg m², about a transverse axis through the centre of mass
    axial_inertia: NonNegative | None = None  # kg m², about the rod, at most twice `inertia`; left out: the inertia
    # does not turn with the slew
    limits: AngleRange | None = None  # rad, of the elevation; a run ends where one is reached
    windage: RodWindage | None = None  # what it opposes to the `wind`; left out: none presses on it


class Tower(NamedTuple):
    """The tower, which slews with boom and jib."""

    inertia: Positive  # kg m², about the vertical
    limits: AngleRange | None = None  # rad, of the slew angle; a run ends where one is reached


class Knuckle(NamedTuple):
    """Parameters of the support."""

    boom: Rod
    jib: Rod
    tower: Tower
    boom_spring: BoomSpring | None = None
    jib_spring: JibSpring | None = None
    motors: tuple[float, float, float] | None = None  # kg m², of the motors of slew, boom and jib, by the ratio squared

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("slew", "tower.limits"), ("boom", "boom.limits"), ("jib", "jib.limits"))[i]


class KnucklePosture(NamedTuple):
    """Kinematics of a state. Lengths in the slewing frame; p1, p2, c, s, hb, hg are the inertia terms of the joints."""

    tip: tuple[float, float, float]  # (r, 0, h)
    tip_velocity: tuple[float, float, float]  # (r', 0, h')
    yaw_rate: float  # alpha'
    beta: float
    gamma: float
    beta_rate: float
    gamma_rate: float
    cb: float  # cos beta
    sb: float
    cg: float  # cos gamma
    sg: float
    c: float  # K3 cos(beta - gamma), inertia coupling of boom and jib
    s: float  # K3 sin(beta - gamma)
    slew_inertia: float  # kg m², motors included
    hb: float  # -½ d(slew inertia)/d beta
    hg: float
    boom_inertia: float  # IB + K1
    jib_inertia: float  # IJ + K2
    free: Any = None  # (slew, boom, jib), which of them friction does not hold; None: all are free


@lean_generic
def turning_inertia(axial, inertia, c, s):
    """Return (inertia about the vertical, -½ its derivative by the elevation) of a rod; none where axial is absent."""
    return 0.0, 0.0


@turning_inertia.register(float)
def _(axial, inertia, c, s):
    return inertia * c * c + axial * s * s, (inertia - axial) * s * c


@lean_generic
def motor_inertia(motors, inertias):
    """Return the inertias (slew, boom, jib) with those of the motors added."""
    return inertias


@motor_inertia.register(tuple)
def _(motors, inertias):
    return inertias[0] + motors[0], inertias[1] + motors[1], inertias[2] + motors[2]


@forward_kinematics.register(Knuckle)
def _(support, xs):
    _, beta, gamma, yaw_rate, vb, vg = xs
    boom, jib = support.boom, support.jib
    (sb, cb), (sg, cg) = sincos(beta), sincos(gamma)
    k1 = boom.length * boom.length * (0.25 * boom.mass + jib.mass)
    k2 = 0.25 * jib.length * jib.length * jib.mass
    k3 = 0.5 * boom.length * jib.length * jib.mass
    p1, p2 = k1 * cb + k3 * cg, k2 * cg + k3 * cb
    boom_turning, boom_slope = turning_inertia(boom.axial_inertia, boom.inertia, cb, sb)
    jib_turning, jib_slope = turning_inertia(jib.axial_inertia, jib.inertia, cg, sg)
    slew_inertia = support.tower.inertia + cb * p1 + cg * p2 + boom_turning + jib_turning
    inertias = motor_inertia(support.motors, (slew_inertia, boom.inertia + k1, jib.inertia + k2))
    return KnucklePosture(
        tip=(boom.length * cb + jib.length * cg, 0.0, boom.length * sb + jib.length * sg),
        tip_velocity=(-boom.length * sb * vb - jib.length * sg * vg, 0.0, boom.length * cb * vb + jib.length * cg * vg),
        yaw_rate=yaw_rate,
        beta=beta,
        gamma=gamma,
        beta_rate=vb,
        gamma_rate=vg,
        cb=cb,
        sb=sb,
        cg=cg,
        sg=sg,
        c=k3 * (cb * cg + sb * sg),
        s=k3 * (sb * cg - cb * sg),
        slew_inertia=inertias[0],
        hb=sb * p1 + boom_slope,
        hg=sg * p2 + jib_slope,
        boom_inertia=inertias[1],
        jib_inertia=inertias[2],
        free=None,
    )


@lean_generic
def free_moments(free, moments):
    """Return the moments (slew, boom, jib) with those on joints that friction holds left out."""
    return moments


@free_moments.register(tuple)
def _(free, moments):
    slew, boom, jib = moments
    return slew if free[0] else 0.0, boom if free[1] else 0.0, jib if free[2] else 0.0


@lean_generic
def free_coupling(free, coupling):
    """Return the inertia coupling of boom and jib: none where friction holds one of them."""
    return coupling


@free_coupling.register(tuple)
def _(free, coupling):
    return coupling if free[1] and free[2] else 0.0


@lean_kernel
def _solve_luff(pose, b2, b3):
    """Solve the 2x2 system of boom and jib."""
    c = free_coupling(pose.free, pose.c)
    inverse = 1.0 / (pose.boom_inertia * pose.jib_inertia - c * c)
    return (pose.jib_inertia * b2 - c * b3) * inverse, (pose.boom_inertia * b3 - c * b2) * inverse


@lean_kernel
def _moments(support, pose, gravity, tau, force):
    """Return the moments [N m] that accelerate slew, boom and jib."""
    boom, jib = support.boom, support.jib
    fr, ft, fz = force
    wa, wb, wg = pose.yaw_rate, pose.beta_rate, pose.gamma_rate
    u2 = add_spring(support.boom_spring, tau[1], pose.beta)
    u2, u3 = add_jib_spring(support.jib_spring, u2, tau[2], pose.beta, pose.gamma)
    slew = tau[0] + pose.tip[0] * ft + 2.0 * wa * (pose.hb * wb + pose.hg * wg)
    b2 = u2 + boom.length * (pose.cb * fz - pose.sb * fr)
    b3 = u3 + jib.length * (pose.cg * fz - pose.sg * fr)
    b2 = b2 - gravity * boom.length * pose.cb * (0.5 * boom.mass + jib.mass) - pose.s * wg * wg - pose.hb * wa * wa
    b3 = b3 - gravity * jib.length * pose.cg * 0.5 * jib.mass + pose.s * wb * wb - pose.hg * wa * wa
    return slew, b2, b3


@support_acceleration.register(Knuckle)
def _(support, pose, gravity, tau, force):
    slew, b2, b3 = free_moments(pose.free, _moments(support, pose, gravity, tau, force))
    boom_acc, jib_acc = _solve_luff(pose, b2, b3)
    return slew / pose.slew_inertia, boom_acc, jib_acc


@joint_loads.register(Knuckle)
def _(support, pose, gravity, tau, force, qdd):
    slew, b2, b3 = _moments(support, pose, gravity, tau, force)
    return slew, b2 - pose.c * qdd[2], b3 - pose.c * qdd[1]


@tip_acceleration.register(Knuckle)
def _(support, pose, qdd):
    boom, jib = support.boom.length, support.jib.length
    wb2, wg2 = pose.beta_rate * pose.beta_rate, pose.gamma_rate * pose.gamma_rate
    radial = -boom * (pose.sb * qdd[1] + pose.cb * wb2) - jib * (pose.sg * qdd[2] + pose.cg * wg2)
    vertical = boom * (pose.cb * qdd[1] - pose.sb * wb2) + jib * (pose.cg * qdd[2] - pose.sg * wg2)
    return (radial, 0.0, vertical), qdd[0]


@tip_mobility.register(Knuckle)
def _(support, pose, n):
    boom = support.boom.length * (pose.cb * n[2] - pose.sb * n[0])
    jib = support.jib.length * (pose.cg * n[2] - pose.sg * n[0])
    slew, boom, jib = free_moments(pose.free, (pose.tip[0] * n[1], boom, jib))
    boom_acc, jib_acc = _solve_luff(pose, boom, jib)
    return slew * slew / pose.slew_inertia + boom * boom_acc + jib * jib_acc


@add_yaw_moment.register(Knuckle)
def _(support, tau, couple):
    return (tau[0] + couple, *tau[1:])


@support_guard.register(Knuckle)
def _(support, best, xs):
    best = travel_guard(support.tower.limits, best, xs[0], encode(Guard.TRAVEL, 0))
    best = travel_guard(support.boom.limits, best, xs[1], encode(Guard.TRAVEL, 1))
    return travel_guard(support.jib.limits, best, xs[2], encode(Guard.TRAVEL, 2))


@yaw.register(Knuckle)
def _(support, xs):
    return xs[0]


@support_polyline.register(Knuckle)
def _(support, xs):
    boom, jib = support.boom.length, support.jib.length
    x, z = boom * cos(xs[1]), boom * sin(xs[1])
    return (0.0, 0.0, 0.0), (x, 0.0, z), (x + jib * cos(xs[2]), 0.0, z + jib * sin(xs[2]))


@support_kinetic.register(Knuckle)
def _(support, pose):
    wa, wb, wg = pose.yaw_rate, pose.beta_rate, pose.gamma_rate
    elevation = pose.boom_inertia * wb * wb + pose.jib_inertia * wg * wg
    return 0.5 * (pose.slew_inertia * wa * wa + elevation) + pose.c * wb * wg


@support_potential.register(Knuckle)
def _(support, pose, gravity):
    boom, jib = support.boom, support.jib
    energy = gravity * boom.length * pose.sb * (0.5 * boom.mass + jib.mass)
    energy = energy + 0.5 * gravity * jib.mass * jib.length * pose.sg
    energy = add_spring_energy(support.boom_spring, energy, pose.beta)
    return add_jib_spring_energy(support.jib_spring, energy, pose.beta, pose.gamma)


@drive_power.register(Knuckle)
def _(support, tau, pose, force):
    return tau[0] * pose.yaw_rate + tau[1] * pose.beta_rate + tau[2] * pose.gamma_rate


@add_imposed_efforts.register(Knuckle)
def _(support, base, tau, pose):
    slew, boom, jib = _efforts(base, support, pose)
    return (tau[0] + slew, tau[1] + boom, tau[2] + jib, *tau[3:])


@lean_routine
def _efforts(base, support, pose):
    boom, jib = support.boom, support.jib
    slew, x, z = mass_load(base, boom, pose, (0.0, 0.0), (0.0, 0.0), pose.cb, pose.sb, pose.beta_rate)
    length, rate = boom.length, boom.length * pose.beta_rate
    root, root_rate = (length * pose.cb, length * pose.sb), (-rate * pose.sb, rate * pose.cb)
    jib_slew, jx, jz = mass_load(base, jib, pose, root, root_rate, pose.cg, pose.sg, pose.gamma_rate)
    boom_effort = boom.length * (pose.cb * (0.5 * z + jz) - pose.sb * (0.5 * x + jx))
    jib_effort = 0.5 * jib.length * (pose.cg * jz - pose.sg * jx)
    boom_gyro_slew, boom_gyro = gyroscopic_moments(base, boom, pose, pose.cb, pose.sb, pose.beta_rate)
    jib_gyro_slew, jib_gyro = gyroscopic_moments(base, jib, pose, pose.cg, pose.sg, pose.gamma_rate)
    slew = slew + jib_slew + boom_gyro_slew + jib_gyro_slew - support.tower.inertia * base.angular_acceleration[2]
    return slew, boom_effort + boom_gyro, jib_effort + jib_gyro


@lean_kernel
def mass_load(base, rod, pose, root, root_rate, c, s, rate):
    """Return (moment about the vertical [N m], radial, vertical force [N]) that the base imposes on a rod's mass.

    Args:
        base, rod, pose: the base in the slewing frame, the rod, the posture.
        root, root_rate: where the rod begins (radial, vertical) [m], and how that moves in the slewing frame.
        c, s, rate: cosine and sine of the rod's elevation, its rate [rad/s].
    """
    at, moves = middle(rod, pose, root, root_rate, c, s, rate)
    x, y, z = imposed_acceleration(base, at, moves)
    return rod.mass * y * at[0], rod.mass * x, rod.mass * z


@lean_kernel
def middle(rod, pose, root, root_rate, c, s, rate):
    """Return (position [m], velocity [m/s]) of a rod's middle relative to the base (3,); arguments of `mass_load`."""
    return point_of_rod(0.5 * rod.length, pose, root, root_rate, c, s, rate)


@lean_kernel
def point_of_rod(reach, pose, root, root_rate, c, s, rate):
    """Return (position [m], velocity [m/s]) relative to the base (3,) of a rod's point `reach` [m] from its root."""
    at = (root[0] + reach * c, 0.0, root[1] + reach * s)
    return at, (root_rate[0] - reach * s * rate, pose.yaw_rate * at[0], root_rate[1] + reach * c * rate)


@lean_kernel
def gyroscopic_moments(base, rod, pose, c, s, rate):
    """Return the moments [N m] (about the vertical, about the luffing axis) by which a rod's inertia resists."""
    a, b, d = inertia_tensor(rod.axial_inertia, rod.inertia, c, s)
    own = (0.0, -rate, pose.yaw_rate)
    x, y, z = cross(base.angular_velocity, own)
    resisted = (x + base.angular_acceleration[0], y + base.angular_acceleration[1], z + base.angular_acceleration[2])
    whole = (own[0] + base.angular_velocity[0], own[1] + base.angular_velocity[1], own[2] + base.angular_velocity[2])
    along, first, second = dot(d, resisted), dot(d, whole), dot(d, own)
    _, whole_y, whole_z = cross(whole, d)
    _, own_y, own_z = cross(own, d)
    luffing = a * resisted[1] + b * (along * d[1] + first * whole_y - second * own_y)
    slewing = a * resisted[2] + b * (along * d[2] + first * whole_z - second * own_z)
    return -slewing, luffing


@lean_generic
def inertia_tensor(axial, inertia, c, s):
    """Return (a, b, d (3,)) of the inertia tensor a 1 + b d dᵀ [kg m²] of a rod; about the luffing axis only."""
    return 0.0, inertia, (0.0, -1.0, 0.0)


@inertia_tensor.register(float)
def _(axial, inertia, c, s):
    return inertia, axial - inertia, (c, 0.0, s)


@support_base_energy.register(Knuckle)
def _(support, base, pose, gravity):
    length, rate = support.boom.length, support.boom.length * pose.beta_rate
    root, root_rate = (length * pose.cb, length * pose.sb), (-rate * pose.sb, rate * pose.cb)
    zero = (0.0, 0.0)
    boom = rod_energy(base, gravity, support.boom, pose, zero, zero, pose.cb, pose.sb, pose.beta_rate)
    jib = rod_energy(base, gravity, support.jib, pose, root, root_rate, pose.cg, pose.sg, pose.gamma_rate)
    tower = added_spin(base, (0.0, support.tower.inertia, (0.0, 0.0, 1.0)), (0.0, 0.0, pose.yaw_rate))
    return boom[0] + jib[0] + tower, boom[1] + jib[1]


@lean_kernel
def rod_energy(base, gravity, rod, pose, root, root_rate, c, s, rate):
    """Return (kinetic, potential) energy [J] of a rod in the world less those relative to the base.

    Args:
        base: BaseState.
        gravity: m/s².
        rod, pose, root, root_rate, c, s, rate: see `mass_load`.
    """
    at, moves = middle(rod, pose, root, root_rate, c, s, rate)
    kinetic, potential = added_energy(base, gravity, rod.mass, at, moves)
    own = (0.0, -rate, pose.yaw_rate)
    return kinetic + added_spin(base, inertia_tensor(rod.axial_inertia, rod.inertia, c, s), own), potential


@support_polyline_size.register(Knuckle)
def _(support):
    return 3
