"""Optional effects: a NamedTuple of parameters and an add_* function each; None has no effect.

To add one: write its NamedTuple and its function (and its `*_power` or `*_energy`), call them in
the model, and name it in the scene schema.
"""

from math import atan2, sqrt
from typing import Any, NamedTuple

from crane_sim.files.types import Angle, NonNegative, Real
from crane_sim.multibody.vectors import ZERO, add, dot, scale, subtract
from crane_sim.trajectories.inputs import Constant, value_at


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


def add_spring(spring, effort, q):
    """Return effort plus the spring's at coordinate q."""
    return effort if spring is None else effort - spring.stiffness * (q - spring.rest)


def add_spring_energy(spring, energy, q):
    """Return energy plus the spring's at coordinate q."""
    return energy if spring is None else energy + 0.5 * spring.stiffness * (q - spring.rest) ** 2


def add_jib_spring(spring, boom, jib, beta, gamma):
    """Return the moments (boom, jib) plus the spring's at elevations beta and gamma."""
    if spring is None:
        return boom, jib
    if spring.relative:
        moment = spring.stiffness * (gamma - beta - spring.rest)
        return boom + moment, jib - moment
    return boom, jib - spring.stiffness * (gamma - spring.rest)


def add_jib_spring_energy(spring, energy, beta, gamma):
    """Return energy plus the spring's at elevations beta and gamma."""
    if spring is None:
        return energy
    deflection = gamma - beta - spring.rest if spring.relative else gamma - spring.rest
    return energy + 0.5 * spring.stiffness * deflection**2


class PayloadDrag(NamedTuple):
    """Quadratic air drag on the payload: force -coefficient |v| v, v the velocity in still air."""

    coefficient: NonNegative  # kg/m, c of the force -c |v| v


def add_drag(drag, force, velocity):
    """Return the force (3,) plus the drag on a body at velocity (3,), both in the same axes."""
    if drag is None:
        return force
    return subtract(force, scale(drag.coefficient * sqrt(dot(velocity, velocity)), velocity))


class PayloadForce(NamedTuple):
    """A given force on the payload along the axes of the world: wind, a tag line, a push."""

    x: Any = Constant(0.0)  # N, of time: an input of `trajectories.inputs`
    y: Any = Constant(0.0)
    z: Any = Constant(0.0)


class NodeForce(NamedTuple):
    """A force along one axis of the base on one node."""

    node: int  # 1 .. N
    axis: int  # 0, 1, 2: x, y, z
    channel: Any  # N, of time: an input of `trajectories.inputs`


def values_of(forces, t):
    """Return the values [N] of forces on nodes at time t, as a tuple."""
    return tuple(value_at(force.channel, t) for force in forces or ())


def force_on_node(forces, values, k):
    """Return the force (3,) [N] on node k, given the values of all forces by `values_of`."""
    if forces is None:
        return 0, 0, 0
    total = ZERO
    for force, value in zip(forces, values, strict=True):
        own = value if force.node == k else 0.0
        x, y, z = (own if force.axis == axis else 0.0 for axis in range(3))
        total = add(total, (x, y, z))
    return total


def add_forces(forces, t, inv_masses, acc):
    """Add the forces at time t to the nodes' accelerations acc (N + 1, 3) [m/s²].

    `inv_masses` (N,) [1/kg] are those of the nodes.
    """
    for force in forces or ():
        acc[force.node, force.axis] += value_at(force.channel, t) * inv_masses[force.node - 1]


def force_power(forces, t, velocities):
    """Return the power [W] of the forces at node velocities (N + 1, 3) [m/s]."""
    power = 0.0
    for force in reversed(forces):
        power = value_at(force.channel, t) * velocities[force.node, force.axis] + power
    return power


class LinearFriction(NamedTuple):
    """Swing joint friction tangential cos²θ2 θ1' and radial θ2' [N m] (knuckle paper, eq. 19)."""

    tangential: NonNegative  # N m s, about the tangential swing's axis
    radial: NonNegative  # N m s, about the radial swing's axis

    def moments(self, n, w1, w2):
        """Return the friction moments [N m] about the two swing axes per unit of lever.

        Args:
            n: unit vector from tip to payload (3,), in the axes of the support's frame.
            w1: cos θ2 θ1', the tangential component of n' [1/s].
            w2: θ2', its radial component [1/s].

        Returns:
            (f1 / cos θ2, f2): what, divided by the rope length, pulls on the payload against ê1 and
            ê2.
        """
        return self.tangential * w1, self.radial * w2


class QuadraticFriction(NamedTuple):
    """Swing joint friction tangential cos²θ2 |θ1'| θ1' and radial |θ2'| θ2' [N m].

    It is that of the paper, eq. 14, corrected.
    """

    tangential: NonNegative  # N m s², about the tangential swing's axis
    radial: NonNegative  # N m s², about the radial swing's axis

    def moments(self, n, w1, w2):
        """Return as `LinearFriction.moments` does."""
        # θ1' = w1 / c2 has no limit at c2 = 0: there the model itself ends
        c2 = sqrt(n[1] * n[1] + n[2] * n[2])
        return self.tangential * abs(w1) * w1 / c2, self.radial * abs(w2) * w2


class PaperFriction(NamedTuple):
    """Swing joint friction tangential cos²θ2 |θ1| θ1' and radial |θ2| θ2' [N m].

    It is as the knuckle paper prints it.
    """

    tangential: NonNegative  # N m s, about the tangential swing's axis
    radial: NonNegative  # N m s, about the radial swing's axis

    def moments(self, n, w1, w2):
        """Return as `LinearFriction.moments` does."""
        c2 = sqrt(n[1] * n[1] + n[2] * n[2])
        theta1, theta2 = atan2(n[1], -n[2]), atan2(n[0], c2)
        return self.tangential * abs(theta1) * w1, self.radial * abs(theta2) * w2


SwingFriction = QuadraticFriction | LinearFriction | PaperFriction
