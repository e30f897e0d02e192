"""What carries the load, a support and a winch: accelerations, power, energies and guards."""

from typing import Any, NamedTuple

from crane_sim.models.carrier.layout import layout_of, rope_length, winch_index
from crane_sim.models.guards import LOWER, Guard, encode, smaller_guard
from crane_sim.models.moving_base import added_energy, to_world
from crane_sim.models.stops import length_guard
from crane_sim.models.supports.backlash import drive_accelerations, drive_energies, play_power
from crane_sim.models.supports.hoist import (
    hoist_guard,
    hoist_modes,
    hoist_reflected_mass,
    hoist_response,
)
from crane_sim.models.supports.joint_modes import support_guard, write_friction_rates
from crane_sim.models.supports.reeved_hoist import winch_energy
from crane_sim.models.supports.reeving import dead_end_of, follow_rope, reeving_of, sheave_factor
from crane_sim.models.supports.support import Posture, compute_posture, polyline, read_state
from crane_sim.models.supports.support_dynamics import (
    Dynamics,
    accelerations,
    base_efforts,
    compute_dynamics,
    drive_power,
    energy_by_base,
    joint_efforts,
    kinetic_energy,
    net_efforts,
    potential_energy,
    prescribed_accelerations,
    tip_efforts,
    wind_efforts,
    yaw_efforts,
)
from crane_sim.multibody import linear
from crane_sim.multibody.vectors import dot


class SupportMotion(NamedTuple):
    """A support at one instant."""

    pose: Posture
    dynamics: Dynamics
    command: Any  # efforts of the drives
    efforts: Any  # (n,) on the coordinates of drives, springs, base and wind, and the couple of
    # what hangs
    net: Any  # (n,) what accelerates the coordinates: `net_efforts`, and the force on the tip
    accelerations: Any  # (n,)


def posture_of(p, x):
    """Return the Posture of the support in state x."""
    return compute_posture(p.support, read_state(p.support, x, layout_of(p)[0]))


def move_support(p, t, pose, tau, flow, base, couple, force):
    """Return the SupportMotion.

    Args:
        p, t, pose: the crane, time [s], and the posture of its support.
        tau, flow, base: efforts of drives, wind in the base's axes, base.
        couple, force: about the vertical [N m], and (3,) [N] on the tip, in the tree's axes: of
            what hangs.
    """
    dynamics = compute_dynamics(p.support, pose)
    efforts = linear.add(joint_efforts(p.support, pose, tau), base_efforts(pose, base))
    efforts = linear.add(efforts, wind_efforts(pose, flow, base))
    efforts = linear.add(efforts, yaw_efforts(pose, couple))
    net = linear.add(net_efforts(dynamics, p.gravity, efforts), tip_efforts(pose, force))
    given = prescribed_accelerations(p.support, pose, t, tau)
    return SupportMotion(pose, dynamics, tau, efforts, net, accelerations(dynamics, net, given))


def mode_of_winch(p, x):
    """Return the mode of the winch in state x, 0 for one without friction."""
    return x[winch_index(p)] if hoist_modes(p.hoist) > 0 else 0.0


def winch_sticks(p, x):
    """Return whether friction holds the winch in state x."""
    return hoist_modes(p.hoist) > 0 and mode_of_winch(p, x) == 0.0


def winch_response(p, t, x, tau):
    """Return (inverse mass [1/kg], bias acceleration [m/s²]) of the length, see `hoist`."""
    return hoist_response(p.hoist, t, tau, mode_of_winch(p, x), rope_length(p, x), p.gravity)


def winch_guard(p, best, x, tau, pull):
    """Return the smaller one of `best` and the guard of the winch's friction under a pull [N]."""
    return hoist_guard(p.hoist, best, tau, mode_of_winch(p, x), rope_length(p, x), pull, p.gravity)


def fall_guard(p, best, x, acceleration, tension):
    """Return the smaller one of `best` and the least tension of falls and lead line, if any.

    Args:
        p, best, x: the crane, the smallest of the other guards, and the state.
        acceleration: of the first link's length [m/s²].
        tension: of the links (N,) [N].
    """
    reeving = reeving_of(p.hoist)
    if reeving is None:
        return best
    motion = (*rope_length(p, x), acceleration)
    factor = sheave_factor(reeving.loss, p.hoist.slip_direction(motion[1], mode_of_winch(p, x)))
    dead_end = dead_end_of(reeving, factor, tension[0], motion, p.gravity)
    _, _, smallest, _ = follow_rope(reeving, factor, dead_end, motion, p.gravity)
    return smaller_guard(best, smallest, encode(Guard.LINK, len(tension)))


def write_common_rates(p, x, solved, out):
    """Write rates of coordinates and modes, and the accelerations of support, drives and hoist.

    `solved` has the SupportMotion `support` and the acceleration `length` [m/s²] of the hoist's
    length.
    """
    (nq, first, modes), support = layout_of(p), solved.support
    n = len(support.accelerations)
    for i in range(nq):
        out[i] = x[nq + i]
    for i in range(n):
        out[nq + i] = support.accelerations[i]
    for i, drive_acc in enumerate(
        drive_accelerations(p.support.drives, support.command, support.pose)
    ):
        out[nq + n + i] = drive_acc
    if p.hoist is not None:
        out[nq + first - 1] = solved.length
    for i in range(modes, len(out)):
        out[i] = 0.0
    write_friction_rates(p.support, support.pose.state, out)


def support_power(p, solved):
    """Return the power [W] that the support's drives supply, their losses taken off."""
    support = solved.support
    power = drive_power(
        support.pose, support.dynamics, support.efforts, support.net, support.accelerations
    )
    return power + play_power(p.support.drives, support.command, support.pose)


def winch_power(p, x, solved):
    """Return the power [W] of the winch less its losses, where `solved.paid` [N] pulls on it."""
    if p.hoist is None:
        return 0.0
    motion = (*rope_length(p, x), solved.length)
    return p.hoist.power(
        solved.support.command, mode_of_winch(p, x), motion, solved.paid, p.gravity
    )


def carrier_energies(p, base, x, pose):
    """Return the energies [J] of structure, drives and winch.

    Returns:
        kinetic and potential energy relative to the base, and those that the base, a BaseState or
        None, adds.
    """
    kinetic, potential = drive_energies(p.support.drives, pose.state)
    dynamics, (length, rate) = compute_dynamics(p.support, pose), rope_length(p, x)
    wound, hung = winch_energy(p.hoist, length, rate, p.gravity)
    kinetic += (
        kinetic_energy(pose, dynamics) + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate + wound
    )
    potential += potential_energy(pose, dynamics, p.gravity) + hung
    added = (0.0, 0.0) if base is None else energy_by_base(pose, base, p.gravity)
    return kinetic, potential, *added


def node_energies(base, mass, node, gravity):
    """Return energies [J] of a mass at a node (position, velocity) as `carrier_energies` does."""
    position, velocity = node
    added = (0.0, 0.0) if base is None else added_energy(base, gravity, mass, position, velocity)
    return 0.5 * mass * dot(velocity, velocity), mass * gravity * position[2], *added


def support_limits_guard(p, x):
    """Return the smallest guard of what ends a run, slipping joints, and drives with play."""
    best = 1e300, encode(Guard.LENGTH, LOWER)
    if p.stops is None:
        return best
    best = length_guard(p.stops, best, *rope_length(p, x))
    return support_guard(p.support, best, read_state(p.support, x, layout_of(p)[0]))


def write_polyline(pose, base, out):
    """Write the support's polyline in the world into the rows of `out`; return their number."""
    points = polyline(pose)
    for i, point in enumerate(points):
        out[i, 0], out[i, 1], out[i, 2] = to_world(base, point)
    return len(points)
