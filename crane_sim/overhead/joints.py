"""Stiffness and damping where links meet: couples on the links, which their ends' nodes feel as forces across."""

from typing import Any, NamedTuple

from crane_sim.jit import lean_generic
from crane_sim.overhead.chain import BELOW, COS, LENGTH, RATE, SIN, nudge


class Joints(NamedTuple):
    """Stiffness and damping between links, (N,) arrays; the first one is between the trolley and link 1."""

    stiffness: Any  # N m/rad
    damping: Any  # N m s/rad


@lean_generic
def add_joints(joints, w, x, first):
    """Add what the joints' moments ask of the links, with angles from x[first] on; return the force on the trolley."""
    return 0.0


@add_joints.register(Joints)
def _(joints, w, x, first):
    n = len(joints.stiffness)
    moment, pull = joints.stiffness[0] * x[first] + joints.damping[0] * w[RATE, 0], 0.0
    for k in range(n):
        after = 0.0
        if k + 1 < n:
            after = joints.stiffness[k + 1] * (x[first + k + 1] - x[first + k])
            after += joints.damping[k + 1] * (w[RATE, k + 1] - w[RATE, k])
        force = (after - moment) / w[LENGTH, k]  # the couple of link k: on its lower node, and back on its upper one
        if k > 0:
            nudge(w, k, -force * w[BELOW, k - 1] * w[COS, k], -force * w[BELOW, k - 1] * w[SIN, k])
        else:
            pull = -force * w[COS, 0]
        nudge(w, k + 1, force * w[BELOW, k] * w[COS, k], force * w[BELOW, k] * w[SIN, k])
        moment = after
    return pull


@lean_generic
def joint_energy(joints, angles):
    """Return the energy [J] stored in the joints."""
    return 0.0


@joint_energy.register(Joints)
def _(joints, angles):
    energy = 0.5 * joints.stiffness[0] * angles[0] ** 2
    for k in range(1, len(angles)):
        energy += 0.5 * joints.stiffness[k] * (angles[k] - angles[k - 1]) ** 2
    return energy


@lean_generic
def joint_power(joints, rates):
    """Return the power [W] that the joints' damping takes, negative."""
    return 0.0


@joint_power.register(Joints)
def _(joints, rates):
    power = -joints.damping[0] * rates[0] ** 2
    for k in range(1, len(rates)):
        power -= joints.damping[k] * (rates[k] - rates[k - 1]) ** 2
    return power
