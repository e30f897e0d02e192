"""Optional effects: a NamedTuple of parameters and an add_* function each. None (absent) returns what it was given.

To add one: write its NamedTuple, register its function (and its `*_power` or `*_energy`), name it in the model, and in
the scene schema.
"""

from math import atan2, sqrt
from typing import Any, NamedTuple

from crane_sim.files.types import Angle, NonNegative, Real
from crane_sim.numerics.jit import generic
from crane_sim.trajectories.inputs import Constant


class RopeSpring(NamedTuple):
    """A linear spring along the rope: force -stiffness (length - rest)."""

    stiffness: NonNegative  # N/m, force for a change of length
    rest: Real  # m, length without force


class BoomSpring(NamedTuple):
    """A linear spring on the boom's elevation."""

    stiffness: NonNegative  # N m/rad, torque for a turn
    rest: Angle  # rad, elevation without torque


class JibSpring(NamedTuple):
    """A linear spring on the jib, about its elevation or about its angle from the boom."""

    stiffness: NonNegative  # N m/rad, torque for a turn
    rest: Angle  # rad, angle without torque
    relative: bool = False  # true: acts between boom and jib, on their angle, and turns both


@generic
def add_spring(spring, effort, q):
    """Return effort plus the spring's at coordinate q."""
    return effort


@add_spring.register(BoomSpring)
@add_spring.register(RopeSpring)
def _(spring, effort, q):
    return effort - spring.stiffness * (q - spring.rest)


@generic
def add_spring_energy(spring, energy, q):
    """Return energy plus the spring's at coordinate q."""
    return energy


@add_spring_energy.register(BoomSpring)
@add_spring_energy.register(RopeSpring)
def _(spring, energy, q):
    return energy + 0.5 * spring.stiffness * (q - spring.rest) ** 2


@generic
def add_jib_spring(spring, boom, jib, beta, gamma):
    """Return the moments (boom, jib) plus the spring's at elevations beta and gamma."""
    return boom, jib


@add_jib_spring.register(JibSpring)
def _(spring, boom, jib, beta, gamma):
    if spring.relative:
        moment = spring.stiffness * (gamma - beta - spring.rest)
        return boom + moment, jib - moment
    return boom, jib - spring.stiffness * (gamma - spring.rest)


@generic
def add_jib_spring_energy(spring, energy, beta, gamma):
    """Return energy plus the spring's at elevations beta and gamma."""
    return energy


@add_jib_spring_energy.register(JibSpring)
def _(spring, energy, beta, gamma):
    deflection = gamma - beta - spring.rest if spring.relative else gamma - spring.rest
    return energy + 0.5 * spring.stiffness * deflection**2


class PayloadDrag(NamedTuple):
    """Quadratic air drag on the payload: force -coefficient |v| v, v the velocity in still air."""

    coefficient: NonNegative  # kg/m, c of the force -c |v| v


@generic
def add_drag(drag, force, velocity):
    """Return the force (3,) plus the drag on a body moving at velocity (3,), both in the same axes."""
    return force


@add_drag.register(PayloadDrag)
def _(drag, force, velocity):
    fx, fy, fz = force
    vx, vy, vz = velocity
    c = drag.coefficient * sqrt(vx * vx + vy * vy + vz * vz)
    return fx - c * vx, fy - c * vy, fz - c * vz


class PayloadForce(NamedTuple):
    """A given force on the payload along the axes of the world: wind, a tag line, a push."""

    x: Any = Constant(0.0)  # N, of time: an input of `trajectories.inputs`
    y: Any = Constant(0.0)
    z: Any = Constant(0.0)


class QuadraticFriction(NamedTuple):
    """Swing joint friction tangential cos²θ2 |θ1'| θ1' and radial |θ2'| θ2' [N m] (paper, eq. 14, corrected)."""

    tangential: NonNegative  # N m s², about the tangential swing's axis
    radial: NonNegative  # N m s², about the radial swing's axis


class LinearFriction(NamedTuple):
    """Swing joint friction tangential cos²θ2 θ1' and radial θ2' [N m] (knuckle paper, eq. 19)."""

    tangential: NonNegative  # N m s, about the tangential swing's axis
    radial: NonNegative  # N m s, about the radial swing's axis


class PaperFriction(NamedTuple):
    """Swing joint friction tangential cos²θ2 |θ1| θ1' and radial |θ2| θ2' [N m], as the knuckle paper prints it."""

    tangential: NonNegative  # N m s, about the tangential swing's axis
    radial: NonNegative  # N m s, about the radial swing's axis


@generic
def swing_moments(friction, n, w1, w2):
    """Return the friction moments [N m] about the two swing axes per unit of lever.

    Args:
        friction: the friction model.
        n: unit vector from tip to payload (3,), in the axes of the support's frame.
        w1: cos θ2 θ1', the tangential component of n' [1/s].
        w2: θ2', its radial component [1/s].

    Returns:
        (f1 / cos θ2, f2): what, divided by the rope length, pulls on the payload against ê1 and ê2.
    """
    return 0.0, 0.0


@swing_moments.register(LinearFriction)
def _(friction, n, w1, w2):
    return friction.tangential * w1, friction.radial * w2


@swing_moments.register(QuadraticFriction)
def _(friction, n, w1, w2):
    c2 = sqrt(n[1] * n[1] + n[2] * n[2])  # θ1' = w1 / c2 has no limit at c2 = 0: there the model itself ends
    return friction.tangential * abs(w1) * w1 / c2, friction.radial * abs(w2) * w2


@swing_moments.register(PaperFriction)
def _(friction, n, w1, w2):
    c2 = sqrt(n[1] * n[1] + n[2] * n[2])
    theta1, theta2 = atan2(n[1], -n[2]), atan2(n[0], c2)
    return friction.tangential * abs(theta1) * w1, friction.radial * abs(theta2) * w2
