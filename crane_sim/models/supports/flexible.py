"""Flexible structures: a jib or boom that bends about its root, sideways and in its own plane.

Each first bending mode is one of a rigid body on a spring (a pseudo-rigid-body model; Howell, Compliant Mechanisms,
2001, chapter 5). The inner body turns with the drives; the outer one carries the cable and turns by further angles, ε
about the vertical and δ about the root's transverse axis. Both are a boom of `telescopic_boom`, (α, β, ℓ) and
(α + ε, β + δ, ℓ), whose equations have no products of different accelerations. So the bodies share none either:

    J_o (α'' + ε'') = Q_o - k (ε - ε₀) - c ε',    J_i α'' = τ + Q_i + k (ε - ε₀) + c ε',    and alike for β and δ,

Q the terms of `telescopic_boom` for either boom, with the cable's force on the outer one. An axis without a compliance
has the sum of both. The structure's own weight bends it as well; where a spring is relaxed is its camber.

Efforts stand in the order of the coordinates here: those of the support, [ε], [δ], then the winch's.

With the angle of the outer body in place of ε or δ the mass matrix is diagonal, so that friction and motors of the
drives, which are on the inner one, can go with it (`actuated_support`): a drive that is held leaves the outer body as
free as it was. `joint_mobilities` and `tip_levers` are of these coordinates.
"""

from math import inf
from typing import Any, NamedTuple

from crane_sim.models.moving_base import turned_about_z
from crane_sim.models.supports import (
    add_imposed_efforts,
    add_yaw_moment,
    coordinate_count,
    drive_power,
    forward_kinematics,
    joint_mobilities,
    joint_motion,
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
    trailing_count,
    with_wind,
    yaw,
)
from crane_sim.models.supports.backlash import (
    joint_efforts,
    permute_to_coordinate_order,
    permute_to_joint_order,
    to_coordinate_order,
    to_joint_order,
)
from crane_sim.models.supports.compliance import (
    Compliance,
    add_elastic,
    as_entries,
    axis_accelerations,
    compliance_count,
    compliance_effort,
    compliance_energy,
    compliance_entry,
    drive_inertia,
    drive_lever,
    outer_inertia,
)
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.models.supports.telescopic_boom import TelescopicBoom, net_efforts
from crane_sim.models.supports.tower_crane import TowerCrane
from crane_sim.models.wind_load import turned_flow
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_entry

Vector = tuple[float, float, float]


class FlexibleSupport(NamedTuple):
    """A support whose structure bends: its coordinates are those of the rigid one, then those of ε and δ it has."""

    support: Any  # the rigid support, whose coordinates are the drives'
    inner: TelescopicBoom  # what turns with the drives; its telescoped section has no mass
    outer: TelescopicBoom  # what bends: its base section and what moves along it; its superstructure has no inertia
    lateral: Compliance | None  # about the vertical
    vertical: Compliance | None  # in the structure's own plane

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return self.support.coordinate(i)


class FlexibleState(NamedTuple):
    """State of the support."""

    inner: tuple[float, ...]  # of the rigid support
    angles: tuple[float, float]  # rad, ε and δ
    rates: tuple[float, float]  # rad/s


class FlexiblePosture(NamedTuple):
    """Kinematics of a state, in axes that turn with the outer body; the inner body's are turned back by ε."""

    tip: Vector  # m
    tip_velocity: Vector  # m/s
    yaw_rate: float  # rad/s, α' + ε'
    inner: Any  # posture of the inner boom, in its own axes
    outer: Any  # of the outer one
    angles: tuple[float, float]  # rad, ε and δ
    rates: tuple[float, float]  # rad/s


def rigid_support(support: Any) -> Any:
    """Return the support as it is without bending."""
    return support.support if isinstance(support, FlexibleSupport | SwayingTower) else support


def elastic_entries(support, row, i):
    """Return the entries (ε, δ) of a row whose entries of the support begin at i; 0 of a rigid axis."""
    at = i + coordinate_count(support.support)
    lateral = compliance_entry(support.lateral, row, at)
    return lateral, compliance_entry(support.vertical, row, at + compliance_count(support.lateral))


@generic
def boom_coordinates(support, inner):
    """Return (elevation, its rate, length, its rate) of the booms at a rigid support's state."""
    return inner[1], inner[4], inner[2], inner[5]


@boom_coordinates.register(TowerCrane)
def _(support, inner):
    return 0.0, 0.0, inner[1], inner[3]


@generic
def split_efforts(support, tau):
    """Return (efforts of slew, elevation, length, the further ones) of a rigid support; those of no joint are 0."""
    return tau[0], tau[1], tau[2], tau[3:]


@split_efforts.register(TowerCrane)
def _(support, tau):
    return tau[0], 0.0, tau[1], tau[2:]


@generic
def as_coordinates(support, slew, elevation, length):
    """Return what belongs to slew, elevation and length as a tuple in the order of a rigid support's coordinates."""
    return slew, elevation, length


@as_coordinates.register(TowerCrane)
def _(support, slew, elevation, length):
    return slew, length


@generic
def slew_elevation_length(support, qdd):
    """Return a rigid support's coordinate accelerations as those of (slew, elevation, length)."""
    return qdd[0], qdd[1], qdd[2]


@slew_elevation_length.register(TowerCrane)
def _(support, qdd):
    return qdd[0], 0.0, qdd[1]


@generic
def inner_elevation_inertia(support, pose):
    """Return the inner body's inertia [kg m²] about the root's transverse axis: without end where no drive turns it."""
    return pose.inner.luff_inertia


@inner_elevation_inertia.register(TowerCrane)
def _(support, pose):
    return inf


def body_inertias(support, pose):
    """Return the inertias (inner, outer) [kg m²] about the vertical, and those about the root's transverse axis."""
    elevation = inner_elevation_inertia(support.support, pose), pose.outer.luff_inertia
    return (pose.inner.slew_inertia, pose.outer.slew_inertia), elevation


def add_body_efforts(support, tau, inner, outer):
    """Return efforts tau plus those (3,) on slew, elevation and length of either body."""
    own = as_coordinates(support.support, inner[0] + outer[0], inner[1] + outer[1], inner[2] + outer[2])
    for i in range(len(own)):
        tau = replace_entry(tau, i, tau[i] + own[i])
    tau, at = add_elastic(support.lateral, tau, len(own), outer[0]), len(own) + compliance_count(support.lateral)
    return add_elastic(support.vertical, tau, at, outer[1])


@coordinate_count.register(FlexibleSupport)
def _(support):
    elastic = compliance_count(support.lateral) + compliance_count(support.vertical)
    return coordinate_count(support.support) + elastic


@trailing_count.register(FlexibleSupport)
def _(support):
    return compliance_count(support.lateral) + compliance_count(support.vertical)


@to_joint_order.register(FlexibleSupport)
def _(support, row):
    return permute_to_joint_order(support, row)


@to_coordinate_order.register(FlexibleSupport)
def _(support, row):
    return permute_to_coordinate_order(support, row)


@joint_motion.register(FlexibleSupport)
def _(support, xs, i):
    return joint_motion(support.support, xs.inner, i)


@forward_kinematics.register(FlexibleSupport)
def _(support, xs):
    elevation, elevation_rate, length, rate = boom_coordinates(support.support, xs.inner)
    (twist, bend), (twist_rate, bend_rate) = xs.angles, xs.rates
    _, w = joint_motion(support.support, xs.inner, 0)
    inner = forward_kinematics(support.inner, (0.0, elevation, length, w, elevation_rate, rate))
    turned = (0.0, elevation + bend, length, w + twist_rate, elevation_rate + bend_rate, rate)
    outer = forward_kinematics(support.outer, turned)
    return FlexiblePosture(
        outer.tip, outer.tip_velocity, outer.yaw_rate, inner, outer, (twist, bend), (twist_rate, bend_rate)
    )


@joint_efforts.register(FlexibleSupport)
def _(support, tau, pose):
    slew, elevation, length, further = split_efforts(support.support, tau)
    (twist, bend), (twist_rate, bend_rate) = pose.angles, pose.rates
    lateral = as_entries(support.lateral, compliance_effort(support.lateral, twist, twist_rate))
    vertical = as_entries(support.vertical, compliance_effort(support.vertical, bend, bend_rate))
    return (*as_coordinates(support.support, slew, elevation, length), *lateral, *vertical, *further)


@support_acceleration.register(FlexibleSupport)
def _(support, pose, gravity, tau, force):
    inner = net_efforts(support.inner, pose.inner, gravity, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    outer = net_efforts(support.outer, pose.outer, gravity, (0.0, 0.0, 0.0), force)
    elastic, (about_z, across) = elastic_entries(support, tau, 0), body_inertias(support, pose)
    slew, elevation, length, _ = split_efforts(support.support, tau)
    slewing = slew + inner[0] + outer[0], elastic[0] + outer[0]
    luffing = elevation + inner[1] + outer[1], elastic[1] + outer[1]
    first, twist = axis_accelerations(support.lateral, slewing[0], slewing[1], about_z)
    second, bend = axis_accelerations(support.vertical, luffing[0], luffing[1], across)
    third = (length + outer[2]) / support.outer.telescope.mass + pose.outer.s2 * pose.outer.luff_rate**2
    own = as_coordinates(support.support, first, second, third)
    return (*own, *as_entries(support.lateral, twist), *as_entries(support.vertical, bend))


@tip_acceleration.register(FlexibleSupport)
def _(support, pose, qdd):
    (slew, elevation, length), (twist, bend) = (
        slew_elevation_length(support.support, qdd),
        elastic_entries(support, qdd, 0),
    )
    return tip_acceleration(support.outer, pose.outer, (slew + twist, elevation + bend, length))


@tip_mobility.register(FlexibleSupport)
def _(support, pose, n):
    outer, (about_z, across) = pose.outer, body_inertias(support, pose)
    slew, boom = outer.tip[0] * n[1], outer.length * (outer.cb * n[2] - outer.sb * n[0])
    along = outer.cb * n[0] + outer.sb * n[2]
    slewing = slew * slew / outer_inertia(support.lateral, about_z[0], about_z[1])
    bending = boom * boom / outer_inertia(support.vertical, across[0], across[1])
    return slewing + bending + along * along / support.outer.telescope.mass


@joint_mobilities.register(FlexibleSupport)
def _(support, pose):
    about_z, across = body_inertias(support, pose)
    slew, elevation = drive_inertia(support.lateral, *about_z), drive_inertia(support.vertical, *across)
    drives = as_coordinates(support.support, 1.0 / slew, 1.0 / elevation, 1.0 / support.outer.telescope.mass)
    lateral = as_entries(support.lateral, 1.0 / about_z[1])
    return (*drives, *lateral, *as_entries(support.vertical, 1.0 / across[1]))


@tip_levers.register(FlexibleSupport)
def _(support, pose, n):
    slew, boom, along = tip_levers(support.outer, pose.outer, n)
    drives = drive_lever(support.lateral, slew), drive_lever(support.vertical, boom), along
    outer = (*as_entries(support.lateral, slew), *as_entries(support.vertical, boom))
    return (*as_coordinates(support.support, *drives), *outer)


@add_yaw_moment.register(FlexibleSupport)
def _(support, tau, couple):
    return add_body_efforts(support, tau, (0.0, 0.0, 0.0), (couple, 0.0, 0.0))


@add_imposed_efforts.register(FlexibleSupport)
def _(support, base, tau, pose):
    nothing = (0.0, 0.0, 0.0)
    inner = add_imposed_efforts(support.inner, turned_about_z(base, -pose.angles[0]), nothing, pose.inner)
    return add_body_efforts(support, tau, inner, add_imposed_efforts(support.outer, base, nothing, pose.outer))


@with_wind.register(FlexibleSupport)
def _(support, tau, flow, base, pose):
    nothing, back = (0.0, 0.0, 0.0), -pose.angles[0]
    inner = with_wind(support.inner, nothing, turned_flow(flow, back), turned_about_z(base, back), pose.inner)
    return add_body_efforts(support, tau, inner, with_wind(support.outer, nothing, flow, base, pose.outer))


@drive_power.register(FlexibleSupport)
def _(support, tau, pose, force):
    slew, elevation, length, _ = split_efforts(support.support, tau)
    power = slew * pose.inner.yaw_rate + elevation * pose.inner.luff_rate + length * pose.outer.length_rate
    lateral, vertical = elastic_entries(support, tau, 0)  # with the springs, whose energy is potential
    power += (lateral + compliance_energy(support.lateral, pose.angles[0])[1]) * pose.rates[0]
    return power + (vertical + compliance_energy(support.vertical, pose.angles[1])[1]) * pose.rates[1]


@support_guard.register(FlexibleSupport)
def _(support, best, xs):
    return support_guard(support.support, best, xs.inner)


@yaw.register(FlexibleSupport)
def _(support, xs):
    return yaw(support.support, xs.inner) + xs.angles[0]


@generic
def structure_polyline(support, tip):
    """Return the polyline of a bent support from its base to the tip (3,)."""
    a, h = support.superstructure.foot
    return (0.0, 0.0, 0.0), (a, 0.0, h), tip


@structure_polyline.register(TowerCrane)
def _(support, tip):
    return (0.0, 0.0, 0.0), tip


@support_polyline.register(FlexibleSupport)
def _(support, xs):
    return structure_polyline(support.support, forward_kinematics(support, xs).tip)


@support_polyline_size.register(FlexibleSupport)
def _(support):
    return support_polyline_size(support.support)


@support_kinetic.register(FlexibleSupport)
def _(support, pose):
    return support_kinetic(support.inner, pose.inner) + support_kinetic(support.outer, pose.outer)


@support_potential.register(FlexibleSupport)
def _(support, pose, gravity):
    inner = support_potential(support.inner, pose.inner, gravity)
    springs = compliance_energy(support.lateral, pose.angles[0])[0]
    springs += compliance_energy(support.vertical, pose.angles[1])[0]
    return inner + support_potential(support.outer, pose.outer, gravity) + springs


@support_base_energy.register(FlexibleSupport)
def _(support, base, pose, gravity):
    back = turned_about_z(base, -pose.angles[0])
    kinetic, potential = support_base_energy(support.inner, back, pose.inner, gravity)
    more = support_base_energy(support.outer, base, pose.outer, gravity)
    return kinetic + more[0], potential + more[1]
