"""Bridge crane: a trolley along x on a bridge (or a portal) along y, both driven by force.

    m x'' = F_x + f_x,    (m + M) y'' = F_y + f_y

with the masses m of the trolley, M of the bridge, and the force f of the cable on the trolley, whose rail is at height
0. The bridge's centre of mass is at x = 0.
"""

from typing import NamedTuple

from crane_sim.files.types import Positive, Range
from crane_sim.models.guards import Guard, encode, travel_guard
from crane_sim.models.moving_base import added_energy, imposed_acceleration
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

Vector = tuple[float, float, float]


class DrivenAxis(NamedTuple):
    """A trolley or a bridge that takes a force command."""

    mass: Positive  # kg, that moves with it, the trolley's apart from the bridge's
    limits: Range | None = None  # m, of its position; a run ends where one is reached


class Bridge(NamedTuple):
    """Parameters of the support."""

    trolley: DrivenAxis
    bridge: DrivenAxis

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("trolley", "trolley.limits"), ("bridge", "bridge.limits"))[i]


class BridgePosture(NamedTuple):
    """Kinematics of a state."""

    tip: Vector  # m, (x, y, 0)
    tip_velocity: Vector  # m/s
    yaw_rate: float  # rad/s, 0


@coordinate_count.register(Bridge)
def _(support):
    return 2


@forward_kinematics.register(Bridge)
def _(support, xs):
    return BridgePosture((xs[0], xs[1], 0.0), (xs[2], xs[3], 0.0), 0.0)


@support_acceleration.register(Bridge)
def _(support, pose, gravity, tau, force):
    mass = support.trolley.mass
    return (tau[0] + force[0]) / mass, (tau[1] + force[1]) / (mass + support.bridge.mass)


@tip_acceleration.register(Bridge)
def _(support, pose, qdd):
    return (qdd[0], qdd[1], 0.0), 0.0


@tip_mobility.register(Bridge)
def _(support, pose, n):
    mass = support.trolley.mass
    return n[0] * n[0] / mass + n[1] * n[1] / (mass + support.bridge.mass)


@joint_mobilities.register(Bridge)
def _(support, pose):
    mass = support.trolley.mass
    return 1.0 / mass, 1.0 / (mass + support.bridge.mass)


@tip_levers.register(Bridge)
def _(support, pose, n):
    return n[0], n[1]


@add_yaw_moment.register(Bridge)
def _(support, tau, couple):
    return tau


@drive_power.register(Bridge)
def _(support, tau, pose, force):
    return tau[0] * pose.tip_velocity[0] + tau[1] * pose.tip_velocity[1]


@support_guard.register(Bridge)
def _(support, best, xs):
    best = travel_guard(support.trolley.limits, best, xs[0], encode(Guard.TRAVEL, 0))
    return travel_guard(support.bridge.limits, best, xs[1], encode(Guard.TRAVEL, 1))


@yaw.register(Bridge)
def _(support, xs):
    return 0.0


@support_polyline.register(Bridge)
def _(support, xs):
    return ((xs[0], xs[1], 0.0),)


@support_polyline_size.register(Bridge)
def _(support):
    return 1


@support_kinetic.register(Bridge)
def _(support, pose):
    (vx, vy, _), mass = pose.tip_velocity, support.trolley.mass
    return 0.5 * (mass * vx * vx + (mass + support.bridge.mass) * vy * vy)


@support_potential.register(Bridge)
def _(support, pose, gravity):
    return 0.0


@add_imposed_efforts.register(Bridge)
def _(support, base, tau, pose):
    x, y, _ = imposed_acceleration(base, pose.tip, pose.tip_velocity)
    _, bridge_y, _ = imposed_acceleration(base, (0.0, pose.tip[1], 0.0), (0.0, pose.tip_velocity[1], 0.0))
    mass = support.trolley.mass
    return (tau[0] + mass * x, tau[1] + mass * y + support.bridge.mass * bridge_y, *tau[2:])


@support_base_energy.register(Bridge)
def _(support, base, pose, gravity):
    kinetic, potential = added_energy(base, gravity, support.trolley.mass, pose.tip, pose.tip_velocity)
    middle, moves = (0.0, pose.tip[1], 0.0), (0.0, pose.tip_velocity[1], 0.0)
    own = added_energy(base, gravity, support.bridge.mass, middle, moves)
    return kinetic + own[0], potential + own[1]
