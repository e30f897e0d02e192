"""Knuckle-boom crane: a tower that slews, a boom and a jib that luff.

Model of Ambrosino, Dawans, Thierens, Garone, "Oscillation Reduction for Knuckle Cranes", with its misprints corrected:
A4 and A5 without the factor 2, d² in m55 and m66, and c12, c15, c16, c22, c24 .. c26, c35, c55, c61 .. c66 as the
Lagrangian gives them. In the slewing frame (e_r, e_t, e_z), turned about z by the slew angle alpha, neither alpha nor
the swing angles appear, and the 6x6 solve of the Lagrange form becomes one division (slew) and one 2x2 solve (boom,
jib). beta and gamma are the elevations of boom and jib, both from the horizontal. With length lB, mass mB and
transverse inertia IB of the boom, lJ, mJ, IJ of the jib, and the inertia It of the tower about the vertical

    K1 = lB² (mB/4 + mJ),   K2 = lJ² mJ/4,   K3 = lB lJ mJ/2,
    p1 = K1 cos β + K3 cos γ,   p2 = K2 cos γ + K3 cos β,
    hb = p1 sin β,   hg = p2 sin γ,   c = K3 cos(β - γ),   s = K3 sin(β - γ),

    (It + p1 cos β + p2 cos γ) α'' = u1 + r F_t + 2 α' (hb β' + hg γ')
    (IB + K1) β'' + c γ'' = u2 + lB (F_z cos β - F_r sin β) - g lB (mB/2 + mJ) cos β - s γ'² - hb α'²
    c β'' + (IJ + K2) γ'' = u3 + lJ (F_z cos γ - F_r sin γ) - g lJ mJ/2 cos γ + s β'² - hg α'²,

u1, u2, u3 the efforts tau on the joints, F the force on the tip (r, 0, h). Motors add their inertias on the left, axial
inertias of the rods add to the inertia of the slew, and so to hb and hg, which are -½ its derivatives by β and γ.

A moving base (`models.moving_base`) imposes an acceleration on boom and jib, as masses at their middles, and the
inertias of the rods resist its rotation. With an axial inertia I_a a rod's inertia tensor is I 1 + (I_a - I) u uᵀ, u
along the rod. Without one the model has inertia about the luffing axis l = -e_t only: the tensor is I l lᵀ. The tower
has an inertia about e_z only, It e_z e_zᵀ. With w the angular velocity of the base, ω that of a body relative to it,
and Ω = w + ω, a tensor a 1 + b d dᵀ, d fixed in the body, gives the body the moment

    -(a ε + b [(d·ε) d + (d·Ω) Ω × d - (d·ω) ω × d]),   ε = w' + w × ω,

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
    joint_constraint_efforts,
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
from crane_sim.models.supports.support import Mechanism, Pressed, Spring
from crane_sim.models.wind_load import RodWindage
from crane_sim.multibody.tree import Body, Joint, Point, Tree, Y, Z
from crane_sim.multibody.vectors import diagonal
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic, routine


class Rod(NamedTuple):
    """Boom or jib: a rod whose centre of mass is at its middle."""

    length: Positive  # m, between its joints
    mass: NonNegative  # kg, evenly spread or not: its centre is at the middle
    inertia: NonNegative  # kg m², about a transverse axis through the centre of mass
    axial_inertia: NonNegative | None = None  # kg m², about the rod, at most twice `inertia`; left out: the inertia
    # has no part in the slew's
    limits: AngleRange | None = None  # rad, of the elevation; a run ends where one is reached
    windage: RodWindage | None = None  # area and drag in the `wind`; left out: no wind acts on it

    def body(self) -> Body:
        """Return the rod in axes at its lower joint, along x; a thin one has inertia about its luffing axis alone."""
        axial, vertical = (0, 0) if self.axial_inertia is None else (self.axial_inertia, self.inertia)
        return Body(self.mass, (0.5 * self.length, 0, 0), diagonal(axial, self.inertia, vertical))


class Tower(NamedTuple):
    """The tower, which slews with boom and jib."""

    inertia: Positive  # kg m², about the vertical
    limits: AngleRange | None = None  # rad, of the slew angle; a run ends where one is reached


class Knuckle(NamedTuple):
    """Parameters of the structure, a support: tower, boom and jib, without what hangs on the tip."""

    boom: Rod
    jib: Rod
    tower: Tower
    boom_spring: BoomSpring | None = None
    jib_spring: JibSpring | None = None
    motors: tuple[float, float, float] | None = None  # kg m², of slew, boom and jib: motor inertia times ratio squared

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("slew", "tower.limits"), ("boom", "boom.limits"), ("jib", "jib.limits"))[i]

    def mechanism(self) -> Mechanism:
        """Return the joints and bodies: slew, boom, and jib, whose elevation is measured from the horizontal."""
        boom, jib = self.boom, self.jib
        slew = Joint(Z, ((0, 1),), bodies=(Body(0, inertia=diagonal(0, 0, self.tower.inertia)),))
        luff = Joint(Y, ((1, 1),), reverse=True, parent=0, bodies=(boom.body(),))
        head = boom.length, 0, 0
        fold = Joint(Y, ((2, 1), (1, -1)), reverse=True, parent=1, offset=head, bodies=(jib.body(),))
        rods = (1, boom), (2, jib)
        return Mechanism(
            Tree((slew, luff, fold), Point(2, (jib.length, 0, 0))),
            limits=(self.tower.limits, boom.limits, jib.limits),
            actuated=(0, 1, 2),
            springs=self._springs(),
            outline=(Point(-1), Point(2)),
            pressed=tuple(
                Pressed(joint, rod.windage, rod.windage.centre * rod.length)
                for joint, rod in rods
                if rod.windage is not None
            ),
        )

    def _springs(self) -> tuple[Spring, ...]:
        boom, jib, springs = self.boom_spring, self.jib_spring, ()
        if boom is not None:
            springs = (Spring((0, 1, 0), boom.stiffness, boom.rest),)
        if jib is not None:
            springs = (*springs, Spring((0, -1.0 if jib.relative else 0.0, 1), jib.stiffness, jib.rest))
        return springs


class KnucklePosture(NamedTuple):
    """Kinematics of a state in the slewing frame, and inertia terms of the joints by the module's symbols."""

    tip: tuple[float, float, float]  # (r, 0, h)
    tip_velocity: tuple[float, float, float]  # (r', 0, h')
    yaw_rate: float  # alpha', of the slewing frame
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
    slew_inertia: float  # kg m², of the tower, boom and jib about the vertical; this and the next with the motors'
    hb: float  # -½ d(slew inertia)/d beta
    hg: float
    boom_inertia: float  # kg m², IB + K1
    jib_inertia: float  # kg m², IJ + K2
    free: Any = None  # (slew, boom, jib), which of them friction does not hold; None: all are free


@generic
def yaw_inertia(axial, inertia, c, s):
    """Return (inertia about the vertical, -½ its derivative by the elevation) of a rod; 0 without an axial inertia."""
    return 0.0, 0.0


@yaw_inertia.register(float)
def _(axial, inertia, c, s):
    return inertia * c * c + axial * s * s, (inertia - axial) * s * c


@generic
def add_motor_inertias(motors, inertias):
    """Return the inertias (slew, boom, jib) with those of the motors added."""
    return inertias


@add_motor_inertias.register(tuple)
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
    boom_yaw_inertia, boom_h = yaw_inertia(boom.axial_inertia, boom.inertia, cb, sb)
    jib_yaw_inertia, jib_h = yaw_inertia(jib.axial_inertia, jib.inertia, cg, sg)
    slew_inertia = support.tower.inertia + cb * p1 + cg * p2 + boom_yaw_inertia + jib_yaw_inertia
    inertias = add_motor_inertias(support.motors, (slew_inertia, boom.inertia + k1, jib.inertia + k2))
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
        hb=sb * p1 + boom_h,
        hg=sg * p2 + jib_h,
        boom_inertia=inertias[1],
        jib_inertia=inertias[2],
        free=None,
    )


@generic
def free_moments(free, moments):
    """Return the moments (slew, boom, jib) with those on joints that friction holds left out."""
    return moments


@free_moments.register(tuple)
def _(free, moments):
    slew, boom, jib = moments
    return slew if free[0] else 0.0, boom if free[1] else 0.0, jib if free[2] else 0.0


@generic
def free_coupling(free, coupling):
    """Return the inertia coupling of boom and jib: none where friction holds one of them."""
    return coupling


@free_coupling.register(tuple)
def _(free, coupling):
    return coupling if free[1] and free[2] else 0.0


def _solve_luff(pose, b2, b3):
    """Return the accelerations of boom and jib for the right-hand sides [N m] of their equations."""
    c = free_coupling(pose.free, pose.c)
    inverse = 1.0 / (pose.boom_inertia * pose.jib_inertia - c * c)
    return (pose.jib_inertia * b2 - c * b3) * inverse, (pose.boom_inertia * b3 - c * b2) * inverse


def _moments(support, pose, gravity, tau, force):
    """Return the right-hand sides [N m] of the equations of slew, boom and jib; arguments of `support_acceleration`."""
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


@joint_constraint_efforts.register(Knuckle)
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
    luffing = pose.boom_inertia * wb * wb + pose.jib_inertia * wg * wg
    return 0.5 * (pose.slew_inertia * wa * wa + luffing) + pose.c * wb * wg


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
    slew, boom, jib = _imposed_efforts(base, support, pose)
    return (tau[0] + slew, tau[1] + boom, tau[2] + jib, *tau[3:])


@routine
def _imposed_efforts(base, support, pose):
    """Return the efforts (3,) [N m] of the inertial forces of a moving base on slew, boom and jib."""
    boom, jib = support.boom, support.jib
    slew, x, z = imposed_load(base, boom, pose, (0.0, 0.0), (0.0, 0.0), pose.cb, pose.sb, pose.beta_rate)
    length, rate = boom.length, boom.length * pose.beta_rate
    root, root_rate = (length * pose.cb, length * pose.sb), (-rate * pose.sb, rate * pose.cb)
    jib_slew, jx, jz = imposed_load(base, jib, pose, root, root_rate, pose.cg, pose.sg, pose.gamma_rate)
    boom_effort = boom.length * (pose.cb * (0.5 * z + jz) - pose.sb * (0.5 * x + jx))
    jib_effort = 0.5 * jib.length * (pose.cg * jz - pose.sg * jx)
    boom_gyro_slew, boom_gyro = gyroscopic_moments(base, boom, pose, pose.cb, pose.sb, pose.beta_rate)
    jib_gyro_slew, jib_gyro = gyroscopic_moments(base, jib, pose, pose.cg, pose.sg, pose.gamma_rate)
    slew = slew + jib_slew + boom_gyro_slew + jib_gyro_slew - support.tower.inertia * base.angular_acceleration[2]
    return slew, boom_effort + boom_gyro, jib_effort + jib_gyro


def imposed_load(base, rod, pose, root, root_rate, c, s, rate):
    """Return (moment about the vertical [N m], radial, vertical force [N]) that the base imposes on a rod's mass.

    Args:
        base, rod, pose: the base in the slewing frame, the rod, the posture.
        root, root_rate: the rod's lower joint (radial, vertical) [m], and its velocity in the slewing frame [m/s].
        c, s, rate: cosine and sine of the rod's elevation, its rate [rad/s].
    """
    position, velocity = centre_motion(rod, pose, root, root_rate, c, s, rate)
    x, y, z = imposed_acceleration(base, position, velocity)
    return rod.mass * y * position[0], rod.mass * x, rod.mass * z


def centre_motion(rod, pose, root, root_rate, c, s, rate):
    """Return (position [m], velocity [m/s]) of a rod's centre relative to the base; arguments of `imposed_load`."""
    return point_motion(0.5 * rod.length, pose, root, root_rate, c, s, rate)


def point_motion(reach, pose, root, root_rate, c, s, rate):
    """Return (position [m], velocity [m/s]) relative to the base (3,) of a rod's point `reach` [m] from its root."""
    position = (root[0] + reach * c, 0.0, root[1] + reach * s)
    return position, (root_rate[0] - reach * s * rate, pose.yaw_rate * position[0], root_rate[1] + reach * c * rate)


def gyroscopic_moments(base, rod, pose, c, s, rate):
    """Return the moments [N m] (about the vertical e_z, about the luffing axis l = -e_t) of the module's docstring."""
    a, b, d = inertia_tensor(rod.axial_inertia, rod.inertia, c, s)
    w, w_dot, omega = base.angular_velocity, base.angular_acceleration, (0.0, -rate, pose.yaw_rate)
    x, y, z = cross(w, omega)
    epsilon = (x + w_dot[0], y + w_dot[1], z + w_dot[2])
    total = (omega[0] + w[0], omega[1] + w[1], omega[2] + w[2])  # Ω
    d_epsilon, d_total, d_omega = dot(d, epsilon), dot(d, total), dot(d, omega)
    _, total_y, total_z = cross(total, d)
    _, omega_y, omega_z = cross(omega, d)
    bracket_y = a * epsilon[1] + b * (d_epsilon * d[1] + d_total * total_y - d_omega * omega_y)
    bracket_z = a * epsilon[2] + b * (d_epsilon * d[2] + d_total * total_z - d_omega * omega_z)
    return -bracket_z, bracket_y


@generic
def inertia_tensor(axial, inertia, c, s):
    """Return (a, b, d (3,)) of a rod's inertia tensor a 1 + b d dᵀ [kg m²]: without an axial inertia I l lᵀ."""
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


def rod_energy(base, gravity, rod, pose, root, root_rate, c, s, rate):
    """Return (kinetic, potential) energy [J] of a rod in the world less those relative to the base.

    Args:
        base: BaseState.
        gravity: m/s².
        rod, pose, root, root_rate, c, s, rate: see `imposed_load`.
    """
    position, velocity = centre_motion(rod, pose, root, root_rate, c, s, rate)
    kinetic, potential = added_energy(base, gravity, rod.mass, position, velocity)
    omega = (0.0, -rate, pose.yaw_rate)
    return kinetic + added_spin(base, inertia_tensor(rod.axial_inertia, rod.inertia, c, s), omega), potential


@support_polyline_size.register(Knuckle)
def _(support):
    return 3
