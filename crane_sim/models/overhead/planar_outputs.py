"""Outputs of a chain in the plane: energies, tensions, points; its guards, and what events change.

On a moving base energies are those relative to it. What it adds, mass by mass, leaves out an axis with prescribed
motion, which has no mass, and the drum's reflected mass, which does not rotate with the base.
"""

from math import cos, sin

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import COS, INV_MASS, LENGTH, RATE, SIN, TENSION, joint_energy, rod_energy
from crane_sim.models.cables.chain_3d import row_of
from crane_sim.models.guards import Guard, decode, encode, friction_event, smaller_guard
from crane_sim.models.moving_base import added_energy, added_spin, base_state, pose_at, to_world
from crane_sim.models.overhead import first_link, layout_of
from crane_sim.models.overhead.events import (
    initial_modes,
    mode_of_stopped_drive,
    needs_forces,
    smallest_drive_guard,
)
from crane_sim.models.overhead.planar import PlanarCrane, chain_power
from crane_sim.models.supports.hoist import HOIST, hoist_reflected_mass
from crane_sim.models.supports.rails import axis_mass
from crane_sim.numerics.jit import routine


@system.state.register(PlanarCrane)
def initial_state(p, t, q, v):
    """Return the state, with the modes that follow from velocities."""
    (nq, _, first), modes = layout_of(p), initial_modes(p, t, v)
    x = np.zeros(first + len(modes))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    for i, mode in enumerate(modes):
        x[first + i] = mode
    return x


@system.power.register(PlanarCrane)
def external_power(p, t, x, u):
    """Return the power [W] under a source of efforts."""
    tau, work = system.effort(u, p, t, x), system.workspace(p)
    return chain_power(p, t, x, tau, p.solve(t, x, tau, work), work)


@system.tensions.register(PlanarCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    work = system.workspace(p)
    p.solve(t, x, system.effort(u, p, t, x), work)
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = work[TENSION, k]


@system.kinetic.register(PlanarCrane)
@routine
def kinetic_energy(p, x):
    """Return the kinetic energy [J] of trolley, hoist, links and nodes."""
    (nq, first, _), work, rate = layout_of(p), system.workspace(p), first_link(p, x)[1]
    p.fill_links(x, work)
    v = p.node_velocities(x, work)
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2
    kinetic += 0.5 * hoist_reflected_mass(p.hoist) * rate * rate
    kinetic += rod_energy(p.rods, x[nq + first : 2 * nq])
    for k in range(len(p.cable.masses)):
        mass = 1.0 / work[INV_MASS, k]
        kinetic += 0.5 * mass * (v[k + 1, 0] ** 2 + v[k + 1, 1] ** 2 + v[k + 1, 2] ** 2)
    return kinetic


@system.potential.register(PlanarCrane)
@routine
def potential_energy(p, x):
    """Return the potential energy [J] of nodes and joints."""
    nq, first, _ = layout_of(p)
    w = system.workspace(p)
    p.fill_links(x, w)
    z, potential = 0.0, joint_energy(p.joints, x[first:nq])
    for k in range(len(p.cable.masses)):
        z = z - w[LENGTH, k] * w[COS, k]
        potential += 1.0 / w[INV_MASS, k] * p.gravity * z
    return potential


@system.points.register(PlanarCrane)
def write_points(p, t, x, out):
    """Write trolley and nodes."""
    (_, first, _), length = layout_of(p), first_link(p, x)[0]
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for k in range(len(p.cable.masses)):
        link = length if k == 0 else p.cable.lengths[k]
        out[k + 1, 0] = out[k, 0] + link * sin(x[first + k])
        out[k + 1, 1] = 0.0
        out[k + 1, 2] = out[k, 2] - link * cos(x[first + k])
    if p.base is not None:
        pose = pose_at(p.base, t)
        for k in range(len(out)):
            out[k, 0], out[k, 1], out[k, 2] = to_world(pose, row_of(out, k))


@system.base_energy.register(PlanarCrane)
@routine
def base_energy(p, t, x):
    """Return what a moving base adds to the energies of trolley, nodes, and links that rotate as rods."""
    base, w = base_state(p.base, t, 0.0), system.workspace(p)
    if base is None:
        return 0.0, 0.0
    p.fill_links(x, w)
    velocity, position = p.node_velocities(x, w), (x[0], 0.0, 0.0)
    kinetic, potential = added_energy(base, p.gravity, axis_mass(p.trolley), position, row_of(velocity, 0))
    for k in range(len(p.cable.masses)):
        position = position[0] + w[LENGTH, k] * w[SIN, k], 0.0, position[2] - w[LENGTH, k] * w[COS, k]
        more = added_energy(base, p.gravity, 1.0 / w[INV_MASS, k], position, row_of(velocity, k + 1))
        kinetic, potential = kinetic + more[0], potential + more[1]
        if p.rods is not None:  # angles of links grow against turns about y
            tensor = 0.0, p.rods.inertia[k], (0.0, 1.0, 0.0)
            kinetic += added_spin(base, tensor, (0.0, -w[RATE, k], 0.0))
    return kinetic, potential


@system.guard.register(PlanarCrane)
@routine
def smallest_guard(p, t, x, u, work):
    """Return the smallest guard, of drives, payload and links that must stay taut."""
    tau, forces = system.effort(u, p, t, x), needs_forces(p, x)
    pull = p.solve(t, x, tau, work).pull if forces else 0.0
    best = smallest_drive_guard(p, t, x, tau, work[TENSION, 0], pull, first_link(p, x)[0])
    if p.event_limits.stops.taut > 0.0:
        for k in range(len(p.cable.masses)):
            best = smaller_guard(best, work[TENSION, k], encode(Guard.LINK, k))
    return best[0], best[1], int(forces)


@system.apply_reset_map.register(PlanarCrane)
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
        rate, mode = (nq + first - 1, len(x) - 2) if joint == HOIST else (nq, modes)
        mode_before, work = x[mode], system.workspace(p)
        x[rate], x[mode] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
        pull = p.solve(t, x, tau, work).pull
        x[mode] = mode_of_stopped_drive(p, joint, mode_before, tau, work[TENSION, 0], pull)
        return x, friction_event(joint, x[mode]), True
    return x, number, False
