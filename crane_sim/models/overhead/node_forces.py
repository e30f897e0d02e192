"""External forces on nodes: wind on the payload, a tag line, a push."""

from typing import Any, NamedTuple

from crane_sim.trajectories.inputs import value_at


class NodeForce(NamedTuple):
    """A force along one axis of the base on one node."""

    node: int  # 1 .. N
    axis: int  # 0, 1, 2: x, y, z
    channel: Any  # N, of time: an input of `trajectories.inputs`


def add_forces(forces, t, inv_masses, acc):
    """Add the forces at time t to the nodes' accelerations acc (N + 1, 3) [m/s²]; `inv_masses` (N,) [1/kg]."""
    for force in forces or ():
        acc[force.node, force.axis] += value_at(force.channel, t) * inv_masses[force.node - 1]


def force_power(forces, t, velocities):
    """Return the power [W] of the forces at node velocities (N + 1, 3) [m/s]."""
    power = 0.0
    for force in reversed(forces):
        power = value_at(force.channel, t) * velocities[force.node, force.axis] + power
    return power
