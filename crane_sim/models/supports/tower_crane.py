"""Tower crane (hammerhead): a jib that slews about the tower, and a trolley on the jib.

In the slewing frame (e_r, e_t, e_z), with slew angle α, slew inertia J of jib and counter-jib, and a trolley of mass m
at the radius r, under the efforts τ, F and the force f of the cable on the trolley:

    (J + m r²) α'' + 2 m r r' α' = τ + r f_t,    m (r'' - r α'²) = F + f_r.

The jib's underside, where the cable begins, is at height 0. With a locked slew this is the trolley of a bridge crane.
"""

from typing import NamedTuple

from crane_sim.files.types import AngleRange, Positive, Range
from crane_sim.models.guards import Guard, encode, travel_guard
from crane_sim.models.moving_base import added_energy, added_spin, imposed_acceleration
from crane_sim.models.supports import (
    add_imposed_efforts,
    add_yaw_moment,
    coordinate_count,
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
from crane_sim.models.wind_load import JibWindage
from crane_sim.numerics.jit import generic

Vector = tuple[float, float, float]


class Slew(NamedTuple):
    """The slewing part: tower head, jib and counter-jib with its ballast."""

    inertia: Positive  # kg m², about the tower's axis, without trolley and payload
    limits: AngleRange | None = None  # rad, of the slew angle; a run ends where one is reached
    jib_windage: JibWindage | None = None  # of the jib: area and drag in the `wind`
    counter_jib_windage: JibWindage | None = None  # of the counter-jib


class LockedSlew(NamedTuple):
    """A slewing part that is braked."""


class JibTrolley(NamedTuple):
    """The trolley on the jib."""

    mass: Positive  # kg, that moves with it
    limits: Range | None = None  # m, of its radius; a run ends where one is reached


class TowerCrane(NamedTuple):
    """Parameters of the support."""

    slew: Slew | LockedSlew
    trolley: JibTrolley

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("slew", "slew.limits"), ("trolley", "trolley.limits"))[i]


class TowerPosture(NamedTuple):
    """Kinematics of a state."""

    tip: Vector  # m, (r, 0, 0)
    tip_velocity: Vector  # m/s, (r', 0, 0)
    yaw_rate: float  # rad/s


@coordinate_count.register(TowerCrane)
def _(support):
    return 2


@forward_kinematics.register(TowerCrane)
def _(support, xs):
    return TowerPosture((xs[1], 0.0, 0.0), (xs[3], 0.0, 0.0), xs[2])


@generic
def slew_mobility(slew, trolley, radius):
    """Return the inverse of the slew inertia [1/(kg m²)] with the trolley at a radius; 0 of a locked slew."""
    return 1.0 / (slew.inertia + trolley.mass * radius * radius)


@slew_mobility.register(LockedSlew)
def _(slew, trolley, radius):
    return 0.0


@support_acceleration.register(TowerCrane)
def _(support, pose, gravity, tau, force):
    radius, rate, w, mass = pose.tip[0], pose.tip_velocity[0], pose.yaw_rate, support.trolley.mass
    moment = tau[0] + radius * force[1] - 2.0 * mass * radius * rate * w
    slew = moment * slew_mobility(support.slew, support.trolley, radius)
    return slew, (tau[1] + force[0]) / mass + radius * w * w


@tip_acceleration.register(TowerCrane)
def _(support, pose, qdd):
    return (qdd[1], 0.0, 0.0), qdd[0]


@tip_mobility.register(TowerCrane)
def _(support, pose, n):
    lever = pose.tip[0] * n[1]
    return n[0] * n[0] / support.trolley.mass + lever * lever * slew_mobility(
        support.slew, support.trolley, pose.tip[0]
    )


@joint_mobilities.register(TowerCrane)
def _(support, pose):
    return slew_mobility(support.slew, support.trolley, pose.tip[0]), 1.0 / support.trolley.mass


@tip_levers.register(TowerCrane)
def _(support, pose, n):
    return pose.tip[0] * n[1], n[0]


@add_yaw_moment.register(TowerCrane)
def _(support, tau, couple):
    return (tau[0] + couple, *tau[1:])


@drive_power.register(TowerCrane)
def _(support, tau, pose, force):
    return tau[0] * pose.yaw_rate + tau[1] * pose.tip_velocity[0]


@support_guard.register(TowerCrane)
def _(support, best, xs):
    best = slew_guard(support.slew, best, xs[0])
    return travel_guard(support.trolley.limits, best, xs[1], encode(Guard.TRAVEL, 1))


@generic
def slew_guard(slew, best, angle):
    """Return the smaller one of `best` and the guard of the limits of the slew angle."""
    return travel_guard(slew.limits, best, angle, encode(Guard.TRAVEL, 0))


@slew_guard.register(LockedSlew)
def _(slew, best, angle):
    return best


@yaw.register(TowerCrane)
def _(support, xs):
    return xs[0]


@support_polyline.register(TowerCrane)
def _(support, xs):
    return (0.0, 0.0, 0.0), (xs[1], 0.0, 0.0)


@support_polyline_size.register(TowerCrane)
def _(support):
    return 2


@generic
def slew_inertia(slew):
    """Return the inertia [kg m²] about the tower's axis without the trolley; 0 where nothing turns."""
    return slew.inertia


@slew_inertia.register(LockedSlew)
def _(slew):
    return 0.0


@support_kinetic.register(TowerCrane)
def _(support, pose):
    radius, rate, w = pose.tip[0], pose.tip_velocity[0], pose.yaw_rate
    mass = support.trolley.mass
    return 0.5 * (slew_inertia(support.slew) * w * w + mass * (rate * rate + radius * radius * w * w))


@support_potential.register(TowerCrane)
def _(support, pose, gravity):
    return 0.0


@add_imposed_efforts.register(TowerCrane)
def _(support, base, tau, pose):
    radius, mass = pose.tip[0], support.trolley.mass
    x, y, _ = imposed_acceleration(base, pose.tip, (pose.tip_velocity[0], pose.yaw_rate * radius, 0.0))
    slew = radius * mass * y - slew_inertia(support.slew) * base.angular_acceleration[2]
    return (tau[0] + slew, tau[1] + mass * x, *tau[2:])


@support_base_energy.register(TowerCrane)
def _(support, base, pose, gravity):
    velocity = (pose.tip_velocity[0], pose.yaw_rate * pose.tip[0], 0.0)
    kinetic, potential = added_energy(base, gravity, support.trolley.mass, pose.tip, velocity)
    axis = (0.0, slew_inertia(support.slew), (0.0, 0.0, 1.0))
    return kinetic + added_spin(base, axis, (0.0, 0.0, pose.yaw_rate)), potential
