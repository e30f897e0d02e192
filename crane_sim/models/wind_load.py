"""Forces of the wind on bodies: ½ ρ C A |v| v at the centre of pressure.

v is the wind less the velocity of that point.

A rod takes the part of v across it only: flow along a slender body does not press on it (the
cross-flow principle, Hoerner, Fluid-Dynamic Drag, 1965, chapter 3). All vectors are in the axes of
the base, or in axes turned about its z, those of a crane's support.
"""

from math import sqrt
from typing import NamedTuple

from crane_sim.files.types import Fraction, NonNegative, Real
from crane_sim.models.moving_base import pose_at, to_base, to_world
from crane_sim.multibody.vectors import Vector, add, dot, scale, subtract, to_turned_axes
from crane_sim.numerics.elementary import sincos
from crane_sim.trajectories.wind import LogarithmicLaw, PowerLaw, gust_at, speed_ratio


class Windage(NamedTuple):
    """Area and drag coefficient of a body, a point mass or one with a centre of pressure."""

    area: NonNegative  # m², that the wind sees
    drag_coefficient: NonNegative  # -, some 1.2 of a box or a tube


class RodWindage(NamedTuple):
    """Area and drag coefficient of a rod, for the part of the wind across it."""

    area: NonNegative  # m², that a wind across the rod sees
    drag_coefficient: NonNegative  # -, some 1.2 of a tube, 1.7 of a truss of flat-sided members
    centre: Fraction = 0.5  # -, of pressure, from the rod's lower joint, in units of its length


class JibWindage(NamedTuple):
    """Area and drag coefficient of a tower crane's jib or counter-jib for the wind across it."""

    area: NonNegative  # m², that a wind across the jib sees
    drag_coefficient: NonNegative  # -, some 1.7 of a truss of flat-sided members
    centre: Real  # m, of pressure, from the tower's axis; negative behind it


class BoomWindage(NamedTuple):
    """Width and drag coefficient of a telescopic boom, for the wind across its telescoped part."""

    width: NonNegative  # m, mean, that a wind across the boom sees
    drag_coefficient: NonNegative  # -, some 1.2 of a box with rounded corners


AnyWindage = Windage | RodWindage | JibWindage | BoomWindage


class Airflow(NamedTuple):
    """The wind at one instant."""

    mean: Vector  # m/s, at the reference height
    gust: Vector  # m/s
    up: Vector  # the world's vertical
    height: float  # m, of the axes' origin above the ground
    reference: float  # m, the reference height
    profile: PowerLaw | LogarithmicLaw | None
    density: float  # kg/m³


def airflow_at(wind, base, t, angle):
    """Return the Airflow at time t [s], None without wind.

    Its axes are turned by an angle [rad] about the base's z.
    """
    if wind is None:
        return None
    pose, (x, y), (u, v, w) = (
        pose_at(base, t),
        wind.direction,
        [gust_at(gust, t) for gust in wind.gusts],
    )
    mean = to_base(pose, (wind.speed * x, wind.speed * y, 0.0))
    gust = to_base(pose, (u * x - v * y, u * y + v * x, w))
    height = wind.origin_height + to_world(pose, (0.0, 0.0, 0.0))[2]
    up = to_base(pose, (0.0, 0.0, 1.0))
    return turned_flow(
        Airflow(mean, gust, up, height, wind.height, wind.profile, wind.density), angle
    )


def turned_flow(flow, angle):
    """Return the Airflow in axes turned by an angle [rad] about its own z; None without wind."""
    if flow is None:
        return None
    s, c = sincos(angle)
    mean, gust, up = (
        to_turned_axes(flow.mean, s, c),
        to_turned_axes(flow.gust, s, c),
        to_turned_axes(flow.up, s, c),
    )
    return Airflow(mean, gust, up, flow.height, flow.reference, flow.profile, flow.density)


def relative_flow(flow, r, velocity):
    """Return the velocity (3,) [m/s] of the wind at r [m] less that of a body.

    `velocity` [m/s] is the body's through still air.
    """
    ratio = speed_ratio(flow.profile, flow.height + dot(flow.up, r), flow.reference)
    return subtract(add(scale(ratio, flow.mean), flow.gust), velocity)


def pressure_drag(flow, windage, v):
    """Return the force (3,) [N] on a body in a relative flow v (3,) [m/s]."""
    return scale(0.5 * flow.density * windage.drag_coefficient * windage.area * sqrt(dot(v, v)), v)


def add_wind(flow, windage, force, r, velocity):
    """Return the force (3,) [N] plus the wind's on a body.

    Args:
        flow: the Airflow, None without wind.
        windage: the body's, None where it has none.
        force: on the body (3,) [N].
        r, velocity: of the body (3,): its position [m] and its velocity through still air [m/s].
    """
    if flow is None or windage is None:
        return force
    return add(force, pressure_drag(flow, windage, relative_flow(flow, r, velocity)))


def rod_drag(windage, flow, along, r, velocity):
    """Return the force (3,) [N] of the wind on a rod along `along`; others as in `add_wind`.

    `along` is a unit vector.
    """
    if windage is None:
        return 0.0, 0.0, 0.0
    v = relative_flow(flow, r, velocity)
    return pressure_drag(flow, windage, subtract(v, scale(dot(v, along), along)))
