"""External forces on nodes: wind on the payload, a tag line, a push."""

from typing import Any, NamedTuple

from crane_sim.numerics.jit import generic
from crane_sim.trajectories.inputs import value_at


class NodeForces(NamedTuple):
    """A force along one axis of the base on one node, and the others: a linked list, unrolled at compile time."""

    node: int  # 1 .. N
    axis: int  # 0, 1, 2: x, y, z
    channel: Any  # N, of time: an input of `trajectories.inputs`
    tail: Any = None


@generic
def add_forces(forces, t, inv_masses, acc):
    """Add the forces at time t to the nodes' accelerations acc (N + 1, 3) [m/s²]; `inv_masses` (N,) [1/kg]."""


@add_forces.register(NodeForces)
def _(forces, t, inv_masses, acc):
    acc[forces.node, forces.axis] += value_at(forces.channel, t) * inv_masses[forces.node - 1]
    add_forces(forces.tail, t, inv_masses, acc)


@generic
def force_power(forces, t, velocities):
    """Return the power [W] of the forces at node velocities (N + 1, 3) [m/s]."""
    return 0.0


@force_power.register(NodeForces)
def _(forces, t, velocities):
    power = value_at(forces.channel, t) * velocities[forces.node, forces.axis]
    return power + force_power(forces.tail, t, velocities)
