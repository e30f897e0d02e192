"""Mobile crane: a boom that slews, luffs and telescopes.

In the slewing frame (e_r, e_t, e_z) the boom's foot pin is at (a, 0, h); β is the boom's elevation and ℓ its length.
The base section (mass m₁, centre at c₁ from the foot, inertia I₁ across) keeps its place on the boom. The telescoped
section (m₂, I₂) moves out with the tip, its centre at s₂ = ℓ - d₂. With r_i = a + s_i cos β, s₁ = c₁,

    J(β, ℓ) = J₀ + Σ (m_i r_i² + I_i cos²β),  B(ℓ) = Σ (m_i s_i² + I_i),
    J α'' + 2 α' (J_β β' + J_ℓ ℓ') = τ_α + r f_t,                       J_β = ½ ∂J/∂β,  J_ℓ = ½ ∂J/∂ℓ = m₂ r₂ cos β
    B β'' + 2 m₂ s₂ ℓ' β' - J_β α'² + g cos β Σ m_i s_i = τ_β + ℓ (f_z cos β - f_r sin β)
    m₂ (ℓ'' - s₂ β'²) - J_ℓ α'² + m₂ g sin β = F + f_r cos β + f_z sin β

under the efforts τ_α, τ_β, F and the force f of the cable on the tip. Both sections are thin: they have no inertia
about the boom.
"""

from math import cos, sin
from typing import NamedTuple

from crane_sim.files.types import AngleRange, LengthRange, NonNegative, Positive, Real
from crane_sim.models.guards import Guard, encode, travel_guard
from crane_sim.models.moving_base import added_energy, added_spin, cross, dot, imposed_acceleration
from crane_sim.models.supports import (
    add_imposed_efforts,
    add_yaw_moment,
    drive_power,
    forward_kinematics,
    joint_mobilities,
    support_acceleration,
    support_base_energy,
    support_guard,
    support_kinetic,
    support_polyline,
    support_polyline_size,
    support_potential,
    tip_acceleration,
    tip_levers,
    tip_mobility,
    yaw,
)
from crane_sim.models.wind_load import BoomWindage
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine

Vector = tuple[float, float, float]


class Superstructure(NamedTuple):
    """What slews besides the boom: cab, winches, counterweight."""

    inertia: Positive  # kg m², about the slewing axis, without boom and payload
    foot: tuple[Real, Real] = (0.0, 0.0)  # m, the boom's foot pin: ahead of the slewing axis, above the model's origin
    limits: AngleRange | None = None  # rad, of the slew angle; a run ends where one is reached


class BaseSection(NamedTuple):
    """The base section of the boom, with the luffing cylinder's part of the mass."""

    mass: NonNegative  # kg, of the section
    centre: NonNegative  # m, of its mass from the foot pin
    inertia: Positive  # kg m², about a transverse axis through the centre of mass
    limits: AngleRange | None = None  # rad, of the boom's elevation; a run ends where one is reached
    windage: BoomWindage | None = None  # of the whole boom: width and drag in the `wind`


class TelescopedSection(NamedTuple):
    """The section that is telescoped out, with the tip's sheaves."""

    mass: Positive  # kg, of the section
    centre: NonNegative  # m, of its mass from the tip
    inertia: NonNegative  # kg m², about a transverse axis through the centre of mass
    limits: LengthRange | None = None  # m, of the boom's length; a run ends where one is reached


class TelescopicBoom(NamedTuple):
    """Parameters of the support."""

    superstructure: Superstructure
    base_section: BaseSection
    telescope: TelescopedSection

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("slew", "superstructure.limits"), ("boom", "boom.limits"), ("telescope", "telescope.limits"))[i]


class BoomPosture(NamedTuple):
    """Kinematics of a state. Lengths in the slewing frame; symbols as in the equations."""

    tip: Vector  # m, (a + ℓ cos β, 0, h + ℓ sin β)
    tip_velocity: Vector  # m/s
    yaw_rate: float  # rad/s, α'
    cb: float  # cos β
    sb: float
    length: float  # m, ℓ
    luff_rate: float  # rad/s, β'
    length_rate: float  # m/s, ℓ'
    s2: float  # m
    slew_inertia: float  # kg m², J
    j_luff: float  # kg m², J_β
    j_length: float  # kg m, J_ℓ
    luff_inertia: float  # kg m², B


@forward_kinematics.register(TelescopicBoom)
def _(support, xs):
    _, beta, length, yaw_rate, luff_rate, length_rate = xs
    (a, h), first, second = support.superstructure.foot, support.base_section, support.telescope
    sb, cb = sincos(beta)
    s1, s2, inertia = first.centre, length - second.centre, first.inertia + second.inertia
    r1, r2 = a + s1 * cb, a + s2 * cb
    return BoomPosture(
        tip=(a + length * cb, 0.0, h + length * sb),
        tip_velocity=(length_rate * cb - length * sb * luff_rate, 0.0, length_rate * sb + length * cb * luff_rate),
        yaw_rate=yaw_rate,
        cb=cb,
        sb=sb,
        length=length,
        luff_rate=luff_rate,
        length_rate=length_rate,
        s2=s2,
        slew_inertia=support.superstructure.inertia + first.mass * r1 * r1 + second.mass * r2 * r2 + inertia * cb * cb,
        j_luff=-sb * (first.mass * r1 * s1 + second.mass * r2 * s2 + inertia * cb),
        j_length=second.mass * r2 * cb,
        luff_inertia=first.mass * s1 * s1 + second.mass * s2 * s2 + inertia,
    )


def net_efforts(support, pose, gravity, tau, force):
    """Return the efforts (3,) [N m, N m, N] that accelerate α, β and ℓ, but for m₂ s₂ β'² of the last one."""
    first, second = support.base_section, support.telescope
    w, luff, rate = pose.yaw_rate, pose.luff_rate, pose.length_rate
    slew = tau[0] + pose.tip[0] * force[1] - 2.0 * w * (pose.j_luff * luff + pose.j_length * rate)
    across = pose.cb * force[2] - pose.sb * force[0]
    weight = gravity * pose.cb * (first.mass * first.centre + second.mass * pose.s2)
    boom = tau[1] + pose.length * across - weight - 2.0 * second.mass * pose.s2 * rate * luff + pose.j_luff * w * w
    along = tau[2] + pose.cb * force[0] + pose.sb * force[2] - second.mass * gravity * pose.sb + pose.j_length * w * w
    return slew, boom, along


@support_acceleration.register(TelescopicBoom)
def _(support, pose, gravity, tau, force):
    slew, boom, along = net_efforts(support, pose, gravity, tau, force)
    centripetal = pose.s2 * pose.luff_rate * pose.luff_rate
    return slew / pose.slew_inertia, boom / pose.luff_inertia, along / support.telescope.mass + centripetal


@tip_acceleration.register(TelescopicBoom)
def _(support, pose, qdd):
    along = qdd[2] - pose.length * pose.luff_rate * pose.luff_rate
    across = pose.length * qdd[1] + 2.0 * pose.length_rate * pose.luff_rate
    return (along * pose.cb - across * pose.sb, 0.0, along * pose.sb + across * pose.cb), qdd[0]


@tip_mobility.register(TelescopicBoom)
def _(support, pose, n):
    slew, boom = pose.tip[0] * n[1], pose.length * (pose.cb * n[2] - pose.sb * n[0])
    along = pose.cb * n[0] + pose.sb * n[2]
    return slew * slew / pose.slew_inertia + boom * boom / pose.luff_inertia + along * along / support.telescope.mass


@joint_mobilities.register(TelescopicBoom)
def _(support, pose):
    return 1.0 / pose.slew_inertia, 1.0 / pose.luff_inertia, 1.0 / support.telescope.mass


@tip_levers.register(TelescopicBoom)
def _(support, pose, n):
    return pose.tip[0] * n[1], pose.length * (pose.cb * n[2] - pose.sb * n[0]), pose.cb * n[0] + pose.sb * n[2]


@add_yaw_moment.register(TelescopicBoom)
def _(support, tau, couple):
    return (tau[0] + couple, *tau[1:])


@drive_power.register(TelescopicBoom)
def _(support, tau, pose, force):
    return tau[0] * pose.yaw_rate + tau[1] * pose.luff_rate + tau[2] * pose.length_rate


@support_guard.register(TelescopicBoom)
def _(support, best, xs):
    best = travel_guard(support.superstructure.limits, best, xs[0], encode(Guard.TRAVEL, 0))
    best = travel_guard(support.base_section.limits, best, xs[1], encode(Guard.TRAVEL, 1))
    return travel_guard(support.telescope.limits, best, xs[2], encode(Guard.TRAVEL, 2))


@yaw.register(TelescopicBoom)
def _(support, xs):
    return xs[0]


@support_polyline.register(TelescopicBoom)
def _(support, xs):
    a, h = support.superstructure.foot
    return (0.0, 0.0, 0.0), (a, 0.0, h), (a + xs[2] * cos(xs[1]), 0.0, h + xs[2] * sin(xs[1]))


@support_polyline_size.register(TelescopicBoom)
def _(support):
    return 3


@support_kinetic.register(TelescopicBoom)
def _(support, pose):
    w, luff, rate = pose.yaw_rate, pose.luff_rate, pose.length_rate
    return 0.5 * (pose.slew_inertia * w * w + pose.luff_inertia * luff * luff + support.telescope.mass * rate * rate)


@support_potential.register(TelescopicBoom)
def _(support, pose, gravity):
    first, second, (_, h) = support.base_section, support.telescope, support.superstructure.foot
    moments = first.mass * first.centre + second.mass * pose.s2
    return gravity * (moments * pose.sb + (first.mass + second.mass) * h)


def centre_motion(support, pose, distance, rate):
    """Return (position [m], velocity [m/s]) relative to the base (3,) of a point on the boom.

    Args:
        support, pose: the crane and its posture.
        distance, rate: of the point from the foot pin, and how fast it moves out.
    """
    (a, h), w = support.superstructure.foot, pose.luff_rate
    at = (a + distance * pose.cb, 0.0, h + distance * pose.sb)
    radial, vertical = rate * pose.cb - distance * pose.sb * w, rate * pose.sb + distance * pose.cb * w
    return at, (radial, pose.yaw_rate * at[0], vertical)


@add_imposed_efforts.register(TelescopicBoom)
def _(support, base, tau, pose):
    slew, luff, along = _base_efforts(base, support, pose)
    return (tau[0] + slew, tau[1] + luff, tau[2] + along, *tau[3:])


@routine
def _base_efforts(base, support, pose):
    """Return the efforts (3,) of the base's inertial forces on superstructure and boom."""
    first, second = support.base_section, support.telescope
    at, velocity = centre_motion(support, pose, first.centre, 0.0)
    x, y, z = imposed_acceleration(base, at, velocity)
    slew, luff = first.mass * at[0] * y, first.mass * first.centre * (pose.cb * z - pose.sb * x)
    at, velocity = centre_motion(support, pose, pose.s2, pose.length_rate)
    x, y, z = imposed_acceleration(base, at, velocity)
    slew, luff = slew + second.mass * at[0] * y, luff + second.mass * pose.s2 * (pose.cb * z - pose.sb * x)
    along = second.mass * (pose.cb * x + pose.sb * z)
    slew_couple, luff_couple = gyroscopic_moments(base, pose, first.inertia + second.inertia)
    return (
        slew + slew_couple - support.superstructure.inertia * base.angular_acceleration[2],
        luff + luff_couple,
        along,
    )


def gyroscopic_moments(base, pose, inertia):
    """Return the moments [N m] about the vertical and the luffing axis by which thin sections resist the base's turns.

    Their tensor is I (1 - d dᵀ), d along the boom; see `knuckle_boom` for the general case.
    """
    own, d = (0.0, -pose.luff_rate, pose.yaw_rate), (pose.cb, 0.0, pose.sb)
    x, y, z = cross(base.angular_velocity, own)
    s = (x + base.angular_acceleration[0], y + base.angular_acceleration[1], z + base.angular_acceleration[2])
    whole = (own[0] + base.angular_velocity[0], own[1] + base.angular_velocity[1], own[2] + base.angular_velocity[2])
    along, first, second = dot(d, s), dot(d, whole), dot(d, own)
    _, whole_y, whole_z = cross(whole, d)
    _, own_y, own_z = cross(own, d)
    luffing = inertia * (s[1] - along * d[1] - first * whole_y + second * own_y)
    slewing = inertia * (s[2] - along * d[2] - first * whole_z + second * own_z)
    return -slewing, luffing


@support_base_energy.register(TelescopicBoom)
def _(support, base, pose, gravity):
    first, second = support.base_section, support.telescope
    at, velocity = centre_motion(support, pose, first.centre, 0.0)
    kinetic, potential = added_energy(base, gravity, first.mass, at, velocity)
    at, velocity = centre_motion(support, pose, pose.s2, pose.length_rate)
    more = added_energy(base, gravity, second.mass, at, velocity)
    own, inertia = (0.0, -pose.luff_rate, pose.yaw_rate), first.inertia + second.inertia
    turns = added_spin(base, (inertia, -inertia, (pose.cb, 0.0, pose.sb)), own)
    turns += added_spin(base, (0.0, support.superstructure.inertia, (0.0, 0.0, 1.0)), (0.0, 0.0, pose.yaw_rate))
    return kinetic + more[0] + turns, potential + more[1]
