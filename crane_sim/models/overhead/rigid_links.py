"""What cranes with rigid links in the plane and in space have in common.

Their classes have methods for what differs: `solve`, `tensions`, `inv_masses`, `fill_links`, `node_velocities`,
`write_nodes` and `payload_position`.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import rod_energy
from crane_sim.models.effects import force_power
from crane_sim.models.guards import Guard, decode, friction_event
from crane_sim.models.overhead import count_axes, first_link, layout_of
from crane_sim.models.overhead.events import (
    drives_power,
    mode_of_stopped_drive,
    needs_forces,
    smallest_drive_guard,
)
from crane_sim.models.overhead.modes import count_modes, initial_modes, slack_guard, write_mode_rate
from crane_sim.models.supports.hoist import HOIST, hoist_modes, hoist_reflected_mass
from crane_sim.models.supports.rails import axis_mass
from crane_sim.numerics.jit import routine


class Solution(NamedTuple):
    """Accelerations and forces at one instant, in addition to the work arrays."""

    axes: tuple[float, ...]  # m/s²
    paid: float  # m/s², of the first link's length
    pulls: tuple[float, ...]  # N, of the cable and of a moving base on the axes
    outside_power: float  # W, that moving base and wind supply, less what joints between links take
    top: Any = None  # of links in space: `UpperEnd`


def initial_state(p, t, q, v):
    """Return the state, with the modes that follow from velocities."""
    nq, _, modes = layout_of(p)
    axes = count_axes(p)
    x = np.zeros(modes + count_modes(p.event_limits, axes + hoist_modes(p.hoist)))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    for i, mode in enumerate(initial_modes(p, axes, t, v)):
        x[modes + i] = mode
    return x


def write_others(p, t, x, tau, solved, work, out):
    """Write the derivatives of all but positions and the cable's rates: of axes, hoist, energy supplied and modes."""
    nq, first, modes = layout_of(p)
    for axis, acceleration in enumerate(solved.axes):
        out[nq + axis] = acceleration
    if p.hoist is not None:
        out[nq + first - 1] = solved.paid
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if p.energy_meter is not None:
        out[2 * nq] = chain_power(p, t, x, tau, solved, work)
    for i, axis in enumerate((p.trolley, p.bridge)[: len(solved.axes)]):
        write_mode_rate(p.event_limits, axis, x[nq + i], x, modes + i, out)


def chain_power(p, t, x, tau, solved, work):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    power = drives_power(p, x, tau, p.tensions(work)[0], solved.pulls, first_link(p, x)[1]) + solved.outside_power
    return power + (0.0 if p.forces is None else force_power(p.forces, t, p.node_velocities(x, work)))


def external_power(p, t, x, u):
    """Return the power [W] under a source of efforts."""
    tau, work = system.effort(u, p, t, x), system.workspace(p)
    return chain_power(p, t, x, tau, p.solve(t, x, tau, work), work)


def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    work = system.workspace(p)
    p.solve(t, x, system.effort(u, p, t, x), work)
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = p.tensions(work)[k]


@routine
def kinetic_energy(p, x):
    """Return the kinetic energy [J] of axes, hoist, links and nodes."""
    (nq, first, _), work, rate = layout_of(p), system.workspace(p), first_link(p, x)[1]
    p.fill_links(x, work)
    v, inv_masses = p.node_velocities(x, work), p.inv_masses(work)
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2
    if p.bridge is not None:
        kinetic += 0.5 * axis_mass(p.bridge) * x[nq + 1] ** 2
    kinetic += 0.5 * hoist_reflected_mass(p.hoist) * rate * rate
    kinetic += rod_energy(p.rods, x[nq + first : 2 * nq])
    for k in range(len(p.cable.masses)):
        mass = 1.0 / inv_masses[k]
        kinetic += 0.5 * mass * (v[k + 1, 0] ** 2 + v[k + 1, 1] ** 2 + v[k + 1, 2] ** 2)
    return kinetic


@routine
def smallest_guard(p, t, x, u, work):
    """Return the smallest guard, of drives, payload and links that must stay taut."""
    tau, forces, tensions = system.effort(u, p, t, x), needs_forces(p, x), p.tensions(work)
    pulls = p.solve(t, x, tau, work).pulls if forces else (0.0,) * count_axes(p)
    best = smallest_drive_guard(p, t, x, tau, tensions[0], pulls, first_link(p, x)[0])
    value, number = slack_guard(p.event_limits, best, tensions, len(p.cable.masses))
    return value, number, int(forces)


@routine
def switch(p, t, x, u, number):
    """Return the state after a change of the payload or of a drive's friction; all other guards end a run."""
    (nq, first, modes), (kind, joint, _) = layout_of(p), decode(number)
    tau, x = system.effort(u, p, t, x), x.copy()
    if kind == Guard.PAYLOAD:
        before = system.kinetic(p, x) + system.potential(p, x)
        x[len(x) - 1] += 1.0
        gained = system.kinetic(p, x) + system.potential(p, x) - before  # the payload takes its energy along
        x[2 * nq] += gained
        return x, number, True
    if kind == Guard.FRICTION:
        rate, mode = (nq + first - 1, len(x) - 2) if joint == HOIST else (nq + joint, modes + joint)
        mode_before, work = x[mode], system.workspace(p)
        x[rate], x[mode] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
        pulls = p.solve(t, x, tau, work).pulls
        x[mode] = mode_of_stopped_drive(p, joint, mode_before, tau, p.tensions(work)[0], pulls)
        return x, friction_event(joint, x[mode]), True
    return x, number, False
